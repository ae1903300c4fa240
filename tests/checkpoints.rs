//! Checkpoints: what goes on from one is the run that was never stopped, in every bit of everything that is kept; and
//! what is no checkpoint of it is refused by name. Every method and kind of system is asked in `systems`.

use crate::common::linked::{Rod, double_pendulum};
use crate::common::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::checkpoint::{
    Checkpoint, CheckpointError, Data, Field, Record, Save, decode, encode, read, write,
};
use rattle::composition::{Coefficients, SUZUKI_1990_ORDER_4};
use rattle::effect::{
    Andersen, DryFriction, HardSpheres, Langevin, LinearDrag, SelfPropulsion, Stop, VelocityRescaling,
};
use rattle::method::{Failure, Fixed, Map, Witness};
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::potentials::LennardJones;
use rattle::prelude::*;
use rattle::real::Scalar;
use rattle::surfaces::Plane;
use rattle::system::{BodiesOf, System};
use std::fs;
use std::path::Path;

potential! {
    /// Weight that comes and goes.
    struct Tide { g, w }
    |_x, _y, z, t| g * sin(w * t) * z
}

force! {
    /// A push that comes and goes.
    struct Push { g, w }
    |_q: [f64; 3], v: [f64; 3], t| [g * sin(w * t), 0 * v[0], 0]
}

