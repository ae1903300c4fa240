//! Starts of linked bodies: always checked, projected onto the constraints only on request.

use crate::error::{EquationAt, Error, History, StartFailure};
use crate::motion::bodies::Body;
use crate::motion::start::{DIRECTION, MAX_PROJECTION_STEPS, START_TOLERANCE};
use crate::motion::start::{allowed, finite, length_of};
use crate::motion::state::State;
use crate::number::vector::{add_scaled, dot, largest};
use crate::solve::aim::ROUNDINGS;
use crate::solve::stop::Terms;
use crate::systems::linked::at_start::Start;
use crate::systems::linked::flight::LOST;
use crate::systems::linked::pull::Rounds;
use crate::systems::network::algebra::LinearAlgebra;
use crate::systems::network::dependence::dependence;
use crate::systems::network::mass::Root;
use crate::systems::network::orthogonal::{BRANCHING, MOST_EQUATIONS};
use crate::systems::network::shape::{Component, Shape};
use crate::systems::network::solver::{CLEARLY, Solver};

/// Below this sine of the angle of a normal to the others a basis keeps digits that elimination, whose matrix has the
/// condition 1/sin², finds by further rounds alone; and displacements of light bodies it does not find again.
const NARROW: f64 = 1e-3;

/// Whether the motion may start: finite, on the constraints, momenta along them unless staggered, nothing singular.
/// Components whose equations depend on each other get the linear algebra that bears it, if they may.
#[inline(never)]
pub(crate) fn check<const D: usize>(
    shape: &mut Shape<D>,
    algebra: LinearAlgebra,
    state: &State<D>,
    h: f64,
    tangent: bool,
) -> Result<(), Error> {
    check_bodies(shape, &state.bodies)?;
    let mut start = Start::of(shape, state, algebra);
    start.check_fixed(shape)?;
    for c in 0..shape.components.len() {
        start.begin(c);
        start.evaluate(shape);
        let mut doubtful = None;
        for row in 0..shape.components[c].rows.equations() {
            let looked = start.check_row(shape, row, h, tangent);
            let doubt = looked.map_err(|cause| start.at(shape, row, cause))?;
            doubtful = doubtful.or(doubt.map(|cause| start.at(shape, row, cause)));
        }
        start.check_normals(shape)?;
        let Component { solver, rows, .. } = &shape.components[c];
        // The normal of one that follows from others is turned where theirs are.
        if let Some(error) = doubtful.filter(|_| solver.rank(rows) == rows.equations()) {
            return Err(error);
        }
    }
    Ok(())
}

/// Momenta that are no more than this part of what they were before they were made to fit are rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The state moved onto the constraints by Newton's method along their gradients, momenta made to fit.
#[inline(never)]
pub(crate) fn project<const D: usize>(
    shape: &mut Shape<D>,
    algebra: LinearAlgebra,
    state: &State<D>,
) -> Result<State<D>, Error> {
    let mut state = State { remembered: None, ..state.clone() };
    for &(body, at) in &shape.pins {
        state.bodies[body] = Body { q: at, q_low: [0.0; D], p: [0.0; D], p_low: [0.0; D] };
    }
    check_bodies(shape, &state.bodies)?;
    let mut start = Start::of(shape, &state, algebra);
    start.check_fixed(shape)?;
    // What belongs to other components is left alone: the cost is that of all equations, however many components.
    let mut p = Body::momenta(&state.bodies);
    for c in 0..shape.components.len() {
        let (sine, _) = start.place_by_some_masses(shape, c)?;
        let Shape { components, roots, .. } = &mut *shape;
        let component = &mut components[c];
        let (rows, m) = (&component.rows, component.rows.equations());
        let (mut needed, mut x) = (vec![0.0; m], vec![0.0; m]);
        let speed = |p: &[[f64; D]], body: usize| largest(&roots[body].velocity(&p[body]));
        let before: Vec<f64> = rows.bodies.iter().map(|&body| speed(&p, body)).collect();
        let mut rounds = Rounds::begin();
        while rounds.has_another(component.solver.is_lossy()) {
            // The second time takes what rounding left.
            for (row, needed) in needed.iter_mut().enumerate() {
                *needed = -start.rates[row];
                for (block, body) in rows.blocks_of(row) {
                    let body = rows.bodies[body];
                    *needed -= dot(&start.blocks[block], &roots[body].velocity(&p[body]));
                }
            }
            component.solver.solve(&needed, &mut x);
            if !rounds.takes(&x, &needed) {
                break;
            }
            component.solver.push(rows, roots, 1.0, &x, &mut p);
        }
        for (&body, before) in rows.bodies.iter().zip(before) {
            // A push that led off the constraints alone: the body is at rest.
            if speed(&p, body) <= ROUNDING * before && start.rates[..m].iter().all(|&rate| rate == 0.0) {
                p[body] = [0.0; D];
            }
        }
        // Rates that no momenta can give: links that move apart, or rounding of normals that fall together.
        let moves = start.rates[..m].iter().any(|&rate| rate != 0.0);
        let Shape { components, roots, .. } = &*shape;
        let rows = &components[c].rows;
        for row in 0..m {
            let (mut rate, mut square, mut speed) = (start.rates[row], 0.0, 0.0_f64);
            for (block, body) in rows.blocks_of(row) {
                let v = roots[rows.bodies[body]].velocity(&p[rows.bodies[body]]);
                rate += dot(&start.blocks[block], &v);
                square += dot(&start.blocks[block], &start.blocks[block]);
                speed = speed.max(largest(&v));
            }
            let scale = square.sqrt() * speed + start.rates[row].abs();
            if rate.abs() > START_TOLERANCE * scale && rate.abs() > scale * start.turned_near(shape, row) {
                let equation = shape.equation_at(c, row);
                let contradict = StartFailure::RatesContradict { equation, rate };
                let cause = if moves { contradict } else { start.dependent(shape, row, sine) };
                return Err(start.at(shape, row, cause));
            }
        }
        for &body in &rows.bodies {
            let (q, p) = (start.q[body], p[body]);
            state.bodies[body] = Body { q, q_low: [0.0; D], p, p_low: [0.0; D] };
        }
    }
    Ok(state)
}

