//! How many equations are independent at a start, and how well it tells the directions of normals.

use crate::motion::start::length_of;
use crate::number::vector::{dot, largest, scaled};
use crate::solve::aim::ROUNDINGS;
use crate::systems::linked::at_start::Start;
use crate::systems::network::orthogonal::BRANCHING;
use crate::systems::network::shape::{Component, Shape};
use crate::systems::network::solver::{CLEARLY, Solver};

/// Normals with a larger sine to those before are independent, whatever a start is off.
const APART: f64 = 0.1;

/// An equation that follows from others where these hold is left by a way onto them with what is of second order in it,
/// or of so many times that: it may be made of several of them.
const SECOND_ORDER: f64 = 16.0;

/// Equations that are independent at a place are looked at again where a way onto them may turn normals by this part of
/// what it may there.
const NEARER: f64 = 1e-3;

impl<const D: usize> Start<D> {
    /// By how much this way, if there is one, and some roundings of places may turn a normal; and by how much in the
    /// metric of M⁻¹.
    fn turned_by(&mut self, shape: &Shape<D>, row: usize, way: Option<&[[f64; D]]>) -> [f64; 2] {
        let rows = self.rows(shape);
        let (of, first) = (rows.find(&shape.groups, row), rows.range::<0>(row).start);
        let length = self.length(shape, row);
        let by_masses = self.by_masses(shape, row, (&self.blocks, 0)) / length;
        // Over |∇g| at once, so that there are squares however g is scaled.
        let (bodies, over) = (|| rows.touched_by(row).map(|(_, body)| body), 1.0 / length);
        let mut part = std::mem::take(&mut self.part);
        let mut turned = [0.0; 2];
        let mut add = |part: &[[f64; D]]| {
            let change = self.bend(shape, of, part);
            turned[0] += length_of(change.iter().flatten());
            turned[1] += self.by_masses(shape, row, (&change, first)) / by_masses;
        };
        if let Some(way) = way {
            bodies().for_each(|body| part[body] = scaled(over, &way[body]));
            add(&part);
            bodies().for_each(|body| part[body] = [0.0; D]);
        }
        for (body, i) in bodies().flat_map(|body| (0..D).map(move |i| (body, i))) {
            part[body][i] = over * (f64::EPSILON * self.q[body][i]);
            add(&part);
            part[body][i] = 0.0;
        }
        self.part = part;
        turned.map(|turned| ROUNDINGS * turned)
    }

    /// By how much some roundings of places may turn a normal.
    pub(super) fn turned(&mut self, shape: &Shape<D>, row: usize) -> f64 {
        self.turned_by(shape, row, None)[0]
    }

    /// By how much the way onto those equations that a component counts, and roundings, may turn each of its normals:
    /// those of what moves, and those of where it is, as an equation may be off by the rounding of places where g is 0.
    /// The way is written.
    fn turned_on_the_way(&mut self, shape: &mut Shape<D>, way: &mut [[f64; D]]) -> Vec<[f64; 2]> {
        let m = self.rows(shape).equations();
        let off: Vec<f64> = self.g[..m].iter().map(|g| -g).collect();
        let rounded = |row: usize| {
            let rounding = f64::EPSILON * self.along(shape, row, &self.q) * self.length(shape, row);
            off[row].abs().max(rounding).copysign(off[row])
        };
        let may_be_off: Vec<f64> = (0..m).map(rounded).collect();
        let Shape { components, roots, .. } = &mut *shape;
        let Component { rows, solver, .. } = &mut components[self.c];
        let mut x = vec![0.0; m];
        let mut lead = |off: &[f64], way: &mut [[f64; D]]| {
            solver.solve(off, &mut x);
            rows.bodies.iter().for_each(|&body| way[body] = [0.0; D]);
            solver.displace(rows, roots, &x, way);
        };
        let mut longest = vec![[0.0; D]; way.len()];
        lead(&may_be_off, &mut longest);
        lead(&off, way);
        (0..m).map(|row| self.turned_by(shape, row, Some(&longest))).collect()
    }

    /// By how much roundings of places may turn the normals of those equations that share a body with this one.
    pub(super) fn turned_near(&mut self, shape: &Shape<D>, row: usize) -> f64 {
        let rows = self.rows(shape);
        let known = self.known.turned.take().unwrap_or_else(|| {
            let mut most = vec![0.0_f64; rows.bodies.len()];
            for row in 0..rows.equations() {
                let turned = self.turned(shape, row);
                rows.blocks_of(row).for_each(|(_, body)| most[body] = most[body].max(turned));
            }
            most
        });
        let near = rows.blocks_of(row).map(|(_, body)| known[body]).fold(0.0, f64::max);
        self.known.turned = Some(known);
        near
    }

