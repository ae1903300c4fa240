//! BDF2: its equations hold as they are written, and what it cannot do is an error.

use crate::common::linked::{Rod, chain, double_pendulum, weights};
use crate::common::*;
use rattle::Error;
use rattle::error::{MethodFailure, StepFailure};
use rattle::links::planar::TurningLine;
use rattle::prelude::*;

const H: f64 = 0.01;

/// Three states in turn, and λ of the last.
struct Three<const D: usize> {
    q: [Vec<[f64; D]>; 3],
    p: [Vec<[f64; D]>; 3],
    lambda: Vec<f64>,
}

impl<const D: usize> Three<D> {
    /// The numbers at 0, H and 2H after `skipped` steps, from a run that is recorded.
    fn of<Y: rattle::system::System<f64, D>>(mut simulation: Simulation<Y, Bdf2, D>, skipped: u64) -> Self {
        simulation.run(skipped).unwrap();
        let mut heard = Trajectory::with_multipliers(&simulation);
        simulation.observe(2, 1, &mut heard).unwrap();
        let multipliers = heard.multipliers().unwrap();
        let m = multipliers.position.len() / 3;
        assert_eq!(multipliers.position[m..], multipliers.momentum[m..], "there is one λ");
        let rows = |all: &[f64]| -> [Vec<[f64; D]>; 3] {
            let bodies: Vec<[f64; D]> = all.chunks(D).map(|x| x.try_into().unwrap()).collect();
            let n = bodies.len() / 3;
            std::array::from_fn(|i| bodies[i * n..][..n].to_vec())
        };
        let lambda = multipliers.position[2 * m..].to_vec();
        Self { q: rows(heard.positions()), p: rows(heard.momenta()), lambda }
    }

    /// (3x′ − 4x + x₋)/(2H) of a body's coordinate.
    fn difference([a, b, c]: &[Vec<[f64; D]>; 3], body: usize, i: usize) -> f64 {
        (3.0 * c[body][i] - 4.0 * b[body][i] + a[body][i]) / (2.0 * H)
    }

    /// Checks both equations, with the forces and normals that the test says, and unit masses times `mass`.
    fn check(&self, mass: f64, force: impl Fn(usize, usize) -> f64) {
        for body in 0..self.q[0].len() {
            for i in 0..D {
                // Roundings of coordinates of size 1 over H, and over H².
                let velocity = Self::difference(&self.q, body, i);
                let off = velocity - self.p[2][body][i] / mass;
                assert!(off.abs() <= 8.0 * f64::EPSILON / H, "body {body}, {i}: velocity is off by {off:e}");
                let change = Self::difference(&self.p, body, i);
                let off = change - force(body, i);
                assert!(off.abs() <= 8.0 * f64::EPSILON / H / H, "body {body}, {i}: force is off by {off:e}");
            }
        }
    }
}

#[test]
fn its_equations_hold_on_a_surface() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for skipped in [1, 40] {
        let found = Three::of(scene.simulate(billiard_45(), Bdf2::new(H)).unwrap(), skipped);
        let [normal] = rattle::kernel::ConstraintKernel::jacobian(&SURFACE.kernel::<f64>(), &found.q[2][0]);
        let gravity = [0.0, 0.0, -1.0];
        found.check(1.0, |_, i| gravity[i] + normal[i] * found.lambda[0]);
        assert!(found.lambda[0].abs() > 1e-3, "the surface does something");
    }
}

#[test]
fn its_equations_hold_for_linked_bodies() {
    let mass = 2.0;
    let scene = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0; 2]).mass(mass);
    let scene = scene.with(weights(&[0.0, mass, mass]));
    for skipped in [1, 150] {
        let found = Three::of(scene.simulate(double_pendulum(), Bdf2::new(H)).unwrap(), skipped);
        let q = &found.q[2];
        let pull = |rod: usize, i: usize| 2.0 * (q[rod][i] - q[rod + 1][i]) * found.lambda[rod];
        found.check(mass, |body, i| match body {
            0 => 0.0,
            1 => -pull(0, i) + pull(1, i) - if i == 1 { mass } else { 0.0 },
            _ => -pull(1, i) - if i == 1 { mass } else { 0.0 },
        });
    }
}

