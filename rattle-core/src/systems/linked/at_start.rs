//! What is evaluated where linked bodies start.

use crate::kernel::rounding::{NOISY, rounding_of_g};
use crate::motion::bodies::Body;
use crate::motion::start::{MAX_HALVINGS, RUNS_AWAY, allowed, has_square, length_of};
use crate::motion::state::State;
use crate::number::vector::{add_scaled, largest};
use crate::solve::aim::ROUNDINGS;
use crate::systems::network::algebra::LinearAlgebra;
use crate::systems::network::orthogonal::MOST_EQUATIONS;
use crate::systems::network::rows::Rows;
use crate::systems::network::shape::Shape;

/// The group of an equation, its member, and its number among those of the member.
pub(super) type Of = (usize, usize, usize);

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

/// Everything evaluated at the start, for one component after the other.
pub(super) struct Start<const D: usize> {
    pub(super) time: f64,
    pub(super) algebra: LinearAlgebra,
    /// The component that is looked at.
    pub(super) c: usize,
    pub(super) q: Vec<[f64; D]>,
    pub(super) v: Vec<[f64; D]>,
    pub(super) lift: Vec<[f64; D]>,
    pub(super) g: Vec<f64>,
    pub(super) blocks: Vec<[f64; D]>,
    pub(super) rates: Vec<f64>,
    pub(super) known: Known,
    /// By how much normals might turn where a basis last counted all equations of the component as independent.
    pub(super) judged: f64,
    /// Room for a way of some bodies: 0 for all others.
    pub(super) part: Vec<[f64; D]>,
}

impl<const D: usize> Start<D> {
    pub(super) fn of(shape: &Shape<D>, state: &State<D>, algebra: LinearAlgebra) -> Self {
        let (rows, blocks) = shape.widest;
        let v = state.bodies.iter().zip(&shape.roots).map(|(body, root)| root.velocity(&body.p));
        Self {
            time: state.time,
            algebra,
            c: 0,
            q: places(shape, state),
            v: v.collect(),
            lift: vec![[0.0; D]; state.bodies.len()],
            g: vec![0.0; rows],
            blocks: vec![[0.0; D]; blocks],
            rates: vec![0.0; rows],
            known: Known::default(),
            judged: f64::INFINITY,
            part: vec![[0.0; D]; state.bodies.len()],
        }
    }

    /// Looks at this component, of which nothing was counted yet.
    pub(super) fn begin(&mut self, c: usize) {
        self.c = c;
        self.judged = f64::INFINITY;
    }

