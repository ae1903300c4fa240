//! The sparsity pattern of L and U, found once from the rows that share a body.

use crate::systems::network::order::minimum_degree;

/// An order of elimination, and the columns of L and U, on one symmetric pattern.
#[derive(Debug, Clone)]
pub(crate) struct Pattern {
    /// The row that is eliminated k-th, and its inverse.
    pub(crate) order: Vec<usize>,
    pub(super) rank_of: Vec<usize>,
    /// Columns of L in row k, ascending, and where they begin.
    pub(crate) lower: Vec<usize>,
    pub(crate) lower_start: Vec<usize>,
    /// Columns of U in row k, ascending.
    pub(crate) upper: Vec<usize>,
    pub(crate) upper_start: Vec<usize>,
    /// Rows k to `alike[k]` of U have the same columns, as far as these are beyond the rows themselves.
    pub(super) alike: Vec<usize>,
    /// How many rows are alike at most.
    pub(super) widest: usize,
    /// Entries of the lower triangle before elimination.
    pub(super) entries: usize,
}

impl Pattern {
    /// For m rows, given those of each body.
    pub(crate) fn new(rows_of_body: &[Vec<usize>], m: usize) -> Self {
        let graph = Graph::new(rows_of_body, m);
        Self::of(graph.entries(), graph.least())
    }

    /// For rows that are eliminated in this order, but for what it leaves open.
    pub(super) fn ordered(rows_of_body: &[Vec<usize>], order: Vec<usize>) -> Self {
        let graph = Graph::new(rows_of_body, order.len());
        Self::of(graph.entries(), graph.all_ways(graph.all_ways(order).postorder()))
    }

    /// For m rows, each of which shares a body with every other, or may: in turn.
    pub(crate) fn full(m: usize) -> Self {
        let of_one_body = [(0..m).collect()];
        let graph = Graph::new(&of_one_body, m);
        Self::of(graph.entries(), graph.all_ways((0..m).collect()))
    }

    fn of(entries: usize, ways: Ways) -> Self {
        let Ways { order, rank_of, lower, lower_start, parent } = ways;
        let m = order.len();
        let mut upper_start = vec![0; m + 1];
        lower.iter().for_each(|&k| upper_start[k + 1] += 1);
        (0..m).for_each(|k| upper_start[k + 1] += upper_start[k]);
        let (mut next, mut upper) = (upper_start.clone(), vec![0; lower.len()]);
        for row in 0..m {
            for &k in &lower[lower_start[row]..lower_start[row + 1]] {
                upper[next[k]] = row;
                next[k] += 1;
            }
        }
        let mut alike: Vec<usize> = (1..=m).collect();
        for k in (1..m).rev() {
            let columns = |k: usize| upper_start[k + 1] - upper_start[k];
            if parent[k - 1] == k && columns(k - 1) == columns(k) + 1 {
                alike[k - 1] = alike[k];
            }
        }
        let widest = (0..m).map(|k| alike[k] - k).max().unwrap_or(0);
        Self { order, rank_of, lower, lower_start, upper, upper_start, alike, widest, entries }
    }
}

/// Which rows share a body.
struct Graph<'a> {
    rows_of: &'a [Vec<usize>],
    bodies_of: Vec<Vec<usize>>,
}

/// L for one order: the entries of row k lie on the ways up the elimination tree (J. Liu, SIAM J. Matrix Anal. Appl. 11
/// (1990) 134).
struct Ways {
    order: Vec<usize>,
    rank_of: Vec<usize>,
    lower: Vec<usize>,
    lower_start: Vec<usize>,
    /// The tree: the first entry of L below each diagonal, or [`NONE`].
    parent: Vec<usize>,
}

const NONE: usize = usize::MAX;

impl<'a> Graph<'a> {
    fn new(rows_of: &'a [Vec<usize>], m: usize) -> Self {
        let mut bodies_of = vec![Vec::new(); m];
        for (body, rows) in rows_of.iter().enumerate() {
            rows.iter().for_each(|&row| bodies_of[row].push(body));
        }
        Self { rows_of, bodies_of }
    }

    /// The other rows on a row's bodies, more than once if they share more than one.
    fn neighbours(&self, row: usize) -> impl Iterator<Item = usize> {
        let rows = self.bodies_of[row].iter().flat_map(|&body| &self.rows_of[body]);
        rows.copied().filter(move |&other| other != row)
    }