fn check_bodies<const D: usize>(shape: &Shape<D>, bodies: &[Body<f64, D>]) -> Result<(), Error> {
    for (body, state) in bodies.iter().enumerate() {
        let fine = finite("position", &state.q).and_then(|()| finite("momentum", &state.p));
        fine.map_err(|cause| Error::Start { body, cause })?;
    }
    let size = bodies.iter().map(|body| largest(&body.q)).fold(0.0, f64::max);
    for &(body, at) in &shape.pins {
        let Body { q, p, .. } = bodies[body];
        let off = largest(&add_scaled(&q, -1.0, &at));
        let finite = at.iter().all(|x| x.is_finite());
        if !(finite && off <= START_TOLERANCE * size.max(largest(&at)) && p == [0.0; D]) {
            let cause = StartFailure::Pinned { at: at.to_vec(), position: q.to_vec(), momentum: p.to_vec() };
            return Err(Error::Start { body, cause });
        }
    }
    Ok(())
}

impl<const D: usize> Start<D> {
    /// Whether links between pinned bodies alone hold.
    fn check_fixed(&mut self, shape: &Shape<D>) -> Result<(), Error> {
        if shape.fixed.is_empty() {
            return Ok(());
        }
        let mut topology = (usize::MAX, (Vec::new(), 0));
        for &(group, member) in &shape.fixed {
            let links = &shape.groups[group];
            if topology.0 != group {
                topology = (group, links.bodies());
            }
            let (touched, arity) = (&topology.1.0, topology.1.1);
            let (of, bodies) = (links.equations(), touched[member * arity..][..arity].to_vec());
            let (mut g, mut rates) = (vec![0.0; of], vec![0.0; of]);
            let mut blocks = vec![[0.0; D]; of * arity];
            links.gradients(member..member + 1, self.time, &self.q, &mut g, &mut blocks, &mut rates);
            let size = bodies.iter().map(|&body| largest(&self.q[body])).fold(0.0, f64::max);
            for equation in 0..of {
                let blocks = &blocks[equation * arity..][..arity];
                let length = length_of(blocks.iter().flatten());
                let distance = g[equation].abs() / length;
                let normals: Vec<_> = bodies.iter().copied().zip(blocks.iter().copied()).collect();
                let terms = normals.iter().map(|(body, normal)| (normal, self.q[*body], [0.0; D]));
                let (along, at) = (Terms::of(terms).size(length) / length, (group, member, equation));
                let singular = self.singular(shape, at, &normals);
                let tolerance = allowed([size, along], 0.0, singular);
                let mut is_rounding =
                    || self.is_rounding(shape, at, (&normals, g[equation]), [along, singular]);
                if links.moving() || distance.is_nan() || distance > tolerance && !is_rounding() {
                    let (body, link, moving) = (bodies[0], links.name(), links.moving());
                    let equation = Box::new(EquationAt { link, group, member, equation, of, bodies });
                    let cause = StartFailure::BetweenPins { equation, distance, moving };
                    return Err(Error::Start { body, cause });
                }
            }
        }
        Ok(())
    }