potential! {
    /// A weight on the third axis.
    struct Heavy { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

/// The bytes of all that is kept.
fn bytes(run: &(impl Checkpoint + ?Sized)) -> Vec<u8> {
    encode(&run.checkpoint())
}

/// Stopped after `first` steps and gone on from a file, against a run as a whole.
fn goes_on<R: Checkpoint>(begin: impl Fn() -> R, first: u64, then: u64) -> [R; 2] {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rattle");
    let (mut whole, mut parts) = (begin(), begin());
    whole.take_steps(first).unwrap();
    whole.save(&path).unwrap();
    parts.restore(&path).unwrap();
    assert_eq!(bytes(&parts), bytes(&whole));
    whole.take_steps(then).unwrap();
    parts.take_steps(then).unwrap();
    assert_eq!(parts.steps_taken(), first + then);
    assert!(bytes(&parts) == bytes(&whole), "not the same after {then} steps");
    [whole, parts]
}

fn on_a_ring(n: usize) -> State<3> {
    let angle = |i: usize| i as f64 / n as f64 * std::f64::consts::TAU;
    let places = (0..n).map(|i| [2.7 * angle(i).cos(), 2.7 * angle(i).sin(), 0.0]);
    State::of(places).with_momenta((0..n).map(|i| [0.0, 0.0, 0.3 + 0.1 * (i % 7) as f64]))
}

const RING: Torus = Torus { major: 2.0, minor: 0.7 };

#[test]
fn effects_go_on() {
    let bath = Langevin { friction: 0.4, temperature: 0.5, seed: 3 };
    let one = Scene::on(SURFACE).with(Gravity { g: 1.0 }).with(LinearDrag::new(0.01)).with(bath);
    goes_on(|| one.simulate(billiard_45().numbered(5).after_steps(9), Baoab::new(0.01)).unwrap(), 33, 150);
    let swimming = SelfPropulsion::new(0.7, 0.3, 5);
    let swimmer = Scene::on(SURFACE).with(swimming).with(LinearDrag::new(1.0));
    goes_on(|| swimmer.simulate(billiard_45(), Rattle::new(0.01)).unwrap(), 33, 150);
    let driven = Scene::on(Sphere { r: 1.0 }).with(Tide { g: 1.0, w: 2.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]).at_time(0.3);
    let [whole, parts] =
        goes_on(|| driven.simulate(start.clone(), Rattle::new(0.01)).unwrap().boxed(), 33, 150);
    assert!(whole.work() != 0.0 && parts.work() == whole.work());
    let liquid = LennardJones { epsilon: 0.1, sigma: 0.1 }.within(0.5);
    let gas = Scene::on(RING).bodies(70).with(liquid.periodic([8.0; 3]));
    goes_on(|| gas.simulate(on_a_ring(70), Rattle::new(0.02)).unwrap(), 33, 100);
}

#[test]
fn options_and_events_go_on() {
    let free = Scene::on(RING).bodies(9);
    let balls =
        || free.simulate(on_a_ring(9), Rattle::new(0.05)).unwrap().collide(HardSpheres::new(1.3)).unwrap();
    let larger =
        |of| free.simulate(on_a_ring(9), Rattle::new(0.05)).unwrap().collide(HardSpheres::new(of)).unwrap();
    let mut other = larger(1.2);
    let error = other.resume(&balls().checkpoint()).unwrap_err().to_string();
    assert!(error.contains("1.3") && error.contains("1.2"), "{error}");
    let [whole, parts] = goes_on(balls, 60, 200);
    assert!(whole.events() > 2 && parts.events() == whole.events(), "{}", whole.events());
    let fast = State::at([0.0, 0.0, SURFACE.r]).moving([4.0, 3.0, 0.0]);
    let retried = || Scene::on(SURFACE).simulate(fast.clone(), Bdf2::new(0.01)).unwrap().retry(8);
    goes_on(retried, 21, 50);
    let chain = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
    let chain = chain.with(PlanarGravity { g: 1.0 });
    let begin = || chain.simulate(double_pendulum(), Variable::of(Rattle::new(0.01), 0.5)).unwrap();
    let [whole, parts] = goes_on(begin, 100, 100);
    assert_eq!(parts.counts(), whole.counts());
}

/// Trajectories of which some fail: at speeds that the surface is too curved for.
fn starts(number: u32) -> impl Iterator<Item = State<3>> {
    (0..number).map(|i| {
        let (speed, angle) =
            ([0.7, 8.0 + 0.3 * f64::from(i % 60), 0.5, 1.2][i as usize % 4], 0.37 * f64::from(i));
        State::at([0.0, 0.0, SURFACE.r]).moving([speed * angle.cos(), speed * angle.sin(), 0.0])
    })
}

fn lanes_go_on<P: Precision>(precision: P, method: &impl Method, [first, then]: [u64; 2]) {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let begin = || scene.ensemble_in(precision, starts(100), method.clone()).unwrap();
    let [whole, parts] = goes_on(begin, first, then);
    let failures = |ensemble: &Ensemble<3>| {
        ensemble.failures().map(|(i, error)| (i, error.to_string())).collect::<Vec<_>>()
    };
    let failed = failures(&whole);
    assert!(failed.len() > 3 && failed.len() < 90, "{} of 100 fail", failed.len());
    assert_eq!(failures(&parts), failed);
    for i in 0..100 {
        assert_eq!(bits(&parts.state(i)), bits(&whole.state(i)), "{i}");
    }
}

#[test]
fn ensembles_go_on_with_those_that_failed() {
    let h = 0.01;
    for times in [[1, 1100], [64, 100], [1031, 100]] {
        lanes_go_on(Double, &Rattle::new(h), times);
    }
    lanes_go_on(Compensated, &Composition::new(SUZUKI_1990_ORDER_4, h), [40, 30]);
    lanes_go_on(Single, &Geodesic::new(2, h), [40, 60]);
    lanes_go_on(Double, &Dop853::new(h), [40, 30]);
    lanes_go_on(Double, &Taylor::new(8, h), [40, 30]); // by themselves
}

#[test]
fn sweeps_go_on_with_any_number_of_threads() {
    let scenes: Vec<_> =
        (0..130).map(|i| Scene::on(Lemniscate { a: 1.0, r: 0.1 + 1e-3 * f64::from(i) })).collect();
    let starts = (0..130).map(|i| State::at([0.0, 0.0, 0.1 + 1e-3 * f64::from(i)]).moving([2.0, 0.0, 0.0]));
    let starts: Vec<_> = starts.collect();
    let begin =
        || Ensemble::sweep(Double, scenes.iter().zip(starts.clone()), Rattle::new(0.01)).unwrap().retry(4);
    let mut whole = begin();
    whole.run(700);
    let checkpoint = encode(&whole.checkpoint());
    whole.run(700);
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut parts = begin();
        parts.resume(&decode(&checkpoint, "").unwrap()).unwrap();
        pool.install(|| parts.run(700));
        assert!(bytes(&parts) == bytes(&whole), "{threads} threads");
    }
}

/// What a checkpoint of `file` says to a simulation that is another.
fn refused(file: &impl Checkpoint, mut here: impl Checkpoint, words: &str) {
    let before = bytes(&here);
    let error = here.resume(&file.checkpoint()).unwrap_err().to_string();
    assert!(error.contains(words), "{error}");
    assert!(bytes(&here) == before, "touched by what it refused: {error}");
}

#[test]
fn another_run_is_refused_by_name() {
    let scene = |r: f64, g: f64| Scene::on(Lemniscate { a: 1.0, r }).with(Gravity { g });
    let start = || State::at([0.0, 0.0, SURFACE.r]).moving([1.0, 0.0, 0.0]);
    let (h, r) = (0.01, SURFACE.r);
    let mut file = scene(r, 1.0).simulate(start(), Rattle::new(h)).unwrap();
    file.run(10).unwrap();
    let same = scene(r, 1.0);
    refused(
        &file,
        scene(r, 1.0 + 1e-6).simulate(start(), Rattle::new(h)).unwrap(),
        "(effect 0): it was written by Gravity with",
    );
    refused(
        &file,
        same.simulate(start(), Rattle::new(0.02)).unwrap(),
        "(method): it was written by RATTLE (Rattle) with 0.01",
    );
    refused(&file, same.simulate(start(), Geodesic::new(2, h)).unwrap(), "(method)");
    let other = scene(r + 1e-9, 1.0);
    let near = other.project(&start()).unwrap();
    refused(&file, other.simulate(near, Rattle::new(h)).unwrap(), "(constraints)");
    refused(
        &file,
        same.simulate(start(), Rattle::new(h)).unwrap().retry(3),
        "(options): it was written by none, and here is retry",
    );
    let two = Scene::on(SURFACE).bodies(2).with(Gravity { g: 1.0 });
    refused(
        &file,
        two.simulate(State::of([[0.0, 0.0, r]; 2]), Rattle::new(h)).unwrap(),
        "`q`, numbers of shape [2, 3]",
    );
    let no_weight = Scene::on(SURFACE).simulate(start(), Rattle::new(h)).unwrap();
    refused(&file, no_weight, "(system)");
    refused(
        &file,
        same.ensemble([start()], Rattle::new(h)).unwrap(),
        "(kind): it was written by a simulation, and here is an ensemble",
    );
    let bath = |seed| Scene::on(SURFACE).with(Langevin { friction: 1.0, temperature: 1.0, seed });
    let bathed = bath(1).simulate(start(), Rattle::new(h)).unwrap();
    refused(
        &bathed,
        bath(2).simulate(start(), Rattle::new(h)).unwrap(),
        "(flow 0): it was written by Langevin (random) with",
    );
    let chain = |m: f64| Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).masses([1.0, 1.0, m]);
    let hanging = chain(1.0).simulate(double_pendulum(), Rattle::new(h)).unwrap();
    refused(&hanging, chain(2.0).simulate(double_pendulum(), Rattle::new(h)).unwrap(), "(masses)");
    let pinned = chain(1.0).pin(0, [0.0; 2]);
    refused(&hanging, pinned.simulate(double_pendulum(), Rattle::new(h)).unwrap(), "(masses)");
    let lanes = |n| same.ensemble(starts(n), Rattle::new(h)).unwrap();
    refused(&lanes(70), lanes(71), "written by one of 70 trajectories");
    refused(&lanes(70), scene(r, 2.0).ensemble(starts(70), Rattle::new(h)).unwrap(), "(effect 0)");
    refused(&lanes(70), same.ensemble(starts(70), Rattle::new(0.02)).unwrap(), "(method)");
}

