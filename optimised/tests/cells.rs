//! Every method by every kind of bodies, in an ensemble: as a simulation but for rounding, in lanes where
//! `docs/guide/ensembles.md` says so, failures word for word, and the same bits beside any neighbours and by any number
//! of threads.

use crate::common::{SURFACE, bits};
use rattle::bodies::Count;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::{Effects, Langevin};
use rattle::ensemble::InstructionSet;
use rattle::links::planar::Rod;
use rattle::nalgebra::{Rotation3, Vector3};
use rattle::prelude::*;
use rattle::scene::Hold;

potential! {
    /// A pull along x, as far as a cliff: no force is known beyond it.
    struct Cliff { pull, end }
    |x, _y, _z| (end - x)^2.5 / 10 - pull * x
}
potential! {
    /// The same in the plane.
    struct PlanarCliff { pull, end }
    |x, _y| (end - x)^2.5 / 10 - pull * x
}
potential! {
    /// The same for the end of a body's third axis.
    struct TiltedCliff { pull, end }
    |q: [[f64; 3]; 3]| (end - q[0][2])^2.5 / 10 - pull * q[0][2]
}
phase_constraint! {
    /// The three-sphere, whose fibres are those of Hopf.
    struct Hopf { r }
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - r^2
}
hamiltonian! {
    /// A particle that is pulled to a cliff.
    struct Pulled { pull, end }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + (end - q[0])^2.5 / 10 - pull * q[0]
}

/// A pull that takes Brownian motion, too, over the last 0.02 before the cliff in 8 steps, and no one who starts
/// farther.
const PULL: f64 = 0.2;
const END: f64 = 0.1;
const NEAR: f64 = 0.02;
const STEP: f64 = 0.02;
const STEPS: u64 = 8;

const MOMENTS: [f64; 3] = [0.6, 0.8, 1.0];

/// More than a row of 64.
const TRAJECTORIES: usize = 70;

/// What an error says, numbers to nine digits: places differ by rounding.
fn words(error: &rattle::Error) -> String {
    let word = |word: &str| {
        let number = word.trim_matches(['(', ')', '[', ']', ',', ';']).parse::<f64>();
        number.map_or(word.to_owned(), |number| format!("{number:.8e}"))
    };
    error.to_string().split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// A column of the table: bodies of one kind, of a scene.
struct Column<'a, C, E, N, const D: usize> {
    what: &'a str,
    scene: Scene<C, E, N, D>,
    /// The start of each number; those of numbers that 9 divides go over the cliff.
    start: fn(usize) -> State<D>,
    /// What was found wrong.
    wrong: Vec<String>,
}

