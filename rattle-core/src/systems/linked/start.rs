//! Starts of linked bodies: always checked, projected onto the constraints only on request.

use crate::error::{EquationAt, Error, History, StartFailure};
use crate::motion::bodies::Body;
use crate::motion::start::{DIRECTION, MAX_PROJECTION_STEPS, START_TOLERANCE};
use crate::motion::start::{allowed, finite, length_of};
use crate::motion::state::State;
use crate::number::vector::{add_scaled, dot, largest};
use crate::solve::aim::ROUNDINGS;
use crate::solve::nearing::Nearing;
use crate::systems::linked::at_start::{Known, Start, places};
use crate::systems::linked::flight::LOST;
use crate::systems::linked::independence::count_independent;
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
    check_fixed(shape, state)?;
    let mut start = Start::of(shape, state);
    for c in 0..shape.components.len() {
        start.evaluate(shape, c, state.time);
        start.known = Known::default();
        let mut doubtful = None;
        for row in 0..shape.components[c].rows.equations() {
            let looked = check_row(shape, c, row, &mut start, state, h, tangent);
            let doubt = looked.map_err(|cause| at(shape, c, row, cause))?;
            doubtful = doubtful.or(doubt.map(|cause| at(shape, c, row, cause)));
        }
        check_normals(shape, c, algebra, &mut start, state.time)?;
        let Component { solver, rows, .. } = &shape.components[c];
        // The normal of one that follows from others is turned where theirs are.
        if let Some(error) = doubtful.filter(|_| solver.rank(rows) == rows.equations()) {
            return Err(error);
        }
    }
    Ok(())
}

fn at<const D: usize>(shape: &Shape<D>, c: usize, row: usize, cause: StartFailure) -> Error {
    Error::Start { body: shape.equation_at(c, row).bodies[0], cause }
}