/// A method that is another by one number, which is not the largest.
fn methods_differ<S: Method>(one: &S, other: &S) {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let alone = |method: &S| scene.simulate(billiard_45(), method.clone()).unwrap();
    refused(&alone(one), alone(other), "run (method)");
    alone(one).resume(&alone(one).checkpoint()).unwrap();
    let lanes = |method: &S| scene.ensemble(vec![billiard_45(); 3], method.clone()).unwrap();
    refused(&lanes(one), lanes(other), "run (method)");
    lanes(one).resume(&lanes(one).checkpoint()).unwrap();
}

/// Steps of a part of h.
#[derive(Debug, Clone, PartialEq)]
struct Slower(f64);

impl Map for Slower {
    const NAME: &'static str = "slower";
    const ORDER: u32 = 0;
    const SYMMETRIC: bool = false;
    fn parameters(&self) -> Vec<f64> {
        vec![self.0]
    }
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.drift(0.0, self.0 * h, bodies, witness)
    }
}

#[test]
fn every_parameter_of_a_method_counts() {
    let (h, large) = (0.01, 0xFEDC_BA98_7654_3210);
    let brownian = |friction, temperature, seed| Brownian::new(friction, temperature, seed, h);
    methods_differ(&brownian(1e6, 0.5, 7), &brownian(1e6, 0.5, 8));
    methods_differ(&brownian(1.0, 0.5, large), &brownian(1.0, 0.5, large + 1));
    methods_differ(&brownian(1.0, 0.5, large), &brownian(1.0, 0.5, large ^ 1 << 32));
    methods_differ(&brownian(1.0, 0.5, large), &brownian(1.0, 0.5 + 1e-6, large));
    methods_differ(&brownian(1.0, 0.5, large), &Brownian::new(1.0, 0.5, large, h + 1e-9));
    methods_differ(&Dop853::adaptive(h, 1e-12), &Dop853::adaptive(h, 1e-13));
    methods_differ(&Taylor::adaptive(8, h, 1e-12), &Taylor::adaptive(8, h, 1e-13));
    methods_differ(&Taylor::new(8, h), &Taylor::new(9, h));
    methods_differ(&NoseHoover::new(1e-12, 1.0, h), &NoseHoover::new(2e-12, 1.0, h));
    methods_differ(&Baoab::with_inner(2, h), &Baoab::with_inner(3, h));
    methods_differ(&Variable::of(Geodesic::new(2, h), 0.5), &Variable::of(Geodesic::new(3, h), 0.5));
    methods_differ(&Fixed::of(Slower(0.5), h), &Fixed::of(Slower(0.6), h));
    let own = |gammas| Coefficients { name: "own", order: 2, gammas };
    let both = [own(&[0.25, 0.5, 0.25]), own(&[0.2, 0.6, 0.2])];
    methods_differ(&Composition::new(both[0], h), &Composition::new(both[1], h));
    let [one, other] = both.map(|of| Composition::of(of, Lobatto::<3>::new(h)));
    methods_differ(&one, &other);
}

