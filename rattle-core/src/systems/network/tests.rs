//! Orders of elimination against those of faer and against the best there are; factors against their matrices.

use super::factor::Factor;
use super::hubs::Hubs;
use super::order::minimum_degree;
use super::pattern::Pattern;
use std::mem::replace;

const NONE: usize = usize::MAX;

type Links = Vec<[usize; 2]>;

/// Links, and the entries of L below the diagonal in the order of faer 0.24.4 (`sparse::linalg::amd::order` with its
/// default control, on the pattern of the rows that share a body).
fn families() -> Vec<(&'static str, Links, usize)> {
    vec![
        ("chain of 1000", (0..1000).map(|i| [i, i + 1]).collect(), 999),
        ("chain of 100 000", (0..100_000).map(|i| [i, i + 1]).collect(), 99_999),
        ("ring of 1000", (0..1000).map(|i| [i, (i + 1) % 1000]).collect(), 1997),
        ("binary tree of 1000", (0..1000).map(|i| [i / 2, i + 1]).collect(), 1623),
        ("tree of 1000", tree(1000), 1917),
        ("tree of 100 000", tree(100_000), 205_809),
        ("star of 600", (0..600).map(|i| [0, i + 1]).collect(), 179_700),
        ("ladder of 1000", ladder(1000), 7993),
        ("net of 30 × 30", net(30), 25_414),
        ("net of 60 × 60", net(60), 128_844),
        ("net of 160 × 160", net(160), 1_177_951),
        ("lattice of 12 × 12 × 12", lattice(12), 330_622),
        ("450 links of 300 bodies", random(300, 450), 10_405),
        ("1200 links of 1000 bodies", random(1000, 1200), 29_595),
        ("1500 links of 1000 bodies", random(1000, 1500), 95_800),
    ]
}

fn draw(state: &mut u64, below: usize) -> usize {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 33) as usize % below
}

fn tree(links: usize) -> Links {
    let mut state = 5;
    (0..links).map(|i| [draw(&mut state, i + 1), i + 1]).collect()
}

fn ladder(rungs: usize) -> Links {
    (0..rungs).flat_map(|i| [[2 * i, 2 * i + 1], [2 * i, 2 * i + 2], [2 * i + 1, 2 * i + 3]]).collect()
}

fn net(squares: usize) -> Links {
    let (n, knot) = (squares + 1, |i: usize, j: usize| i * (squares + 1) + j);
    let along = (0..n).flat_map(|i| (1..n).map(move |j| [knot(i, j - 1), knot(i, j)]));
    let across = (0..n).flat_map(|j| (1..n).map(move |i| [knot(i - 1, j), knot(i, j)]));
    along.chain(across).collect()
}

fn lattice(n: usize) -> Links {
    let at = move |i: usize| [i / n / n, i / n % n, i % n];
    let steps = [n * n, n, 1].into_iter().enumerate();
    let ahead = |i| steps.clone().filter(move |&(axis, _)| at(i)[axis] + 1 < n).map(move |(_, s)| [i, i + s]);
    (0..n * n * n).flat_map(ahead).collect()
}

fn random(bodies: usize, links: usize) -> Links {
    let mut state = 11;
    let drawn = std::iter::repeat_with(|| [draw(&mut state, bodies), draw(&mut state, bodies)]);
    drawn.filter(|[a, b]| a != b).take(links).collect()
}

fn rows_of_body(links: &Links) -> Vec<Vec<usize>> {
    let bodies = links.iter().flatten().max().map_or(0, |&last| last + 1);
    let mut rows = vec![Vec::new(); bodies];
    for (row, link) in links.iter().enumerate() {
        link.iter().for_each(|&body| rows[body].push(row));
    }
    rows
}

/// Neighbours of each row: the others on its bodies.
fn neighbours(rows_of_body: &[Vec<usize>], m: usize) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); m];
    for rows in rows_of_body {
        rows.iter().for_each(|&i| neighbours[i].extend(rows.iter().copied().filter(|&j| j != i)));
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    neighbours
}