/// The pendulum loses energy, by a part that falls with h at least like its order; RATTLE does not.
#[test]
fn it_damps() {
    let scene = Scene::on(Pendulum { length: 1.0 }).with(PlanarGravity { g: 1.0 });
    let start = State::at([1.0, 0.0]);
    let lost = |h: f64| {
        let mut simulation = scene.simulate(start.clone(), Bdf2::new(h)).unwrap();
        simulation.run((50.0 / h).round() as u64).unwrap();
        -simulation.energy_error()
    };
    let [a, b] = [0.02, 0.01].map(lost);
    println!("{a:e} {b:e}");
    assert!(a > 1e-3 && a / b > 3.9, "{a:e} {b:e}");
    let mut rattle = scene.simulate(start, Rattle::new(0.01)).unwrap();
    rattle.run(5000).unwrap();
    assert!(rattle.energy_error().abs() < 0.1 * b, "{:e} {b:e}", rattle.energy_error());
}

#[test]
fn what_it_cannot_move_is_refused() {
    let turning = Scene::points(1).link_moving(TurningLine { omega: 1.0 }, [[0]]);
    let start = State::of([[1.0, 0.0]]).moving([0.0, 1.0]);
    assert!(matches!(turning.simulate(start, Bdf2::new(H)), Err(Error::CannotMove { method: "BDF2", .. })));
    let start = Rigid::start(&nalgebra::Matrix3::identity(), &[1.0, 0.0, 0.0].into());
    let rigid = Scene::rigid(Rigid::new([1.0; 3]));
    assert!(matches!(rigid.simulate(start, Bdf2::new(H)), Err(Error::CannotMove { method: "BDF2", .. })));
}

/// A failed step leaves places, momenta and what is remembered.
#[test]
fn a_step_that_is_too_long_is_an_error() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut simulation = scene.simulate(billiard_45(), Bdf2::new(0.2)).unwrap();
    let error = simulation.run(10_000).unwrap_err();
    let expected = matches!(
        error,
        Error::Step {
            cause: StepFailure::Method(MethodFailure::ImplicitNotSolved { .. })
                | StepFailure::Method(MethodFailure::NotProjected { .. }),
            ..
        }
    );
    assert!(expected, "{error}");
    assert!(simulation.steps() > 1);
    let before = bits(&simulation.state());
    simulation.step().unwrap_err();
    assert_eq!(bits(&simulation.state()), before);
}

constraint! {
    /// A rod from the origin whose equation has a slope of 1, so that g is known to a rounding of the coordinates, no
    /// better.
    struct Reach { length }
    |x, y| sqrt(x^2 + y^2) - length
}

/// What rounding leaves of g after a correction may be a third of what was there, and is then no reason to end.
#[test]
fn links_are_kept_to_rounding_and_that_is_enough() {
    let scene = Scene::point().link(Reach { length: 1.0 }, [[0]]).with(PlanarGravity { g: 1.0 });
    for part in [0.5_f64, 0.7, 0.9] {
        let angle = part * std::f64::consts::PI;
        let start = State::at([angle.sin(), -angle.cos()]);
        for h in [0.02, 0.01, 0.005] {
            let mut simulation = scene.simulate(start.clone(), Bdf2::new(h)).unwrap();
            let mut worst = 0.0_f64;
            simulation.run_with(2000, |now| worst = worst.max(now.constraint_residual())).unwrap();
            assert!(worst <= 3.0 * f64::EPSILON, "from {part} π, h = {h}: {worst:e}");
        }
    }
}

/// (2h/3)² times no force is none, where the square is beyond the numbers, too.
#[test]
fn a_pinned_body_stays_in_the_longest_steps() {
    let scene = Scene::points::<2>(1).pin(0, [1.5, -0.3]);
    let mut simulation = scene.simulate(State::at([1.5, -0.3]), Bdf2::new(1e200)).unwrap();
    simulation.run(3).unwrap();
    assert_eq!(simulation.positions().next(), Some([1.5, -0.3].into()));
}