#[test]
fn every_parameter_of_an_effect_counts() {
    macro_rules! differ {
        ($one:expr, $other:expr, $part:expr) => {
            let run = |effect| {
                let scene = Scene::on(SURFACE).with(effect);
                scene.simulate(billiard_45(), Rattle::new(0.01)).unwrap()
            };
            refused(&run($one), run($other), $part);
            let lanes = |effect| {
                let scene = Scene::on(SURFACE).with(effect);
                scene.ensemble(vec![billiard_45(); 3], Rattle::new(0.01)).unwrap()
            };
            refused(&lanes($one), lanes($other), $part);
            run($one).resume(&run($one).checkpoint()).unwrap();
            lanes($one).resume(&lanes($one).checkpoint()).unwrap();
        };
    }
    let large = 0xFEDC_BA98_7654_3210;
    let bath = |friction, temperature, seed| Langevin { friction, temperature, seed };
    differ!(bath(1.0, 0.5, large), bath(1.0, 0.5, large + 1), "flow 0)");
    differ!(bath(1.0, 0.5, large), bath(1.0 + 1e-6, 0.5, large), "flow 0)");
    differ!(bath(1.0, 0.5, large), bath(1.0, 0.5 + 1e-6, large), "flow 0)");
    let collisions = |rate, temperature, seed| Andersen { rate, temperature, seed };
    differ!(collisions(1.0, 0.5, 7), collisions(1.0, 0.5, 8), "flow 0)");
    differ!(collisions(1.0, 0.5, 7), collisions(1.1, 0.5, 7), "flow 0)");
    differ!(collisions(1.0, 0.5, 7), collisions(1.0, 0.6, 7), "flow 0)");
    let rescaled = |time, temperature, seed| VelocityRescaling { time, temperature, seed };
    differ!(rescaled(1.0, 0.5, 7), rescaled(1.0, 0.5, 8), "flow 0)");
    differ!(rescaled(1.0, 0.5, 7), rescaled(1.1, 0.5, 7), "flow 0)");
    differ!(rescaled(1.0, 0.5, 7), rescaled(1.0, 0.6, 7), "flow 0)");
    let swims = |turning, seed| SelfPropulsion::new(0.7, turning, seed).headed([[1.0, 0.0, 0.0]]);
    differ!(swims(0.3, 7), swims(0.3, 8), "flow 0)");
    differ!(swims(0.3, 7), swims(0.4, 7), "flow 0)");
    differ!(Tide { g: 1.0, w: 2.0 }, Tide { g: 1.0, w: 3.0 }, "run (effect 0)");
    differ!(Push { g: 1.0, w: 2.0 }, Push { g: 1.0, w: 3.0 }, "run (flow 0)");
    let on_top = |r: f64| State::at([0.0, 0.0, r]);
    let resting = |coefficient| Scene::on(Sphere { r: 1.0 }).with(DryFriction { coefficient });
    let rests = |mu| resting(mu).simulate(on_top(1.0), Rattle::new(0.01)).unwrap();
    refused(&rests(0.5), rests(0.6), "run (parameters of flow 0): it was written by DryFriction with 0.5");
    let pair = |sigma| Scene::points(2).with(LennardJones { epsilon: 1.0, sigma }.within(2.0));
    let out_of_reach = || State::of([[0.0; 3], [9.0, 0.0, 0.0]]);
    let far = |sigma| pair(sigma).simulate(out_of_reach(), Rattle::new(0.01)).unwrap();
    refused(&far(0.5), far(0.6), "run (effect 0): it was written by");
    let small = |r| Scene::on(Sphere { r }).simulate(on_top(r), Rattle::new(0.01)).unwrap();
    refused(&small(1e-9), small(2e-9), "run (constraints): it was written by one with constraints of");
}