    /// Pairs of neighbours.
    fn entries(&self) -> usize {
        let mut seen = vec![NONE; self.bodies_of.len()];
        let mut first = |row, other: usize| std::mem::replace(&mut seen[other], row) != row;
        let rows = 0..self.bodies_of.len();
        rows.map(|row| self.neighbours(row).filter(|&other| first(row, other)).count()).sum::<usize>() / 2
    }

    /// The rows as they are named, if that fills in no more than an order of minimum degree: memory is then read in
    /// turn.
    fn least(&self) -> Ways {
        let m = self.bodies_of.len();
        let within = |most| self.ways((0..m).collect(), most);
        if let Some(order) = self.chain_from_both_ends() {
            return self.all_ways(order);
        }
        within(self.entries()).unwrap_or_else(|| {
            let reordered = self.all_ways(minimum_degree(self.rows_of, m));
            within(reordered.lower.len()).unwrap_or_else(|| self.all_ways(reordered.postorder()))
        })
    }

    fn all_ways(&self, order: Vec<usize>) -> Ways {
        self.ways(order, usize::MAX).expect("no bound on the entries")
    }

    /// None if L has more than so many entries: as named, a tree may have m²/2.
    fn ways(&self, order: Vec<usize>, most: usize) -> Option<Ways> {
        let m = order.len();
        let mut rank_of = vec![0; m];
        order.iter().enumerate().for_each(|(k, &row)| rank_of[row] = k);
        // The rows of a body are all neighbours: each is on the way up from the first.
        let first = |rows: &Vec<usize>| rows.iter().map(|&row| rank_of[row]).min().unwrap_or(m);
        let first: Vec<usize> = self.rows_of.iter().map(first).collect();
        let (mut parent, mut seen) = (vec![NONE; m], vec![NONE; m]);
        let (mut lower, mut lower_start) = (Vec::new(), vec![0]);
        for k in 0..m {
            seen[k] = k;
            let begin = lower.len();
            for &body in &self.bodies_of[order[k]] {
                let mut j = first[body];
                while seen[j] != k {
                    seen[j] = k;
                    lower.push(j);
                    if parent[j] == NONE {
                        parent[j] = k;
                    }
                    j = parent[j];
                }
            }
            if lower.len() > most {
                return None;
            }
            lower[begin..].sort_unstable();
            lower_start.push(lower.len());
        }
        Some(Ways { order, rank_of, lower, lower_start, parent })
    }

    /// The order of a chain from both its ends at once: the processor then works on two recurrences that do not wait
    /// for each other. None if the rows are no chain.
    fn chain_from_both_ends(&self) -> Option<Vec<usize>> {
        let m = self.bodies_of.len();
        if self.rows_of.iter().any(|rows| rows.len() > 2) {
            return None; // they would be neighbours all
        }
        let mut neighbours: Vec<Vec<usize>> = (0..m).map(|row| self.neighbours(row).collect()).collect();
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        let end = neighbours.iter().position(|list| list.len() <= 1)?;
        if neighbours.iter().any(|list| list.len() > 2) {
            return None;
        }
        let mut chain = vec![end];
        let mut before = end;
        while let Some(&next) = neighbours[chain[chain.len() - 1]].iter().find(|&&row| row != before) {
            before = chain[chain.len() - 1];
            chain.push(next);
        }
        (chain.len() == m)
            .then(|| (0..m).map(|k| chain[if k % 2 == 0 { k / 2 } else { m - 1 - k / 2 }]).collect())
    }
}

impl Ways {
    /// The same elimination with every subtree in one piece: what a row takes is then still in the cache, and rows with
    /// the same columns lie side by side.
    fn postorder(&self) -> Vec<usize> {
        let m = self.order.len();
        let mut children = vec![Vec::new(); m];
        let mut ahead = Vec::new();
        for k in 0..m {
            let siblings = if self.parent[k] == NONE { &mut ahead } else { &mut children[self.parent[k]] };
            siblings.push(k);
        }
        // Written from the end: the root, and before it the subtrees, the last child's last.
        let mut order = Vec::with_capacity(m);
        while let Some(k) = ahead.pop() {
            order.push(self.order[k]);
            ahead.append(&mut children[k]);
        }
        order.reverse();
        order
    }
}