impl<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize> Column<'_, C, E, N, D> {
    fn start(&self, i: usize) -> State<D> {
        self.scene.project(&(self.start)(i)).unwrap().numbered(i as u64)
    }

    /// An ensemble of these trajectories, each with its own number wherever it stands.
    fn of(&self, numbers: impl Iterator<Item = usize>, method: &impl Method) -> Ensemble<D> {
        let starts = numbers.map(|i| self.start(i));
        self.scene.ensemble(starts, method.clone()).unwrap()
    }

    /// Compares after so many steps, by which those of the cliff have failed.
    fn by<S: Method>(&mut self, method: S, in_lanes: bool) {
        let name = format!("{} by {}", self.what, method.name());
        let mut all = self.of(0..TRAJECTORIES, &method);
        let fused = InstructionSet::widest().fuses(); // else all go alone
        if (all.plan().in_lanes == TRAJECTORIES) != (in_lanes && fused) {
            self.wrong.push(format!("{name}: {:?}", all.plan()));
        }
        all.run(STEPS);
        let (mut apart, mut failed) = (0.0_f64, 0);
        for i in 0..TRAJECTORIES {
            let mut alone = self.scene.simulate(self.start(i), method.clone()).unwrap();
            let ended = alone.run(STEPS);
            failed += usize::from(ended.is_err());
            if all.failure(i).map(words) != ended.as_ref().err().map(words) {
                self.wrong.push(format!("{name}, {i}: {:?}, alone {ended:?}", all.failure(i)));
            }
            let (state, own) = (all.state(i), alone.state());
            if (state.time(), state.steps()) != (own.time(), own.steps()) {
                self.wrong.push(format!("{name}, {i}: at {}, alone {}", state.time(), own.time()));
            }
            let pairs = state.positions().zip(own.positions()).chain(state.momenta().zip(own.momenta()));
            let off = pairs.map(|(a, b)| (a - b).amax()).fold(0.0, |a, b| if b <= a { a } else { b });
            apart = if off <= apart { apart } else { off };
        }
        println!("{name}: {apart:.1e}, {failed} failed");
        // A step rounds coordinates near 1 a few times, and so short a motion makes nothing larger.
        if !(apart < 1e-14) || (apart > 0.0) != (in_lanes && fused) {
            self.wrong.push(format!("{name}: {apart:e} apart"));
        }
        if failed != TRAJECTORIES.div_ceil(9) {
            self.wrong.push(format!("{name}: {failed} failed"));
        }
        let calm = || (0..TRAJECTORIES).filter(|i| i % 9 != 0);
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut beside = self.of(calm().rev(), &method);
            pool.install(|| beside.run(STEPS));
            let differ =
                calm().rev().zip(beside.states()).find(|(i, state)| bits(&all.state(*i)) != bits(state));
            if let Some((i, state)) = differ {
                self.wrong.push(format!("{name}, {i}: {:?} beside others, {state:?}", all.state(i)));
            }
        }
    }

    /// Methods for all bodies that have constraints on places; `lanes` where any has lanes.
    fn by_those_of_places(&mut self, lanes: bool) {
        self.by(Rattle::new(STEP), lanes);
        self.by(PositionVerlet::new(STEP), lanes);
        self.by(SymplecticEuler::new(STEP), lanes);
        self.by(Geodesic::new(3, STEP), lanes);
        self.by(Composition::new(SUZUKI_1990_ORDER_4, STEP), lanes);
        self.by(Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(STEP)), lanes);
        self.by(Composition::of(SUZUKI_1990_ORDER_4, Geodesic::new(2, STEP)), lanes);
        self.by(Brownian::new(1.0, 1e-6, 9, STEP), lanes);
        self.by(Dop853::new(STEP), lanes);
        self.by(Dop853::adaptive(STEP, 1e-10), lanes);
        self.by(Shake::new(STEP), false);
        self.by(NoseHoover::new(1.0, 1.0, STEP), false);
        self.by(Variable::of(Rattle::new(STEP), 10.0), false);
    }

    fn by_series(&mut self) {
        self.by(Taylor::new(10, STEP), true);
        self.by(Taylor::adaptive(12, STEP, 1e-10), true);
    }

    /// Methods that act on flows of momenta.
    fn by_those_of_flows(&mut self, lanes: bool) {
        self.by(Rattle::new(STEP), lanes);
        self.by(Baoab::new(STEP), lanes);
        self.by(Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(STEP)), lanes);
    }
}

/// The place along x and the speed there of trajectory i, which may go over the cliff.
fn along_x(i: usize) -> [f64; 2] {
    if i.is_multiple_of(9) { [END - NEAR, 1.0] } else { [-1e-3 * i as f64, (1.6 + 0.04 * i as f64).cos()] }
}

fn on_lemniscate(i: usize) -> State<3> {
    let [x, v] = along_x(i);
    let f = x.powi(4) - x * x;
    State::at([x, 0.0, (SURFACE.r.powi(2) - f * f).sqrt()]).moving([v, 0.3, 0.0])
}

/// Another one beside it, below, that stays far from the cliff.
fn two_on_lemniscate(i: usize) -> State<3> {
    let state = on_lemniscate(i);
    let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
    let f = 0.3_f64.powi(4) - 0.3_f64.powi(2);
    let other = [-0.3, 0.0, -(SURFACE.r.powi(2) - f * f).sqrt()];
    State::of([other.into(), q]).with_momenta([[0.0, 0.1, 0.0].into(), p])
}