#[test]
fn every_parameter_of_a_contact_counts() {
    let free = Scene::points::<3>(3);
    let plane = |d| Plane { a: 0.0, b: 0.0, c: 1.0, d };
    macro_rules! differ {
        ($one:expr, $other:expr) => {
            let start = || State::of([[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [4.0, 0.0, 1.0]]);
            let run =
                |contacts| free.simulate(start(), Rattle::new(0.01)).unwrap().collide(contacts).unwrap();
            refused(&run($one), run($other), "run (options)");
            run($one).resume(&run($one).checkpoint()).unwrap();
        };
    }
    differ!(Stop::above(plane(0.0)), Stop::above(plane(-1e-3)));
    differ!(Stop::above(plane(0.0)).over([[0], [1]]), Stop::above(plane(0.0)).over([[0], [2]]));
    differ!(Stop::above(plane(0.0)).restitution(0.5), Stop::above(plane(0.0)).restitution(0.6));
    differ!(HardSpheres::new(0.5).restitution(0.5), HardSpheres::new(0.5).restitution(0.6));
}

phase_constraint! {
    /// The three-sphere.
    struct Hopf {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}

hamiltonian! {
    /// A charge that falls.
    struct Charge { b, g }
    |q: [f64; 2], p: [f64; 2]| ((p[0] + b * q[1])^2 + (p[1] - b * q[0])^2) / 2 + g * q[1]
}

/// What lanes that are run by (g, h) say to the checkpoint of others: the step is told as the method, and g as this
/// part. Momenta are ahead in lanes, by what depends on both.
fn lanes_refused<const D: usize>(begin: impl Fn(f64, f64) -> Ensemble<D>, part: &str) {
    let run = |g: f64, h: f64| {
        let mut ensemble = begin(g, h);
        ensemble.run(10);
        assert!(ensemble.plan().in_lanes > 0, "{:?}", ensemble.plan());
        ensemble
    };
    let file = run(1.0, 0.01);
    refused(&file, run(1.0, 0.02), "run (method)");
    refused(&file, run(1.1, 0.01), part);
    let mut same = begin(1.0, 0.01);
    same.resume(&file.checkpoint()).unwrap();
    assert!(bytes(&same) == bytes(&file));
}

#[test]
fn lanes_name_the_part_that_differs() {
    let on = |g| Scene::on(SURFACE).with(Gravity { g });
    lanes_refused(|g, h| on(g).ensemble(starts(3), Rattle::new(h)).unwrap(), "run (effect 0)");
    let bath = |g| on(g).with(Langevin { friction: 0.4, temperature: 0.5, seed: 3 });
    lanes_refused(|g, h| bath(g).ensemble(starts(3), Rattle::new(h)).unwrap(), "run (effect 0)");
    let chain = |g| {
        let chain = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
        chain.with(PlanarGravity { g })
    };
    let hanging = || vec![double_pendulum(); 3];
    lanes_refused(|g, h| chain(g).ensemble(hanging(), Rattle::new(h)).unwrap(), "run (effect 0)");
    lanes_refused(|g, h| chain(g).ensemble(hanging(), Dop853::new(h)).unwrap(), "run (effect 0)");
    let top = |g| Scene::rigid(Rigid::new([0.6, 0.8, 1.0])).with(Heavy { weight: g });
    let turning = || vec![Rigid::start(&Matrix3::identity(), &Vector3::new(0.3, 0.2, 1.0)); 3];
    lanes_refused(|g, h| top(g).ensemble(turning(), Rattle::new(h)).unwrap(), "run (effect 0)");
    lanes_refused(|g, h| top(g).ensemble(turning(), Dop853::new(h)).unwrap(), "run (effect 0)");
    let charge = |g| Scene::in_phase_space(Hopf {}, Charge { b: 0.2, g });
    let begin = |g, h| {
        let place = charge(g).project(&State::at([-0.55, -0.83]).moving([0.03, 0.02])).unwrap();
        charge(g).ensemble(vec![place; 3], Rattle::new(h)).unwrap()
    };
    lanes_refused(begin, "run (kinetic energy)");
    let heavy = |m: f64| chain(1.0).masses([1.0, 1.0, m]);
    lanes_refused(|m, h| heavy(m).ensemble(hanging(), Rattle::new(h)).unwrap(), "run (masses)");
}

/// A small checkpoint of everything that there is.
fn small() -> Record {
    let mut simulation = Scene::on(SURFACE).simulate(billiard_45(), Bdf2::new(0.01)).unwrap();
    simulation.run(3).unwrap();
    simulation.checkpoint()
}

#[test]
fn what_is_no_checkpoint_says_what_it_is() {
    let whole = encode(&small());
    assert_eq!(encode(&decode(&whole, "run").unwrap()), whole);
    let told = |bytes: &[u8]| decode(bytes, "run").unwrap_err().to_string();
    for end in 0..whole.len() {
        assert!(told(&whole[..end]).contains("run: cut off"), "{end}: {}", told(&whole[..end]));
    }
    assert!(told(b"PK\x03\x04 an archive").contains("no checkpoint of rattle"));
    let mut longer = whole.clone();
    longer.push(0);
    assert!(told(&longer).contains("more bytes follow"));
    let mut newer = whole.clone();
    newer[8] = 2;
    assert!(told(&newer).contains("version 2, and versions up to 1 are known"), "{}", told(&newer));
    // Lengths beyond all memory, in a file that is whole otherwise.
    for (at, kind) in [(20, "fields"), (28, "name")] {
        let mut beyond = whole.clone();
        beyond[at..at + 4].fill(0xff);
        let sum = beyond.len() - 4;
        let crc = crc32(&beyond[..sum]).to_le_bytes();
        beyond[sum..].copy_from_slice(&crc);
        assert!(told(&beyond).contains("its fields are none"), "{kind}: {}", told(&beyond));
    }
}

/// CRC-32 as everyone computes it, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(sum & 1)))
    })
}