    /// Whether an equation holds, and momenta are along it. Returns what is wrong if the equation does not follow from
    /// others.
    fn check_row(
        &mut self,
        shape: &Shape<D>,
        row: usize,
        h: f64,
        tangent: bool,
    ) -> Result<Option<StartFailure>, StartFailure> {
        let (c, rows) = (self.c, self.rows(shape));
        let (value, length) = (self.g[row], self.length(shape, row));
        let (mut size, mut speed, mut rate) = (0.0_f64, 0.0, self.rates[row]);
        for (block, body) in rows.touched_by(row) {
            size = size.max(largest(&self.q[body]));
            speed += dot(&self.v[body], &self.v[body]);
            rate += dot(&self.blocks[block], &self.v[body]);
        }
        let speed = speed.sqrt();
        if !(value.is_finite() && length.is_finite() && rate.is_finite()) {
            let gradient = rows.touched_by(row).flat_map(|(block, _)| self.blocks[block]).collect();
            let position = rows.touched_by(row).flat_map(|(_, body)| self.q[body]).collect();
            return Err(StartFailure::ConstraintNotFinite { value, gradient, position });
        }

        let (of, normals) = (rows.find(&shape.groups, row), self.normals(shape, row));
        let singular = self.singular(shape, of, &normals);
        // A coordinate may be as large as it likes where normals do not depend on it.
        let is_near = singular < f64::EPSILON * size / DIRECTION;
        let mut turned = 0.0;
        for (body, i) in
            normals.iter().flat_map(|(body, _)| (0..D).map(move |i| (*body, i))).filter(|_| is_near)
        {
            self.part[body][i] = f64::EPSILON * self.q[body][i] / length;
            turned += length_of(self.bend(shape, of, &self.part).iter().flatten());
            self.part[body][i] = 0.0;
        }
        let at = || shape.equation_at(c, row);
        if length == 0.0 || turned > DIRECTION {
            let distance = if length == 0.0 { 0.0 } else { singular };
            return Err(StartFailure::Vanishes { equation: at(), gradient: length, distance });
        }
        if !self.has_square(shape, row) {
            return Err(StartFailure::OutOfScale { equation: Some(at()), gradient: length });
        }
        if let Some([distance, tolerance]) = self.off(shape, row, (h.abs() * speed, singular)) {
            return Err(StartFailure::OffConstraint { equation: at(), distance, tolerance, value });
        }
        let scale = length * speed + self.rates[row].abs();
        if !tangent || rate.abs() <= START_TOLERANCE * scale {
            return Ok(None);
        }
        // Far away, or of short links, normals are known to fewer digits.
        let own = self.turned(shape, row);
        if rate.abs() <= scale * own || rate.abs() <= length * self.rounding_of_speeds(shape) {
            return Ok(None);
        }
        let near = self.turned_near(shape, row);
        let (sine, tolerance) = (rate.abs() / scale, START_TOLERANCE);
        let cause = StartFailure::NotAlong { equation: at(), rate, sine, tolerance };
        if rate.abs() <= scale * near { Ok(Some(cause)) } else { Err(cause) }
    }

    fn check_normals(&mut self, shape: &mut Shape<D>) -> Result<(), Error> {
        let mut acting = self.blocks[..self.rows(shape).blocks()].to_vec();
        shape.mask(self.c, &mut acting);
        let Shape { components, roots, .. } = &mut *shape;
        let component = &mut components[self.c];
        let (borne, weakest) = match self.bear(component, &acting, roots) {
            Ok((_, row)) if component.rows.acting => (true, row),
            Err((_, row)) if component.rows.acting => (false, row),
            Ok((sine, _)) => {
                self.count_independent(shape, sine);
                return Ok(());
            }
            Err((sine, row)) => return Err(self.at(shape, row, self.dependent(shape, row, sine))),
        };
        let (rows, blocks) = (&component.rows, &self.blocks[..component.rows.blocks()]);
        let may_choose = self.may_take_basis(rows);
        let is_clear = component.solver.chord::<false>(rows, blocks, roots) > CLEARLY * CLEARLY;
        if !is_clear && may_choose && !component.solver.is_orthogonal() {
            component.solver = Solver::orthogonal(rows); // which exchanges rows
            component.solver.normals(rows, &acting, roots);
            component.solver.chord::<false>(rows, blocks, roots);
        }
        let independent = borne && component.solver.rank(rows) == rows.equations();
        if independent && component.solver.orientation().abs() == 1.0 {
            return Ok(());
        }
        if rows.equations() <= MOST_EQUATIONS {
            let mut all = Solver::orthogonal(rows);
            let (sine, row) = all.normals(rows, blocks, roots);
            if all.rank(rows) < rows.equations() {
                return Err(self.at(shape, row, self.dependent(shape, row, sine)));
            }
        }
        let equation = shape.equation_at(self.c, weakest);
        Err(self.at(shape, weakest, StartFailure::CannotAct { equation }))
    }