fn dependent<const D: usize>(shape: &Shape<D>, c: usize, row: usize, sine: f64) -> StartFailure {
    let (equation, rows) = (shape.equation_at(c, row), &shape.components[c].rows);
    let most = if rows.acting { 0 } else { MOST_EQUATIONS };
    StartFailure::Dependent { equation, sine, equations: rows.equations(), most }
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

/// Whether an equation holds, and momenta are along it. Returns what is wrong if the equation does not follow from
/// others.
fn check_row<const D: usize>(
    shape: &Shape<D>,
    c: usize,
    row: usize,
    start: &mut Start<D>,
    state: &State<D>,
    h: f64,
    tangent: bool,
) -> Result<Option<StartFailure>, StartFailure> {
    let rows = &shape.components[c].rows;
    let (value, length) = (start.g[row], start.length(shape, c, row));
    let (mut size, mut speed, mut rate) = (0.0_f64, 0.0, start.rates[row]);
    let along = start.along(shape, (c, row), &start.q);
    for (block, body) in rows.touched_by(row) {
        size = size.max(largest(&start.q[body]));
        speed += dot(&start.v[body], &start.v[body]);
        rate += dot(&start.blocks[block], &start.v[body]);
    }
    let speed = speed.sqrt();
    if !(value.is_finite() && length.is_finite() && rate.is_finite()) {
        let gradient = rows.touched_by(row).flat_map(|(block, _)| start.blocks[block]).collect();
        let position = rows.touched_by(row).flat_map(|(_, body)| start.q[body]).collect();
        return Err(StartFailure::ConstraintNotFinite { value, gradient, position });
    }

    // |∇²g w|/|∇g| along the normal: how far it is to a point without one; and what the rounding of each coordinate makes.
    // The velocities make room for w/|∇g|, whose product with ∇²g can be squared however g is scaled.
    let bodies: Vec<_> = rows.blocks_of(row).map(|(_, body)| rows.bodies[body]).collect();
    let saved: Vec<_> = bodies.iter().map(|&body| start.v[body]).collect();
    let change = |start: &Start<D>| start.bent(shape, (c, row), state.time, &start.v);
    for (block, body) in rows.blocks_of(row) {
        start.v[rows.bodies[body]] = start.blocks[block].map(|n| n / length / length);
    }
    let singular = 1.0 / change(start);
    bodies.iter().for_each(|&body| start.v[body] = [0.0; D]);
    // A coordinate may be as large as it likes where normals do not depend on it.
    let is_near = singular < f64::EPSILON * size / DIRECTION;
    let mut turned = 0.0;
    for (body, i) in bodies.iter().flat_map(|&body| (0..D).map(move |i| (body, i))).filter(|_| is_near) {
        start.v[body][i] = f64::EPSILON * start.q[body][i] / length;
        turned += change(start);
        start.v[body][i] = 0.0;
    }
    for (&body, v) in bodies.iter().zip(saved) {
        start.v[body] = v;
    }
    let at = || shape.equation_at(c, row);
    if length == 0.0 || turned > DIRECTION {
        let distance = if length == 0.0 { 0.0 } else { singular };
        return Err(StartFailure::Vanishes { equation: at(), gradient: length, distance });
    }
    if !start.has_square(shape, c, row) {
        return Err(StartFailure::OutOfScale { equation: Some(at()), gradient: length });
    }
    let distance = value.abs() / length;
    let tolerance = allowed([size, along], h.abs() * speed, singular);
    if distance > tolerance
        && distance > start.rounding_of_places(shape, c)
        && !start.is_rounding(shape, (c, row), state.time, [along, singular])
    {
        return Err(StartFailure::OffConstraint { equation: at(), distance, tolerance, value });
    }
    let scale = length * speed + start.rates[row].abs();
    if !tangent || rate.abs() <= START_TOLERANCE * scale {
        return Ok(None);
    }
    // Far away, or of short links, normals are known to fewer digits.
    let own = start.turned(shape, (c, row), state.time, None);
    if rate.abs() <= scale * own || rate.abs() <= length * start.rounding_of_speeds(shape, c) {
        return Ok(None);
    }
    let near = start.turned_near(shape, (c, row), state.time);
    let (sine, tolerance) = (rate.abs() / scale, START_TOLERANCE);
    let cause = StartFailure::NotAlong { equation: at(), rate, sine, tolerance };
    if rate.abs() <= scale * near { Ok(Some(cause)) } else { Err(cause) }
}

/// Has a component take its normals over, by the linear algebra that bears them, if it may choose one. Returns the sine
/// of the least independent one to the others, and its row; as an error where it cannot bear them.
fn bear<const D: usize>(
    component: &mut Component<D>,
    algebra: LinearAlgebra,
    blocks: &[[f64; D]],
    roots: &[Root<D>],
) -> Result<(f64, usize), (f64, usize)> {
    let rows = &component.rows;
    let found = component.solver.first_normals(rows, blocks, roots);
    if !matches!(component.solver, Solver::Elimination(_)) || found.0 > NARROW {
        return Ok(found);
    }
    if algebra == LinearAlgebra::Automatic && rows.equations() <= MOST_EQUATIONS {
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

fn check_normals<const D: usize>(
    shape: &mut Shape<D>,
    c: usize,
    algebra: LinearAlgebra,
    start: &mut Start<D>,
    time: f64,
) -> Result<(), Error> {
    let mut acting = start.blocks[..shape.components[c].rows.blocks()].to_vec();
    shape.mask(c, &mut acting);
    let Shape { components, roots, .. } = &mut *shape;
    let component = &mut components[c];
    let (borne, weakest) = match bear(component, algebra, &acting, roots) {
        Ok((_, row)) if component.rows.acting => (true, row),
        Err((_, row)) if component.rows.acting => (false, row),
        Ok(_) => {
            count_independent(shape, c, start, time);
            return Ok(());
        }
        Err((sine, row)) => return Err(at(shape, c, row, dependent(shape, c, row, sine))),
    };
    let (rows, blocks) = (&component.rows, &start.blocks[..component.rows.blocks()]);
    let may_choose = algebra == LinearAlgebra::Automatic && rows.equations() <= MOST_EQUATIONS;
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
            return Err(at(shape, c, row, dependent(shape, c, row, sine)));
        }
    }
    let equation = shape.equation_at(c, weakest);
    Err(at(shape, c, weakest, StartFailure::CannotAct { equation }))
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
    check_fixed(shape, &state)?;
    let mut start = Start::of(shape, &state);
    // What belongs to other components is left alone: the cost is that of all equations, however many components.
    let mut p = Body::momenta(&state.bodies);
    for c in 0..shape.components.len() {
        let (sine, _) = place(shape, c, algebra, &mut start, state.time)?;
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
        start.known = Known::default();
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
            if rate.abs() > START_TOLERANCE * scale
                && rate.abs() > scale * start.turned_near(shape, (c, row), state.time)
            {
                let equation = shape.equation_at(c, row);
                let contradict = StartFailure::RatesContradict { equation, rate };
                let cause = if moves { contradict } else { dependent(shape, c, row, sine) };
                return Err(at(shape, c, row, cause));
            }
        }
        for &body in &rows.bodies {
            let (q, p) = (start.q[body], p[body]);
            state.bodies[body] = Body { q, q_low: [0.0; D], p, p_low: [0.0; D] };
        }
    }
    Ok(state)
}