    pub(super) fn rows<'a>(&self, shape: &'a Shape<D>) -> &'a Rows {
        &shape.components[self.c].rows
    }

    /// Whether a basis may take the place of elimination.
    pub(super) fn may_take_basis(&self, rows: &Rows) -> bool {
        self.algebra == LinearAlgebra::Automatic && rows.equations() <= MOST_EQUATIONS
    }

    /// The size of places or velocities along the normal of an equation.
    pub(super) fn along(&self, shape: &Shape<D>, row: usize, of: &[[f64; D]]) -> f64 {
        let length = self.length(shape, row);
        self.rows(shape).terms(row, &self.blocks, of).size(length) / length
    }

    /// Some roundings of places or velocities along all normals of a component: they reach an equation whose own bodies
    /// are at rest at the origin.
    pub(super) fn rounding_of_all(&self, shape: &Shape<D>, of: &[[f64; D]]) -> f64 {
        let rows = self.rows(shape);
        let sizes = (0..rows.equations()).map(|row| self.along(shape, row, of));
        ROUNDINGS * f64::EPSILON * sizes.fold(0.0, f64::max)
    }

    pub(super) fn rounding_of_places(&mut self, shape: &Shape<D>) -> f64 {
        let found = self.known.places.unwrap_or_else(|| self.rounding_of_all(shape, &self.q));
        *self.known.places.insert(found)
    }

    pub(super) fn rounding_of_speeds(&mut self, shape: &Shape<D>) -> f64 {
        let found = self.known.speeds.unwrap_or_else(|| self.rounding_of_all(shape, &self.v));
        *self.known.speeds.insert(found)
    }

    /// ∇²g w of an equation, in blocks.
    pub(super) fn bend(
        &self,
        shape: &Shape<D>,
        (group, member, equation): Of,
        way: &[[f64; D]],
    ) -> Vec<[f64; D]> {
        shape.groups[group].changes((member, equation), (self.time, &self.q), way)
    }

    /// How far it is to where this equation has no normal, by how that changes along itself: |∇g|/|∇²g n|.
    pub(super) fn singular(&mut self, shape: &Shape<D>, of: Of, normals: &[(usize, [f64; D])]) -> f64 {
        // w/|∇g|, whose product with ∇²g can be squared however g is scaled.
        let length = length_of(normals.iter().flat_map(|(_, normal)| normal));
        normals.iter().for_each(|(body, n)| self.part[*body] = n.map(|n| n / length / length));
        let change = self.bend(shape, of, &self.part);
        normals.iter().for_each(|(body, _)| self.part[*body] = [0.0; D]);
        1.0 / length_of(change.iter().flatten())
    }

    pub(super) fn evaluate(&mut self, shape: &Shape<D>) {
        let rows = self.rows(shape);
        let (g, blocks) = (&mut self.g[..rows.equations()], &mut self.blocks[..rows.blocks()]);
        let rates = &mut self.rates[..rows.equations()];
        rates.fill(0.0);
        shape.gradients(self.c, self.time, &self.q, g, blocks, rates);
        self.known = Known::default();
    }

    /// Moves a component along [`Self::lift`] from where it is so far off. Where normals nearly vanish that leads far
    /// beyond: a step after which an equation would be off by so many times as much is halved, until none is by more.
    pub(super) fn go(&mut self, shape: &Shape<D>, distance: f64) {
        let rows = self.rows(shape);
        let (m, bodies) = (rows.equations(), &rows.bodies);
        let from: Vec<_> = bodies.iter().map(|&body| self.q[body]).collect();
        let lengths: Vec<_> = (0..m).map(|row| self.length(shape, row)).collect();
        let mut leads = |share: f64, most: f64| {
            bodies.iter().zip(&from).for_each(|(&b, q)| self.q[b] = add_scaled(q, share, &self.lift[b]));
            shape.values(self.c, self.time, &self.q, &mut self.g[..m]);
            self.g.iter().zip(&lengths).all(|(g, length)| g.abs() <= most * length * distance) // not if NaN
        };
        let mut parts = (1..=MAX_HALVINGS).map(|halvings| 0.5_f64.powi(halvings));
        if !leads(1.0, RUNS_AWAY) && !parts.any(|share| leads(share, 1.0)) {
            leads(1.0, RUNS_AWAY);
        }
    }

    /// |∇gᵢ| of the coordinates that can move.
    pub(super) fn length(&self, shape: &Shape<D>, row: usize) -> f64 {
        let blocks = self.rows(shape).blocks_of(row);
        length_of(blocks.flat_map(|(block, _)| &self.blocks[block]))
    }

    /// The length of the blocks of an equation in the metric of M⁻¹, the first of which has this number.
    pub(super) fn by_masses(
        &self,
        shape: &Shape<D>,
        row: usize,
        (blocks, first): (&[[f64; D]], usize),
    ) -> f64 {
        let rows = self.rows(shape);
        let halves =
            rows.blocks_of(row).map(|(block, b)| shape.roots[rows.bodies[b]].halve(&blocks[block - first]));
        length_of(&halves.flatten().collect::<Vec<_>>())
    }

    /// Whether steps can do with the gradient of an equation: with |∇g|², and with that by the masses.
    pub(super) fn has_square(&self, shape: &Shape<D>, row: usize) -> bool {
        let by_masses = self.by_masses(shape, row, (&self.blocks, 0));
        has_square(self.length(shape, row)) && has_square(by_masses)
    }

    /// The normal of an equation: the bodies that can move, each with its block.
    pub(super) fn normals(&self, shape: &Shape<D>, row: usize) -> Vec<(usize, [f64; D])> {
        let rows = self.rows(shape);
        rows.blocks_of(row).map(|(block, body)| (rows.bodies[body], self.blocks[block])).collect()
    }

    /// Whether an equation is off by no more than the rounding of coordinates.
    pub(super) fn is_there(&self, shape: &Shape<D>, row: usize) -> bool {
        let terms = self.rows(shape).terms(row, &self.blocks, &self.q);
        self.g[row].abs() <= f64::EPSILON * terms.size(terms.length())
    }

    /// Whether an equation of a component is off by no more than some roundings, of places or of g.
    pub(super) fn is_at_rounding(&mut self, shape: &Shape<D>, row: usize, singular: f64) -> bool {
        let distance = self.g[row].abs() / self.length(shape, row);
        if distance <= self.rounding_of_places(shape) {
            return true;
        }
        let (along, normals) = (self.along(shape, row, &self.q), self.normals(shape, row));
        let of = self.rows(shape).find(&shape.groups, row);
        self.is_rounding(shape, of, (&normals, self.g[row]), [along, singular])
    }

    /// How far off an equation of a component is, and how far it may be beside a step's way; none where it is not
    /// farther off, or by rounding.
    pub(super) fn off(
        &mut self,
        shape: &Shape<D>,
        row: usize,
        (way, singular): (f64, f64),
    ) -> Option<[f64; 2]> {
        let distance = self.g[row].abs() / self.length(shape, row);
        let touched = self.rows(shape).touched_by(row);
        let size = touched.map(|(_, body)| largest(&self.q[body])).fold(0.0, f64::max);
        let tolerance = allowed([size, self.along(shape, row, &self.q)], way, singular);
        let holds = distance <= tolerance || self.is_at_rounding(shape, row, singular);
        (!holds).then_some([distance, tolerance])
    }

    /// Whether an equation with these normals and this value, of coordinates of this size along its normal, with a
    /// singular point so far away, is off by no more than the rounding of g.
    #[cold]
    pub(super) fn is_rounding(
        &mut self,
        shape: &Shape<D>,
        (group, member, equation): Of,
        (normals, value): (&[(usize, [f64; D])], f64),
        [size, singular]: [f64; 2],
    ) -> bool {
        let links = &shape.groups[group];
        let length = length_of(normals.iter().flat_map(|(_, normal)| normal));
        let from: Vec<_> = normals.iter().map(|&(body, _)| self.q[body]).collect();
        let mut values = vec![0.0; links.equations()];
        let bent = |shift: f64| {
            for ((body, normal), q) in normals.iter().zip(&from) {
                self.q[*body] = add_scaled(q, shift / length, normal);
            }
            links.values(member..member + 1, self.time, &self.q, &mut values);
            ((values[equation] - value) / length - shift).abs()
        };
        let rounding = rounding_of_g(size, singular, bent);
        normals.iter().zip(from).for_each(|((body, _), q)| self.q[*body] = q);
        value.abs() / length <= NOISY * rounding
    }
}