/// Changes a file in some places, cuts it, or adds to it; one time in two its check sum is made to fit again, so that
/// what stands behind it is tried. No such file is taken for what it was, none takes a simulation with it.
fn fuzz(times: u32) {
    let (whole, mut random) = (encode(&small()), StdRng::seed_from_u64(16));
    let mut simulation = Scene::on(SURFACE).simulate(billiard_45(), Bdf2::new(0.01)).unwrap();
    let before = bytes(&simulation);
    let (mut refused, mut kept) = (0, 0);
    for time in 0..times {
        let mut file = whole.clone();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..file.len());
            match random.random_range(0..4) {
                0 => file.truncate(at.max(1)),
                1 => file.insert(at, random.random()),
                2 => file[at] = random.random(),
                _ => file[at] ^= 1 << random.random_range(0..8),
            }
        }
        if file == whole {
            continue;
        }
        if time % 2 == 0 && file.len() > 24 {
            let length = (file.len() - 24) as u64;
            file[12..20].copy_from_slice(&length.to_le_bytes());
            let sum = file.len() - 4;
            let crc = crc32(&file[..sum]).to_le_bytes();
            file[sum..].copy_from_slice(&crc);
        }
        match decode(&file, "run") {
            Err(_) => refused += 1,
            Ok(record) => {
                assert!(time % 2 == 0, "a changed file was taken for whole");
                kept += 1;
                if simulation.resume(&record).is_ok() {
                    let _ = simulation.run(2); // on numbers that no one wrote, but numbers
                    simulation.resume(&decode(&before, "").unwrap()).unwrap();
                }
                assert!(bytes(&simulation) == before);
            }
        }
    }
    assert!(refused > times / 3 && kept > times / 20, "{refused} refused, {kept} whole");
}