    /// Has the component, which has taken its normals over, count those equations alone that are independent of the
    /// others where these hold: their normals are at more than what the place being off and its rounding can turn any
    /// by of which they are made, or a way onto the others leaves them off. To be limited to no fewer before that.
    ///
    /// Elimination counts all. Where its least `sine` is no more than the way onto all may make of none, a basis, if it
    /// may, takes the place of elimination, and stays where it counts fewer.
    pub(super) fn count_independent(&mut self, shape: &mut Shape<D>, sine: f64) {
        if !matches!(shape.components[self.c].solver, Solver::Elimination(_)) {
            return self.count_by_basis(shape);
        }
        if !self.may_take_basis(self.rows(shape)) || sine > CLEARLY {
            return;
        }
        let mut way = std::mem::take(&mut self.lift); // of others it is not looked at
        let turned = self.turned_on_the_way(shape, &mut way);
        self.lift = way;
        let most = turned.iter().map(|[_, turned]| *turned).fold(0.0, f64::max);
        // One look far off, and one near by if that is far nearer: a basis of many equations takes long.
        if most < sine || most > NEARER * self.judged {
            return;
        }
        let Shape { components, roots, .. } = &mut *shape;
        let Component { rows, solver, .. } = &mut components[self.c];
        let elimination = std::mem::replace(solver, Solver::orthogonal(rows));
        solver.normals(rows, &self.blocks[..rows.blocks()], roots);
        self.count_by_basis(shape);
        let Component { rows, solver, .. } = &mut shape.components[self.c];
        if solver.rank(rows) == rows.equations() {
            *solver = elimination;
            self.judged = most;
        }
    }

    fn count_by_basis(&mut self, shape: &mut Shape<D>) {
        let (m, sines) = (self.rows(shape).equations(), shape.components[self.c].solver.sines());
        let above = |least: f64| sines.iter().take_while(|&&sine| sine > least).count();
        let mut counted = above(APART);
        if sines.is_empty() || counted == m {
            return;
        }
        let (doubtful, made_of) = (counted, shape.components[self.c].solver.made_of(counted));
        let rounding = self.rounding_of_all(shape, &self.q);
        let mut way = std::mem::take(&mut self.lift); // of others it is not looked at
        // How far off a start is shows the way onto those that are clearly apart. Some that are not may be by more than
        // it may turn normals by, and count for the way as well.
        let turned = loop {
            let Shape { components, roots, .. } = &mut *shape;
            let Component { rows, solver, .. } = &mut components[self.c];
            solver.limit(counted, f64::INFINITY);
            solver.normals(rows, &self.blocks[..rows.blocks()], roots);
            let turned = self.turned_on_the_way(shape, &mut way);
            let rows = self.rows(shape);
            let reach = rows.bodies.iter().map(|&body| largest(&way[body])).fold(0.0, f64::max);
            // What is left of one may be of second order in others from which it follows.
            let most = turned.iter().map(|[turned, _]| *turned).fold(0.0, f64::max);
            let least = (SECOND_ORDER / ROUNDINGS * most * reach).max(rounding);
            let holds = (0..m).all(|row| {
                let change = |(block, body): (usize, usize)| dot(&self.blocks[block], &way[body]);
                let left = self.g[row] + rows.touched_by(row).map(change).sum::<f64>();
                left.abs() <= least * self.length(shape, row)
            });
            // By how much the way may turn a normal away from one that is made of the others.
            let away = |k: usize| {
                let parts = made_of[k - doubtful].iter().map(|&(row, times)| times.abs() * turned[row][1]);
                parts.fold(0.0, f64::max)
            };
            let next = sines.get(counted).copied().unwrap_or(0.0);
            let apart = (counted..sines.len()).take_while(|&k| sines[k] > away(k).max(APART * next)).count();
            if apart > 0 {
                counted += apart;
            } else if !holds && next > BRANCHING {
                // The next one asks for something of its own, though masses make its sine small.
                counted = above((APART * next).max(BRANCHING)).max(counted + 1);
            } else {
                break turned.iter().map(|[_, turned]| *turned).fold(0.0, f64::max);
            }
        };
        self.lift = way;
        shape.components[self.c].solver.limit(counted, turned.max(BRANCHING)); // no other is beyond that here
    }
}