/// Moves a component onto its constraints. Returns the sine of its least independent normal there, and its row.
fn place<const D: usize>(
    shape: &mut Shape<D>,
    c: usize,
    algebra: LinearAlgebra,
    start: &mut Start<D>,
    time: f64,
) -> Result<(f64, usize), Error> {
    let m = shape.components[c].rows.equations();
    let mut x = vec![0.0; m];
    let mut distances: Vec<f64> = Vec::new();
    let (mut nearing, mut worst) = (Nearing::leaving(f64::INFINITY), 0);
    for _ in 0..MAX_PROJECTION_STEPS {
        start.evaluate(shape, c, time);
        let (mut distance, mut there, mut size) = (0.0, true, 0.0_f64);
        for row in 0..m {
            let length = start.length(shape, c, row);
            if length == 0.0 && start.g[row].is_finite() {
                let equation = shape.equation_at(c, row);
                let cause = StartFailure::Vanishes { equation, gradient: 0.0, distance: 0.0 };
                return Err(at(shape, c, row, cause));
            }
            there &= start.is_there(shape, c, row);
            size = size.max(start.along(shape, (c, row), &start.q)); // of what is pinned, too
            if length.is_finite() && length > 0.0 && !start.has_square(shape, c, row) {
                let equation = Some(shape.equation_at(c, row));
                return Err(at(shape, c, row, StartFailure::OutOfScale { equation, gradient: length }));
            }
            let off = start.g[row].abs() / length;
            if off > distance || off.is_nan() {
                (distance, worst) = (off, row);
            }
        }
        let Shape { components, roots, .. } = &mut *shape;
        let component = &mut components[c];
        component.solver.limit(m, BRANCHING);
        let blocks = &start.blocks[..component.rows.blocks()];
        let found = match bear(component, algebra, blocks, roots) {
            Ok(found) => found,
            Err((sine, row)) => return Err(at(shape, c, row, dependent(shape, c, row, sine))),
        };
        count_independent(shape, c, start, time);
        let Shape { components, roots, .. } = &mut *shape;
        let component = &mut components[c];
        let rows = &component.rows;
        let off: Vec<f64> = start.g[..m].iter().map(|g| -g).collect();
        component.solver.solve(&off, &mut x);
        let lift = &mut start.lift;
        rows.bodies.iter().for_each(|&body| lift[body] = [0.0; D]);
        component.solver.displace(rows, roots, &x, lift);
        let size = rows.bodies.iter().map(|&body| largest(&start.q[body])).fold(size, f64::max);
        let correction = rows.bodies.iter().map(|&body| largest(&lift[body])).fold(0.0, f64::max);
        if !(distance.is_finite() && correction.is_finite()) {
            let position = rows.touched_by(worst).flat_map(|(_, body)| start.q[body]).collect();
            let gradient = rows.touched_by(worst).flat_map(|(block, _)| start.blocks[block]).collect();
            let cause = StartFailure::ConstraintNotFinite { value: start.g[worst], gradient, position };
            return Err(at(shape, c, worst, cause));
        }
        let contradicts = distance > START_TOLERANCE * size;
        // Far off, a distance that is no longer halved may still shrink: light bodies go first. Links contradict each
        // other where nothing moves any more.
        let stays = correction <= if contradicts { ROUNDINGS * f64::EPSILON } else { f64::EPSILON } * size;
        if nearing.look(distance, stays && (there || contradicts), !contradicts).0 {
            if contradicts {
                let cause = StartFailure::Contradictory { equation: shape.equation_at(c, worst), distance };
                return Err(at(shape, c, worst, cause));
            }
            return Ok(found);
        }
        distances.push(distance);
        start.go(shape, c, time, distance);
    }
    let equation = shape.equation_at(c, worst);
    let distances = distances.into_iter().collect::<History>();
    Err(at(shape, c, worst, StartFailure::NoPlace { equation, distances }))
}

/// Whether links between pinned bodies alone hold.
fn check_fixed<const D: usize>(shape: &Shape<D>, state: &State<D>) -> Result<(), Error> {
    let q = places(shape, state);
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
        links.gradients(member..member + 1, state.time, &q, &mut g, &mut blocks, &mut rates);
        let size = bodies.iter().map(|&body| largest(&q[body])).fold(0.0, f64::max);
        for equation in 0..of {
            let blocks = &blocks[equation * arity..][..arity];
            let length = length_of(blocks.iter().flatten());
            let distance = g[equation].abs() / length;
            if links.moving() || distance.is_nan() || distance > START_TOLERANCE * size {
                let body = bodies[0];
                let link = links.name();
                let equation = Box::new(EquationAt { link, group, member, equation, of, bodies });
                let moving = links.moving();
                return Err(Error::Start {
                    body,
                    cause: StartFailure::BetweenPins { equation, distance, moving },
                });
            }
        }
    }
    Ok(())
}
