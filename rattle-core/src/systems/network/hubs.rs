//! Hubs: bodies with many equations, whose displacements are unknowns besides the multipliers.
//!
//! All equations of one body are coupled in G M⁻¹Gᵀ, so a star of n links would give a full matrix of n rows. With the
//! displacement of such a **hub** as a further unknown, y = Lᵀδ for M = L Lᵀ, the matrix is as sparse as the links:
//!
//! ```text
//! A Λ + B y = r        A   G M⁻¹Gᵀ over all other bodies
//! y − Wᵀ Λ  = 0        B = G L⁻ᵀ at the trial, W the same where the step starts; both of the hub alone
//! ```
//!
//! Eliminating y first gives G M⁻¹Gᵀ back, of which the determinants are the same. Eliminated after its equations a hub
//! takes D columns, whatever their number. Pivots of hubs are 1 and what is added to it, and positive like those of
//! equations, until normals are turned over.
//!
//! **Order.** Equations go first that touch a body beside their hubs, in minimum degree over these bodies; then the
//! hubs, in minimum degree over the chains that tie them together. An equation between hubs alone has no pivot of its
//! own before one of its hubs is eliminated: it comes right after the first.

use crate::systems::network::order::minimum_degree;
use crate::systems::network::pattern::Pattern;

/// A body is a hub where pairs of its equations are more than so many times the columns that it takes as an unknown.
const PAYS: usize = 4;

/// Which bodies are unknowns, by their places in the component.
#[derive(Debug, Clone, Default)]
pub(super) struct Hubs {
    /// The body of each hub.
    pub(super) bodies: Vec<usize>,
    /// The hub of each body, or [`NONE`]; empty where there are no hubs.
    of_body: Vec<usize>,
}

const NONE: usize = usize::MAX;

impl Hubs {
    /// Hubs and the pattern with their `coordinates` each as unknowns m, m + 1, …; None where a matrix without them has
    /// no more entries.
    pub(super) fn split(
        rows_of_body: &[Vec<usize>],
        m: usize,
        coordinates: usize,
    ) -> Option<(Self, Pattern)> {
        let pairs = |body: usize| rows_of_body[body].len() * rows_of_body[body].len().saturating_sub(1) / 2;
        let many = |&body: &usize| pairs(body) > PAYS * coordinates * rows_of_body[body].len();
        let bodies: Vec<usize> = (0..rows_of_body.len()).filter(many).collect();
        if bodies.is_empty() {
            return None;
        }
        let mut of_body = vec![NONE; rows_of_body.len()];
        bodies.iter().enumerate().for_each(|(hub, &body)| of_body[body] = hub);
        let hubs = Self { bodies, of_body };
        let cliques = hubs.cliques(rows_of_body, m, coordinates);
        let pattern = Pattern::ordered(&cliques, hubs.order(rows_of_body, m, coordinates));
        let without: usize = hubs.bodies.iter().map(|&body| pairs(body)).sum();
        (pattern.lower.len() < without).then_some((hubs, pattern))
    }

    /// The number of a body among the hubs.
    #[inline]
    pub(super) fn of(&self, body: usize) -> Option<usize> {
        Some(self.of_body[body]).filter(|&hub| hub != NONE)
    }

    /// Unknowns that are neighbours all: the equations of a body, the coordinates of a hub, and these with one
    /// equation.
    fn cliques(&self, rows_of_body: &[Vec<usize>], m: usize, coordinates: usize) -> Vec<Vec<usize>> {
        let mut cliques = Vec::new();
        for (body, rows) in rows_of_body.iter().enumerate() {
            let Some(hub) = self.of(body) else {
                cliques.push(rows.clone());
                continue;
            };
            let own = || (0..coordinates).map(|d| m + hub * coordinates + d);
            cliques.push(own().collect());
            cliques.extend(rows.iter().map(|&row| std::iter::once(row).chain(own()).collect()));
        }
        cliques
    }

    fn order(&self, rows_of_body: &[Vec<usize>], m: usize, coordinates: usize) -> Vec<usize> {
        let others = |body: &usize| self.of_body[*body] == NONE;
        let others = (0..rows_of_body.len()).filter(others).map(|body| rows_of_body[body].clone());
        let others: Vec<_> = others.collect();
        let mut between_hubs = vec![true; m];
        others.iter().flatten().for_each(|&row| between_hubs[row] = false);
        let mut order = minimum_degree(&others, m);
        order.retain(|&row| !between_hubs[row]);

        // Hubs on equations that hang together, and those of an equation between hubs.
        let piece = pieces(&others, m);
        let mut hubs_of: Vec<Vec<usize>> = vec![Vec::new(); m];
        for (hub, &body) in self.bodies.iter().enumerate() {
            for &row in &rows_of_body[body] {
                hubs_of[piece[row]].push(hub);
            }
        }
        for hubs in &mut hubs_of {
            hubs.dedup();
        }
        let mut rows_of_hub = vec![Vec::new(); self.bodies.len()];
        (0..m).filter(|&row| between_hubs[row]).for_each(|row| {
            hubs_of[row].iter().for_each(|&hub| rows_of_hub[hub].push(row));
        });
        let mut together: Vec<_> = hubs_of.into_iter().filter(|hubs| hubs.len() > 1).collect();
        together.sort_unstable();
        together.dedup();
        for hub in minimum_degree(&together, self.bodies.len()) {
            order.extend((0..coordinates).map(|d| m + hub * coordinates + d));
            let free = rows_of_hub[hub].iter().copied();
            order.extend(free.filter(|&row| std::mem::take(&mut between_hubs[row])));
        }
        order
    }
}

/// For each row one of those that hang together with it by bodies: the same for all of them.
fn pieces(rows_of_body: &[Vec<usize>], m: usize) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..m).collect();
    fn root(parent: &mut [usize], mut row: usize) -> usize {
        while parent[row] != row {
            parent[row] = parent[parent[row]];
            row = parent[row];
        }
        row
    }
    for rows in rows_of_body {
        for pair in rows.windows(2) {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a.max(b)] = a.min(b);
        }
    }
    (0..m).map(|row| root(&mut parent, row)).collect()
}