/// Two rods; what has a place along x is the end of the second one, above that of the first one.
fn pendulum(i: usize) -> State<2> {
    let [x, v] = along_x(i);
    let y = (1.0 - x * x).sqrt();
    State::of([[0.0, 0.0], [0.0, 1.0], [x, 1.0 + y]]).with_momenta([[0.0; 2], [0.0; 2], [v * y, -v * x]])
}

fn body(i: usize) -> State<9> {
    let [x, v] = along_x(i);
    let rate = Vector3::new(0.1, v, -0.2);
    Rigid::start(
        Rotation3::from_axis_angle(&Vector3::y_axis(), x.asin()).matrix(),
        &rate.component_mul(&Vector3::from(MOMENTS)),
    )
}

/// With p at right angles to q − ∇V, where {g, H} vanishes. All come nearer to the cliff, most from far away.
fn in_phase_space(i: usize) -> State<2> {
    let [x, v] = along_x(i);
    let (x, y) = (if v < 1.0 { x - 0.6 } else { x }, 0.6);
    let across = x + PULL + (END - x).powf(1.5) / 4.0;
    let size = ((1.0 - x * x - y * y) / (across * across + y * y)).sqrt();
    State::at([x, y]).moving([-y * size, across * size])
}

#[test]
fn as_a_simulation_in_every_cell() {
    let heat = Langevin { friction: 1.0, temperature: 1e-3, seed: 3 };
    let (pull, end) = (PULL, END);
    let wrong = Vec::new();

    let scene = || Scene::on(SURFACE).with(Cliff { pull, end });
    let mut on_surface = Column { what: "surface", scene: scene(), start: on_lemniscate, wrong };
    on_surface.by_those_of_places(true);
    on_surface.by_series();
    on_surface.by(Lobatto::<2>::new(STEP), true);
    on_surface.by(Lobatto::<5>::new(STEP), true);
    on_surface.by(Bdf2::new(STEP), false);
    let wrong = on_surface.wrong;
    let mut warm = Column { what: "warm surface", scene: scene().with(heat), start: on_lemniscate, wrong };
    warm.by_those_of_flows(true);

    let wrong = warm.wrong;
    let mut two =
        Column { what: "two on a surface", scene: scene().bodies(2), start: two_on_lemniscate, wrong };
    two.by_those_of_places(false);

    let wrong = two.wrong;
    let scene = || Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0, 0.0]);
    let scene = || scene().with(PlanarCliff { pull, end });
    let mut linked = Column { what: "linked", scene: scene(), start: pendulum, wrong };
    linked.by_those_of_places(true);
    linked.by_series();
    linked.by(Lobatto::<3>::new(STEP), true);
    linked.by(Lobatto::<6>::new(STEP), true);
    linked.by(Bdf2::new(STEP), false);
    let wrong = linked.wrong;
    let mut warm = Column { what: "warm linked", scene: scene().with(heat), start: pendulum, wrong };
    warm.by_those_of_flows(true);

    let wrong = warm.wrong;
    let scene = || Scene::rigid(Rigid::new(MOMENTS)).with(TiltedCliff { pull, end });
    let mut rigid = Column { what: "rigid", scene: scene(), start: body, wrong };
    rigid.by_those_of_places(true);
    rigid.by_series();
    let wrong = rigid.wrong;
    let mut warm = Column { what: "warm rigid", scene: scene().with(heat), start: body, wrong };
    warm.by_those_of_flows(true);

    let wrong = warm.wrong;
    let scene = Scene::in_phase_space(Hopf { r: 1.0 }, Pulled { pull, end });
    let mut phase = Column { what: "phase space", scene, start: in_phase_space, wrong };
    phase.by(Rattle::new(STEP), true);
    phase.by(Composition::new(SUZUKI_1990_ORDER_4, STEP), true);

    assert!(phase.wrong.is_empty(), "{:#?}", phase.wrong);
}