#[test]
fn no_changed_file_is_taken() {
    fuzz(500);
}

/// `cargo test --release --test files checkpoints:: -- --ignored a_million_changed_files`
#[test]
#[ignore = "takes a minute"]
fn a_million_changed_files() {
    fuzz(1_000_000);
}

/// A pendulum of polynomials, whose bits are the same on every processor.
fn pendulum() -> Simulation<impl System<f64, 2>, Rattle, 2> {
    let scene = Scene::on(Pendulum { length: 1.0 }).with(PlanarGravity { g: 1.0 });
    scene.simulate(State::at([0.6, 0.8]), Rattle::new(0.01)).unwrap()
}

/// No more is read than a checkpoint may have: neither of what never ends, nor where nothing is.
#[cfg(unix)]
#[test]
fn files_without_an_end_are_refused_at_once() {
    for endless in ["/dev/full", "/dev/zero"] {
        assert!(matches!(read(endless), Err(CheckpointError::Foreign { .. })), "{endless}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hole");
    for (head, promised) in [(0_u64, false), (1 << 45, true)] {
        let mut bytes = b"\x89RATTLE\n\x01\0\0\0".to_vec();
        bytes.extend(head.to_le_bytes());
        fs::write(&path, if promised { bytes } else { Vec::new() }).unwrap();
        fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(1 << 40).unwrap();
        let error = read(&path).unwrap_err();
        let right = match error {
            CheckpointError::Foreign { .. } => !promised,
            CheckpointError::Truncated { has, of, .. } => promised && has == 1 << 40 && of == (1 << 45) + 24,
            _ => false,
        };
        assert!(right, "{error:?}");
    }
}

/// A file that was written when version 1 was new. Should this fail, files of users cannot be read any more: the
/// version goes up, and version 1 is read as well.
#[test]
fn files_of_version_1_are_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/pendulum_1.rattle");
    if std::env::var_os("RATTLE_WRITE_GOLDEN").is_some() {
        let mut simulation = pendulum();
        simulation.run(100).unwrap();
        simulation.save(&path).unwrap();
    }
    let mut restored = pendulum();
    restored.restore(&path).unwrap();
    restored.run(100).unwrap();
    let mut whole = pendulum();
    whole.run(200).unwrap();
    assert_eq!(bits(&restored.state()), bits(&whole.state()));
    let record = read(&path).unwrap();
    let Some(Field { shape, data: Data::Numbers(q), .. }) = record.field("q") else { panic!("no field `q`") };
    assert_eq!((&shape[..], q.len()), (&[1, 2][..], 2));
    assert_eq!(encode(&record), fs::read(&path).unwrap());
}

#[test]
fn a_full_disk_and_a_closed_folder_leave_all_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rattle");
    let mut simulation = pendulum();
    simulation.run(5).unwrap();
    simulation.save(&path).unwrap();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "something is left beside the file");
    simulation.run(5).unwrap();
    let (file, before) = (fs::read(&path).unwrap(), bytes(&simulation));
    let told = |path: &Path| {
        let error = simulation.save(path).unwrap_err();
        assert!(matches!(error, CheckpointError::Io { .. }), "{error}");
        assert!(bytes(&simulation) == before);
        error.to_string()
    };
    told(folder.path()); // is a folder
    told(&folder.path().join("missing/run.rattle"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/dev/full", folder.path().join("run.rattle.part")).unwrap();
        assert!(told(&path).contains("No space left on device"));
        assert!(told(Path::new("/dev/full")).contains("no plain file"));
        told(Path::new("/proc/run.rattle")); // where no one can write
    }
    assert_eq!(fs::read(&path).unwrap(), file);
    let mut restored = pendulum();
    restored.restore(&path).unwrap();
    assert_eq!(restored.steps(), 5);
    simulation.save(&path).unwrap();
    write(&simulation.checkpoint(), &path).unwrap(); // what is there is replaced
}