    /// Has a component take its normals over, by the linear algebra that bears them, if it may choose one. Returns the
    /// sine of the least independent one to the others, and its row; as an error where it cannot bear them.
    fn bear(
        &self,
        component: &mut Component<D>,
        blocks: &[[f64; D]],
        roots: &[Root<D>],
    ) -> Result<(f64, usize), (f64, usize)> {
        let rows = &component.rows;
        let found = component.solver.first_normals(rows, blocks, roots);
        if !matches!(component.solver, Solver::Elimination(_)) || found.0 > NARROW {
            return Ok(found);
        }
        if self.may_take_basis(rows) {
            component.solver = Solver::orthogonal(rows);
            return Ok(component.solver.normals(rows, blocks, roots));
        }
        if found.0 > LOST {
            // What rounding leaves of a pivot that is none may be more.
            dependence(&mut component.solver, rows, blocks, roots, found.1).map_or(Ok(found), Err)
        } else {
            Err(found) // nor where it is no number
        }
    }

    /// Moves a component onto its constraints as its masses have it, or, where that leads to no place, as equal masses
    /// do: bodies that are far lighter than others are thrown aside. Returns as [`Self::bear`] does by the masses
    /// there.
    fn place_by_some_masses(&mut self, shape: &mut Shape<D>, c: usize) -> Result<(f64, usize), Error> {
        let bodies = shape.components[c].rows.bodies.clone();
        let from: Vec<_> = bodies.iter().map(|&body| self.q[body]).collect();
        let error = match self.place(shape, c) {
            Err(error @ Error::Start { cause: StartFailure::NoPlace { .. }, .. }) => error,
            other => return other,
        };
        let mass =
            |body: usize| shape.roots[body].over_masses().filter(|over| over.iter().all(|x| *x == over[0]));
        if mass(bodies[0]).is_some_and(|of| bodies.iter().all(|&body| mass(body) == Some(of))) {
            return Err(error); // they are equal
        }
        bodies.iter().zip(from).for_each(|(&body, q)| self.q[body] = q);
        let roots: Vec<_> =
            bodies.iter().map(|&body| std::mem::replace(&mut shape.roots[body], Root::Unit)).collect();
        let Component { rows, solver, .. } = &mut shape.components[c];
        let by_equal_masses = match self.algebra {
            LinearAlgebra::Orthogonal => Solver::orthogonal(rows),
            _ => Solver::elimination(rows, &shape.roots),
        };
        let by_masses = std::mem::replace(solver, by_equal_masses);
        let placed = self.place(shape, c);
        bodies.into_iter().zip(roots).for_each(|(body, root)| shape.roots[body] = root);
        shape.components[c].solver = by_masses;
        placed.map_err(|_| error)?;
        self.begin(c);
        self.take_over(shape)
    }

