//! What is evaluated where linked bodies start.

use crate::kernel::rounding::{NOISY, rounding_of_g};
use crate::motion::bodies::Body;
use crate::motion::start::{MAX_HALVINGS, RUNS_AWAY, has_square, length_of};
use crate::motion::state::State;
use crate::number::vector::add_scaled;
use crate::solve::aim::ROUNDINGS;
use crate::systems::network::shape::Shape;

/// What was found for a component, once for all of its equations.
#[derive(Debug, Default)]
pub(super) struct Known {
    pub(super) places: Option<f64>,
    pub(super) speeds: Option<f64>,
    /// For each body that can move by how much the normals there may be turned, the most of all.
    pub(super) turned: Option<Vec<f64>>,
}

/// Where bodies are once the run begins: a state may have what is pinned a little off its pin.
pub(super) fn places<const D: usize>(shape: &Shape<D>, state: &State<D>) -> Vec<[f64; D]> {
    let mut q = Body::positions(&state.bodies);
    shape.pins.iter().for_each(|&(body, at)| q[body] = at);
    q
}

/// Everything evaluated at the start for one component.
pub(super) struct Start<const D: usize> {
    pub(super) q: Vec<[f64; D]>,
    pub(super) v: Vec<[f64; D]>,
    pub(super) lift: Vec<[f64; D]>,
    pub(super) g: Vec<f64>,
    pub(super) blocks: Vec<[f64; D]>,
    pub(super) rates: Vec<f64>,
    pub(super) known: Known,
    /// Room for a way of some bodies: 0 for all others.
    pub(super) part: Vec<[f64; D]>,
}

impl<const D: usize> Start<D> {
    pub(super) fn of(shape: &Shape<D>, state: &State<D>) -> Self {
        let (rows, blocks) = shape.widest;
        let v = state.bodies.iter().zip(&shape.roots).map(|(body, root)| root.velocity(&body.p));
        Self {
            q: places(shape, state),
            v: v.collect(),
            lift: vec![[0.0; D]; state.bodies.len()],
            g: vec![0.0; rows],
            blocks: vec![[0.0; D]; blocks],
            rates: vec![0.0; rows],
            known: Known::default(),
            part: vec![[0.0; D]; state.bodies.len()],
        }
    }

    /// The size of places or velocities along the normal of an equation.
    pub(super) fn along(&self, shape: &Shape<D>, (c, row): (usize, usize), of: &[[f64; D]]) -> f64 {
        let length = self.length(shape, c, row);
        shape.components[c].rows.terms(row, &self.blocks, of).size(length) / length
    }

    /// Some roundings of places or velocities along all normals of a component: they reach an equation whose own bodies
    /// are at rest at the origin.
    pub(super) fn rounding_of_all(&self, shape: &Shape<D>, c: usize, of: &[[f64; D]]) -> f64 {
        let rows = &shape.components[c].rows;
        let sizes = (0..rows.equations()).map(|row| self.along(shape, (c, row), of));
        ROUNDINGS * f64::EPSILON * sizes.fold(0.0, f64::max)
    }

    pub(super) fn rounding_of_places(&mut self, shape: &Shape<D>, c: usize) -> f64 {
        let found = self.known.places.unwrap_or_else(|| self.rounding_of_all(shape, c, &self.q));
        *self.known.places.insert(found)
    }

    pub(super) fn rounding_of_speeds(&mut self, shape: &Shape<D>, c: usize) -> f64 {
        let found = self.known.speeds.unwrap_or_else(|| self.rounding_of_all(shape, c, &self.v));
        *self.known.speeds.insert(found)
    }

    /// |∇²g w| of an equation.
    pub(super) fn bent(
        &self,
        shape: &Shape<D>,
        (c, row): (usize, usize),
        time: f64,
        way: &[[f64; D]],
    ) -> f64 {
        let (group, member, equation) = shape.components[c].rows.find(&shape.groups, row);
        let links = &shape.groups[group];
        let (mut bends, mut turns) = (vec![0.0; links.equations()], vec![0.0; links.equations()]);
        links.bends(member..member + 1, (time, &self.q), (0.0, way), &mut bends, &mut turns);
        turns[equation].sqrt()
    }

