//! Nothing depends on the units of length, time and mass: where these change by powers of two, so do all results, and
//! no bit else, but for roundings of inner steps of links by power series in lanes. Simulations, and ensembles in
//! lanes.

use crate::common::larger;
use rattle::bodies::{Count, One};
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::{Effects, Langevin, LinearDrag};
use rattle::links::planar::Rod;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::potentials::Wca;
use rattle::prelude::*;
use rattle::rigid::Rigid;
use rattle::scene::Hold;
use rattle::surfaces::Torus;
use rattle::{Brownian, Dop853, Geodesic, Taylor, Variable};

potential! {
    /// A force along the last coordinate of a body in space.
    struct Pull { force }
    |_x, _y, z| force * z
}

potential! {
    /// The same in the plane.
    struct Down { force }
    |_x, y| force * y
}

potential! {
    /// A weight on the third axis of a rigid body; without unit of length.
    struct Heavy { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

/// By how much numbers become larger.
#[derive(Clone, Copy)]
struct Units {
    length: f64,
    time: f64,
    mass: f64,
}

const ONE: Units = Units { length: 1.0, time: 1.0, mass: 1.0 };

impl Units {
    fn momentum(self) -> f64 {
        self.mass * self.length / self.time
    }
    fn force(self) -> f64 {
        self.momentum() / self.time
    }
    fn energy(self) -> f64 {
        self.force() * self.length
    }
    /// Large and small ones; those of atoms and of stars in SI units among them.
    fn all() -> impl Iterator<Item = Self> {
        let unit = |[length, time, mass]: [i32; 3]| {
            let [length, time, mass] = [length, time, mass].map(|n| 2.0_f64.powi(n));
            Self { length, time, mass }
        };
        let atoms = [-33, -50, -86];
        [[0, -60, 0], [0, 60, 0], [-40, 0, 0], [40, 0, 0], [0, 0, -90], [0, 0, 90], atoms, [40, 50, 100]]
            .into_iter()
            .map(unit)
    }
}

/// Places and momenta of all trajectories, as they are in units of one.
fn numbers<const D: usize>(state: &State<D>, place: f64, momentum: f64) -> Vec<f64> {
    let places = state.positions().flat_map(|q| <[f64; D]>::from(q).map(|x| x / place));
    places.chain(state.momenta().flat_map(|p| <[f64; D]>::from(p).map(|x| x / momentum))).collect()
}

/// Runs a scene as a simulation and as ensembles, and tells their ends.
fn ends<C, E, N, S, const D: usize>(
    scene: &Scene<C, E, N, D>,
    starts: &[State<D>],
    method: &S,
    [place, momentum]: [f64; 2],
    in_lanes: bool,
) -> Vec<Vec<f64>>
where
    C: Hold<D> + 'static,
    E: Effects<D> + 'static,
    N: Count,
    S: Method,
{
    let steps = 40;
    let mut alone = scene.simulate(starts[0].clone(), method.clone()).unwrap();
    alone.run(steps).unwrap_or_else(|error| panic!("{}: {error}", method.name()));
    let mut ends = vec![numbers(&alone.state(), place, momentum)];
    let mut double = scene.ensemble(starts.iter().cloned(), method.clone()).unwrap();
    let mut sums = scene.ensemble_in(Compensated, starts.iter().cloned(), method.clone()).unwrap();
    for ensemble in [&mut double, &mut sums] {
        let plan = ensemble.plan();
        assert_eq!(plan.in_lanes > 0, in_lanes, "{}: {:?}", method.name(), plan.reason);
        ensemble.run(steps);
        assert_eq!(ensemble.failures().count(), 0, "{}", method.name());
        ends.extend((0..starts.len()).map(|i| numbers(&ensemble.state(i), place, momentum)));
    }
    ends
}

/// Whether all ends are the same in all units.
fn check(what: &str, end: impl Fn(Units) -> Vec<Vec<f64>>) {
    let exact = end(ONE);
    assert!(exact.concat().iter().all(|x| x.is_finite()));
    for units in Units::all() {
        let Units { length, time, mass } = units;
        let found = end(units);
        let which = exact.iter().zip(&found).position(|(exact, found)| exact != found);
        let off = exact.concat().iter().zip(found.concat()).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
        let is_same = which.is_none() || (what == "double pendulum, Taylor, adaptive" && off < 1e-14);
        assert!(is_same, "{what}, length {length:e}, time {time:e}, mass {mass:e}: {which:?}, {off:e}");
    }
}

fn torus(units: Units) -> Scene<Torus, impl Effects<3> + Clone + 'static, One, 3> {
    Scene::on(Torus { major: 2.0 * units.length, minor: 0.5 * units.length })
        .with(Pull { force: 0.7 * units.force() })
}

fn on_a_torus<S: Method>(method: impl Fn(f64, Units) -> S, in_lanes: bool) {
    check(&format!("torus, {}", method(0.05, ONE).name()), |units| {
        let units = Units { mass: 1.0, ..units }; // as bodies on surfaces have
        let starts: Vec<_> = (0..5)
            .map(|i| {
                let p = [0.0, 0.5 + 0.1 * f64::from(i), 0.4].map(|x| x * units.momentum());
                State::at([2.5 * units.length, 0.0, 0.0]).moving(p)
            })
            .collect();
        ends(
            &torus(units),
            &starts,
            &method(0.05 * units.time, units),
            [units.length, units.momentum()],
            in_lanes,
        )
    });
}

#[test]
fn of_bodies_on_surfaces() {
    on_a_torus(|h, _| Rattle::new(h), true);
    on_a_torus(|h, _| Rattle::new(h).guess(Extrapolated), true);
    on_a_torus(|h, _| Shake::new(h), false);
    on_a_torus(|h, _| Geodesic::new(3, h), true);
    on_a_torus(|h, _| Bdf2::new(h), false);
    on_a_torus(|h, _| Composition::new(SUZUKI_1990_ORDER_4, h), true);
    on_a_torus(|h, _| Lobatto::<3>::new(h), true);
    on_a_torus(|h, _| Lobatto::<6>::new(h), true);
    on_a_torus(|h, _| Dop853::new(h), true);
    on_a_torus(|h, units| Dop853::adaptive(h, 2.0_f64.powi(-30) * units.length), true);
    on_a_torus(|h, _| Taylor::new(12, h), true);
    on_a_torus(|h, units| Taylor::adaptive(14, h, 2.0_f64.powi(-36) * units.length), true);
    on_a_torus(|h, units| Brownian::new(units.mass / units.time, 0.25 * units.energy(), 7, h / 64.0), true);
}

#[test]
fn of_flows_on_surfaces() {
    macro_rules! run {
        ($what:expr, $flow:expr) => {
            check($what, |units| {
                let units = Units { mass: 1.0, ..units };
                let scene = torus(units).with($flow(units));
                let start = State::at([2.5 * units.length, 0.0, 0.0])
                    .moving([0.0, 0.5, 0.4].map(|x| x * units.momentum()));
                let method = Baoab::new(0.05 * units.time);
                ends(&scene, &vec![start; 5], &method, [units.length, units.momentum()], true)
            })
        };
    }
    run!("Langevin", |units: Units| Langevin {
        friction: 0.5 / units.time,
        temperature: 0.25 * units.energy(),
        seed: 5,
    });
    run!("drag", |units: Units| LinearDrag::new(0.3 * units.mass / units.time));
}

fn double_pendulums<S: Method>(method: impl Fn(f64, Units) -> S, in_lanes: bool) {
    check(&format!("double pendulum, {}", method(0.05, ONE).name()), |units| {
        let scene = Scene::points(3)
            .masses([units.mass, units.mass, 1.5 * units.mass])
            .link(Rod { length: units.length }, [[0, 1], [1, 2]])
            .pin(0, [0.0, 0.0])
            .with(Down { force: 0.7 * units.force() });
        let place = |x: f64, y: f64| [x * units.length, y * units.length];
        let starts: Vec<_> = [[0.6, -0.8], [0.8, -0.6], [0.28, -0.96], [1.0, 0.0]]
            .map(|[x, y]| State::of([[0.0, 0.0], place(x, y), place(x, y - 1.0)]))
            .to_vec();
        ends(&scene, &starts, &method(0.05 * units.time, units), [units.length, units.momentum()], in_lanes)
    });
}

#[test]
fn of_links() {
    double_pendulums(|h, _| Rattle::new(h), true);
    double_pendulums(|h, _| Shake::new(h), false);
    double_pendulums(|h, _| Bdf2::new(h), false);
    double_pendulums(|h, _| Composition::new(SUZUKI_1990_ORDER_4, h), true);
    double_pendulums(|h, _| Lobatto::<3>::new(h), true);
    double_pendulums(|h, _| Dop853::new(h), true);
    double_pendulums(|h, units| Dop853::adaptive(h, 2.0_f64.powi(-30) * units.length), true);
    double_pendulums(|h, _| Taylor::new(12, h), true);
    double_pendulums(|h, units| Taylor::adaptive(14, h, 2.0_f64.powi(-36) * units.length), true);
}

#[test]
fn of_flows_on_links() {
    check("Langevin on links", |units| {
        let scene = Scene::points(3)
            .masses([units.mass, units.mass, 1.5 * units.mass])
            .link(Rod { length: units.length }, [[0, 1], [1, 2]])
            .with(Langevin { friction: 0.5 / units.time, temperature: 0.25 * units.energy(), seed: 5 });
        let start = State::of([[0.0, 0.0], [0.6, -0.8], [0.6, -1.8]].map(|q| q.map(|x| x * units.length)));
        let method = Baoab::new(0.05 * units.time);
        ends(&scene, &vec![start; 5], &method, [units.length, units.momentum()], true)
    });
}

fn tops<S: Method>(method: impl Fn(f64, Units) -> S, in_lanes: bool) {
    check(&format!("top, {}", method(0.05, ONE).name()), |units| {
        // An inertia is a mass here, as angles have no unit.
        let (inertia, spin) = (units.mass, units.mass / units.time);
        let body = Rigid::new([1.0, 2.0, 2.5].map(|x| x * inertia));
        let starts: Vec<_> = (0..5)
            .map(|i| Rigid::start(&Matrix3::identity(), &(Vector3::new(0.3, 0.1 * f64::from(i), 1.0) * spin)))
            .collect();
        let scene = Scene::rigid(body).with(Heavy { weight: 0.7 * spin / units.time });
        ends(&scene, &starts, &method(0.05 * units.time, units), [1.0, spin], in_lanes)
    });
}

#[test]
fn of_rigid_bodies() {
    tops(|h, _| Rattle::new(h), true);
    tops(|h, _| Composition::new(SUZUKI_1990_ORDER_4, h), true);
    tops(|h, _| Dop853::new(h), true);
    tops(|h, _| Dop853::adaptive(h, 2.0_f64.powi(-30)), true);
    tops(|h, _| Taylor::new(12, h), true);
    tops(|h, _| Taylor::adaptive(14, h, 2.0_f64.powi(-36)), true);
}

/// Bodies that fly at each other from beyond the cut-off: no force is there at the start, and steps are as long as they
/// may be until one is.
#[test]
fn of_variable_steps() {
    let steps = |units: Units| {
        let law = Wca { epsilon: units.energy(), sigma: units.length };
        let scene = Scene::points(2).mass(units.mass).with(law.within(1.5 * units.length));
        let places = [[0.0, 0.0, 0.0], [1.7, 0.25, 0.0]].map(|q| q.map(|x| x * units.length));
        let momenta = [[3.0, 0.0, 0.0], [-3.0, 0.0, 0.0]].map(|p| p.map(|x| x * units.momentum()));
        let start = State::of(places).with_momenta(momenta);
        let method = Variable::of(Rattle::new(0.02 * units.time), 0.25 * units.time);
        let mut alone = scene.simulate(start, method).unwrap();
        let (mut shortest, mut last) = (f64::INFINITY, 0.0);
        alone
            .run_with(60, |now| {
                let time = now.time() / units.time;
                (shortest, last) = (shortest.min(time - last), time);
            })
            .unwrap();
        (numbers(&alone.state(), units.length, units.momentum()), shortest)
    };
    let (_, shortest) = steps(ONE);
    assert!(shortest < 0.01, "{shortest}"); // there was a collision
    check("variable steps", |units| {
        let (end, shortest) = steps(units);
        vec![end, vec![shortest]]
    });
}

potential! {
    /// A spring that is pulled to and fro, and not at first.
    struct Shaken { stiffness, rate }
    |x, _y, _z, t| stiffness * (x - (rate * t)^2 * sin(rate * t))^2 / 2
}

/// What rests at first, where no force acts, is as free in its steps later.
#[test]
fn of_variable_steps_from_rest() {
    let steps = |units: Units| {
        let stiffness = 100.0 * units.mass / units.time / units.time;
        // A length of 1 is that of a metre in each unit: places of the potential are in units of length.
        let scene = Scene::point().mass(units.mass).with(Shaken { stiffness, rate: 1.0 / units.time });
        let method = Variable::of(Rattle::new(0.03 * units.time), 0.2 * units.time);
        let mut alone = scene.simulate(State::at([0.0; 3]), method).unwrap();
        let mut shortest = f64::INFINITY;
        let mut last = 0.0;
        alone
            .run_with(200, |now| {
                (shortest, last) = (shortest.min(now.time() - last), now.time());
            })
            .unwrap();
        shortest / units.time
    };
    let shortest = steps(ONE);
    assert!(shortest < 0.02, "{shortest}");
    for mass in [-90, -40, 40, 90].map(|n| 2.0_f64.powi(n)) {
        assert_eq!(steps(Units { mass, ..ONE }), shortest, "mass {mass:e}");
    }
}

/// Pairs with a cut-off, one of them beyond it at first.
#[test]
fn of_gases() {
    check("gas", |units| {
        let law = Wca { epsilon: units.energy(), sigma: units.length };
        let scene = Scene::points(4).mass(units.mass).with(law.within(1.5 * units.length));
        let places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.1, 0.1], [3.0, 0.0, 0.5]];
        let start = State::of(places.map(|q| q.map(|x| x * units.length)));
        let mut alone = scene.simulate(start, Rattle::new(0.01 * units.time)).unwrap();
        alone.run(40).unwrap();
        let energies = [alone.energy(), alone.kinetic_energy()].map(|x| x / units.energy());
        vec![numbers(&alone.state(), units.length, units.momentum()), energies.to_vec()]
    });
}