    /// Moves a component onto its constraints. Returns as [`Self::bear`] does there.
    fn place(&mut self, shape: &mut Shape<D>, c: usize) -> Result<(f64, usize), Error> {
        self.begin(c);
        let m = self.rows(shape).equations();
        let mut x = vec![0.0; m];
        let mut distances: Vec<f64> = Vec::new();
        let (mut last, mut worst) = (f64::INFINITY, 0);
        loop {
            self.evaluate(shape);
            let (mut distance, mut there, mut size) = (0.0, true, 0.0_f64);
            for row in 0..m {
                let length = self.length(shape, row);
                if length == 0.0 && self.g[row].is_finite() {
                    let equation = shape.equation_at(c, row);
                    let cause = StartFailure::Vanishes { equation, gradient: 0.0, distance: 0.0 };
                    return Err(self.at(shape, row, cause));
                }
                there &= self.is_there(shape, row);
                size = size.max(self.along(shape, row, &self.q)); // of what is pinned, too
                if length.is_finite() && length > 0.0 && !self.has_square(shape, row) {
                    let equation = Some(shape.equation_at(c, row));
                    return Err(self.at(shape, row, StartFailure::OutOfScale { equation, gradient: length }));
                }
                let off = self.g[row].abs() / length;
                if off > distance || off.is_nan() {
                    (distance, worst) = (off, row);
                }
            }
            let found = self.take_over(shape)?;
            let Shape { components, roots, .. } = &mut *shape;
            let component = &mut components[c];
            let rows = &component.rows;
            let off: Vec<f64> = self.g[..m].iter().map(|g| -g).collect();
            component.solver.solve(&off, &mut x);
            let lift = &mut self.lift;
            rows.bodies.iter().for_each(|&body| lift[body] = [0.0; D]);
            component.solver.displace(rows, roots, &x, lift);
            let size = rows.bodies.iter().map(|&body| largest(&self.q[body])).fold(size, f64::max);
            let correction = rows.bodies.iter().map(|&body| largest(&lift[body])).fold(0.0, f64::max);
            if !(distance.is_finite() && correction.is_finite()) {
                let position = rows.touched_by(worst).flat_map(|(_, body)| self.q[body]).collect();
                let gradient = rows.touched_by(worst).flat_map(|(block, _)| self.blocks[block]).collect();
                let cause = StartFailure::ConstraintNotFinite { value: self.g[worst], gradient, position };
                return Err(self.at(shape, worst, cause));
            }
            // Far off, a distance that is no longer halved may still shrink: light bodies go first. It is the rounding
            // of g where each equation says so. Links contradict each other where nothing moves any more.
            let [lingers, stays] = [last <= 2.0 * distance, correction <= ROUNDINGS * f64::EPSILON * size];
            let last_step = distances.len() == MAX_PROJECTION_STEPS;
            let arrived = there && correction <= f64::EPSILON * size || lingers && self.all_hold(shape, true);
            let may_end = lingers && stays || last_step;
            let holds = !arrived && (stays || last_step) && self.all_hold(shape, false);
            if arrived || holds && may_end {
                return Ok(found);
            }
            let equation = || shape.equation_at(c, worst);
            if stays && lingers && !holds {
                let cause = StartFailure::Contradictory { equation: equation(), distance };
                return Err(self.at(shape, worst, cause));
            }
            if last_step {
                let distances = distances.into_iter().collect::<History>();
                return Err(self.at(shape, worst, StartFailure::NoPlace { equation: equation(), distances }));
            }
            distances.push(distance);
            last = distance;
            self.go(shape, distance);
        }
    }

    /// Has the component take its normals over, and count those that are independent. Returns as [`Self::bear`] does.
    fn take_over(&mut self, shape: &mut Shape<D>) -> Result<(f64, usize), Error> {
        let Shape { components, roots, .. } = &mut *shape;
        let component = &mut components[self.c];
        component.solver.limit(component.rows.equations(), BRANCHING);
        let blocks = &self.blocks[..component.rows.blocks()];
        let found = match self.bear(component, blocks, roots) {
            Ok(found) => found,
            Err((sine, row)) => return Err(self.at(shape, row, self.dependent(shape, row, sine))),
        };
        self.count_independent(shape, found.0);
        Ok(found)
    }

    /// Whether all equations of the component hold as a start has to, or but for rounding.
    fn all_hold(&mut self, shape: &Shape<D>, exactly: bool) -> bool {
        let rows = self.rows(shape);
        (0..rows.equations()).all(|row| {
            let (of, normals) = (rows.find(&shape.groups, row), self.normals(shape, row));
            let singular = self.singular(shape, of, &normals);
            if exactly {
                self.is_at_rounding(shape, row, singular)
            } else {
                self.off(shape, row, (0.0, singular)).is_none()
            }
        })
    }

    fn at(&self, shape: &Shape<D>, row: usize, cause: StartFailure) -> Error {
        Error::Start { body: shape.equation_at(self.c, row).bodies[0], cause }
    }

    fn dependent(&self, shape: &Shape<D>, row: usize, sine: f64) -> StartFailure {
        let (equation, rows) = (shape.equation_at(self.c, row), self.rows(shape));
        let most = if rows.acting { 0 } else { MOST_EQUATIONS };
        StartFailure::Dependent { equation, sine, equations: rows.equations(), most }
    }
}