    pub(super) fn evaluate(&mut self, shape: &Shape<D>, c: usize, time: f64) {
        let rows = &shape.components[c].rows;
        let (g, blocks) = (&mut self.g[..rows.equations()], &mut self.blocks[..rows.blocks()]);
        let rates = &mut self.rates[..rows.equations()];
        rates.fill(0.0);
        shape.gradients(c, time, &self.q, g, blocks, rates);
    }

    /// Moves a component along [`Self::lift`] from where it is so far off. Where normals nearly vanish that leads far
    /// beyond: a step after which an equation would be off by so many times as much is halved, until none is by more.
    pub(super) fn go(&mut self, shape: &Shape<D>, c: usize, time: f64, distance: f64) {
        let rows = &shape.components[c].rows;
        let (m, bodies) = (rows.equations(), &rows.bodies);
        let from: Vec<_> = bodies.iter().map(|&body| self.q[body]).collect();
        let lengths: Vec<_> = (0..m).map(|row| self.length(shape, c, row)).collect();
        let mut leads = |share: f64, most: f64| {
            bodies.iter().zip(&from).for_each(|(&b, q)| self.q[b] = add_scaled(q, share, &self.lift[b]));
            shape.values(c, time, &self.q, &mut self.g[..m]);
            self.g.iter().zip(&lengths).all(|(g, length)| g.abs() <= most * length * distance) // not if NaN
        };
        let mut parts = (1..=MAX_HALVINGS).map(|halvings| 0.5_f64.powi(halvings));
        if !leads(1.0, RUNS_AWAY) && !parts.any(|share| leads(share, 1.0)) {
            leads(1.0, RUNS_AWAY);
        }
    }

    /// |∇gᵢ| of the coordinates that can move.
    pub(super) fn length(&self, shape: &Shape<D>, c: usize, row: usize) -> f64 {
        let blocks = shape.components[c].rows.blocks_of(row);
        length_of(blocks.flat_map(|(block, _)| &self.blocks[block]))
    }

    /// Whether steps can do with the gradient of an equation: with |∇g|², and with that by the masses.
    pub(super) fn has_square(&self, shape: &Shape<D>, c: usize, row: usize) -> bool {
        let rows = &shape.components[c].rows;
        let by_masses = |(block, body): (usize, usize)| {
            let root = &shape.roots[rows.bodies[body]];
            length_of(&root.halve(&self.blocks[block]))
        };
        let by_masses: Vec<f64> = rows.blocks_of(row).map(by_masses).collect();
        has_square(self.length(shape, c, row)) && has_square(length_of(&by_masses))
    }

    /// Whether an equation is off by no more than the rounding of coordinates.
    pub(super) fn is_there(&self, shape: &Shape<D>, c: usize, row: usize) -> bool {
        let terms = shape.components[c].rows.terms(row, &self.blocks, &self.q);
        self.g[row].abs() <= f64::EPSILON * terms.size(terms.length())
    }

    /// Whether an equation of coordinates of this size along its normal, with a singular point so far away, is off by
    /// no more than the rounding of g.
    #[cold]
    pub(super) fn is_rounding(
        &mut self,
        shape: &Shape<D>,
        (c, row): (usize, usize),
        time: f64,
        [size, singular]: [f64; 2],
    ) -> bool {
        let (q, value, length) = (self.q.clone(), self.g[row], self.length(shape, c, row));
        let rows = &shape.components[c].rows;
        let normals: Vec<_> =
            rows.blocks_of(row).map(|(block, body)| (rows.bodies[body], self.blocks[block])).collect();
        let bent = |shift: f64| {
            for (body, normal) in &normals {
                self.q[*body] = add_scaled(&q[*body], shift / length, normal);
            }
            self.evaluate(shape, c, time);
            ((self.g[row] - value) / length - shift).abs()
        };
        let rounding = rounding_of_g(size, singular, bent);
        self.q.copy_from_slice(&q);
        self.evaluate(shape, c, time);
        value.abs() / length <= NOISY * rounding
    }
}