/// Entries of L below the diagonal, row by row up the elimination tree; the order has every row once.
fn entries(neighbours: &[Vec<usize>], order: &[usize]) -> usize {
    let m = neighbours.len();
    let mut rank = vec![NONE; m];
    for (k, &row) in order.iter().enumerate() {
        assert_eq!(replace(&mut rank[row], k), NONE, "row {row} twice");
    }
    assert_eq!(order.len(), m);
    let (mut parent, mut seen, mut entries) = (vec![NONE; m], vec![NONE; m], 0);
    for k in 0..m {
        for &row in &neighbours[order[k]] {
            let mut j = rank[row];
            while j < k && seen[j] != k {
                (seen[j], entries) = (k, entries + 1);
                parent[j] = parent[j].min(k);
                j = parent[j];
            }
        }
    }
    entries
}

#[test]
fn fill_is_that_of_faer() {
    for (name, links, by_faer) in families() {
        let (rows, m) = (rows_of_body(&links), links.len());
        let found = entries(&neighbours(&rows, m), &minimum_degree(&rows, m));
        println!("{name}: {found} entries, {:.3} of faer's", found as f64 / by_faer as f64);
        assert!(found as f64 <= 1.05 * by_faer as f64, "{name}: {found} entries, by faer {by_faer}");
    }
}

#[test]
fn trees_fill_in_nothing() {
    let trees = [tree(1000), tree(100_000), (0..1000).map(|i| [i / 3, i + 1]).collect()];
    for links in trees {
        let (rows, m) = (rows_of_body(&links), links.len());
        let neighbours = neighbours(&rows, m);
        let before = neighbours.iter().map(Vec::len).sum::<usize>() / 2;
        assert_eq!(entries(&neighbours, &minimum_degree(&rows, m)), before);
    }
}

/// The fewest entries of L in any order, by the sets of rows that go first: a row takes those that it reaches through
/// them.
fn fewest(neighbours: &[Vec<usize>]) -> usize {
    let m = neighbours.len();
    let reaches = |first: usize, row: usize| {
        let (mut seen, mut ahead) = (1_usize << row, vec![row]);
        while let Some(i) = ahead.pop() {
            let new = neighbours[i].iter().filter(|&&j| seen & (1 << j) == 0).copied().collect::<Vec<_>>();
            new.iter().for_each(|&j| seen |= 1 << j);
            ahead.extend(new.into_iter().filter(|&j| first & (1 << j) != 0));
        }
        (seen & !first).count_ones() as usize - 1
    };
    let mut fewest = vec![0; 1 << m];
    for set in 1_usize..1 << m {
        let last = (0..m).filter(|&row| set & (1 << row) != 0);
        let with = |row: usize| fewest[set & !(1 << row)] + reaches(set & !(1 << row), row);
        fewest[set] = last.map(with).min().unwrap_or(0);
    }
    fewest[(1 << m) - 1]
}

#[test]
fn small_graphs_fill_in_hardly_more_than_they_must() {
    let (mut state, mut found, mut least, mut graphs) = (3, 0, 0, 0);
    for _ in 0..60 {
        let links: Links = std::iter::repeat_with(|| [draw(&mut state, 8), draw(&mut state, 8)])
            .filter(|[a, b]| a != b)
            .take(11)
            .collect();
        let (rows, m) = (rows_of_body(&links), links.len());
        let neighbours = neighbours(&rows, m);
        let (by_degree, best) = (entries(&neighbours, &minimum_degree(&rows, m)), fewest(&neighbours));
        assert!(
            by_degree >= best && by_degree <= best + 3,
            "{links:?}: {by_degree} entries, {best} are enough"
        );
        (found, least, graphs) = (found + by_degree, least + best, graphs + 1);
    }
    println!("{graphs} graphs: {found} entries, at least {least}");
    assert!(found as f64 <= 1.01 * least as f64, "{found} entries, {least} are enough");
}

/// Any matrix on a pattern, not symmetric, with a heavy diagonal; by ranks.
fn matrix(pattern: &Pattern, neighbours: &[Vec<usize>]) -> Vec<Vec<(usize, f64)>> {
    let mut state = 7;
    let mut entry = || draw(&mut state, 1000) as f64 / 1000.0 - 0.5;
    let mut row = |k: usize| {
        let others = neighbours[pattern.order[k]].iter().map(|&row| (pattern.rank_of[row], entry()));
        let mut row: Vec<_> = others.collect();
        row.push((k, row.len() as f64 + 1.0));
        row
    };
    (0..neighbours.len()).map(&mut row).collect()
}

fn factored<const WIDE: bool>(pattern: &Pattern, matrix: &[Vec<(usize, f64)>]) -> (Factor, Vec<f64>) {
    let mut factor = Factor::new(pattern);
    let mut eliminate = |k: usize| {
        matrix[k].iter().for_each(|&(column, entry)| factor.line[column] += entry);
        factor.eliminate::<WIDE>(pattern, k)
    };
    let pivots = (0..matrix.len()).map(&mut eliminate).collect();
    (factor, pivots)
}

#[test]
fn factors_solve_and_rows_together_change_no_bit() {
    let graphs = [net(20), lattice(6), random(300, 450), (0..40).map(|i| [0, i + 1]).collect(), tree(300)];
    let mut widest = 0;
    for links in graphs {
        let (rows, m) = (rows_of_body(&links), links.len());
        let pattern = Pattern::new(&rows, m);
        let matrix = matrix(&pattern, &neighbours(&rows, m));
        let right: Vec<f64> = (0..m).map(|row| (row % 7) as f64 - 3.0).collect();
        let solved = |(factor, pivots): (Factor, Vec<f64>)| {
            let (mut x, mut room) = (vec![0.0; m], vec![0.0; m]);
            factor.solve(&pattern, 1.0, &right, &mut x, &mut room);
            (x, pivots)
        };
        let (x, pivots) = solved(factored::<true>(&pattern, &matrix));
        let one_by_one = solved(factored::<false>(&pattern, &matrix));
        assert!((&x, &pivots) == (&one_by_one.0, &one_by_one.1), "bits differ");
        for (k, row) in matrix.iter().enumerate() {
            let left: f64 = row.iter().map(|&(column, entry)| entry * x[pattern.order[column]]).sum();
            let off = (left - right[pattern.order[k]]).abs();
            assert!(off <= 1e-13, "row {k} is off by {off:e}");
        }
        widest = widest.max(pattern.widest);
    }
    assert!(widest >= 40, "{widest} rows alike at most");
}

/// Operations of one factorisation: what each row of U costs where it is subtracted.
fn operations(links: &Links) -> usize {
    let rows = rows_of_body(links);
    let pattern = match Hubs::split(&rows, links.len(), 3) {
        Some((_, pattern)) => pattern,
        None => Pattern::new(&rows, links.len()),
    };
    pattern.upper_start.windows(2).map(|at| (1 + at[1] - at[0]).pow(2)).sum()
}

#[test]
fn operations_are_linear_in_the_links() {
    type Family = (&'static str, fn(usize) -> Links);
    let families: [Family; 7] = [
        ("star", |n| (0..n).map(|i| [0, i + 1]).collect()),
        ("path", |n| (0..n).map(|i| [i, i + 1]).collect()),
        ("binary tree", |n| (0..n).map(|i| [i / 2, i + 1]).collect()),
        ("random tree", tree),
        ("tree of hubs", |n| (0..n).map(|i| [i / 50, i + 1]).collect()),
        ("wheel", |n| {
            (0..n)
                .map(|i| if i % 2 == 0 { [0, i / 2 + 1] } else { [i / 2 + 1, (i / 2 + 1) % (n / 2) + 1] })
                .collect()
        }),
        ("two hubs", |n| (0..n).map(|i| [i % 2, i / 2 + 2]).collect()),
    ];
    for (name, links) in families {
        for n in [100, 1000, 10_000, 100_000] {
            let each = operations(&links(n)) as f64 / n as f64;
            println!("{name} of {n}: {each:.1} operations a link");
            assert!(each <= 40.0, "{name} of {n}: {each}");
        }
    }
}
