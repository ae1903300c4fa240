//! Scenes whose prices are counted: an evaluation costs a microsecond.

use crate::common::{PlanarGravity, Row, billiard_45, larger, table};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rattle::bodies::{Count, Many, One};
use rattle::effect::{Effects, OnEach, With};
use rattle::links::planar::{Rod, Slider};
use rattle::nalgebra::Matrix3;
use rattle::network::Network;
use rattle::prelude::*;
use rattle::price::{Clock, Planned, Prices};
use rattle::scene::Hold;
use rattle::{Error, counted::Counts};
use std::fmt;

constraint! {
    /// Several surfaces in one type, each with its weight: what is compiled once serves all.
    pub(crate) struct Several { sphere, torus, lemniscate, quadric, a, b, c, wave, k }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - (x^2 - y^2);
        let ring = sqrt(x^2 + y^2) - 1;
        sphere * (x^2 + y^2 + z^2 - 4)
            + torus * (ring^2 + z^2 - 0.09)
            + lemniscate * (f^2 + z^2 - 1 / 36)
            + quadric * (a * x^2 + b * y^2 + c * z^2 - 1 + wave * sin(k * x + 0.3) * cos(k * y) * sin(k * z + 0.7))
    }
}

potential! {
    /// Weight, a spring, a wave, and a kink.
    pub(crate) struct Forces { g, spring, wave, kink }
    |x, y, z| g * z + spring * (x - 0.3)^2 / 2 + wave * cos(2 * x + y) * sin(z - y) + kink * abs(x - 0.2)
}

potential! {
    /// Weight of a body whose centre of mass lies on its third axis.
    pub(crate) struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

pub(crate) const NONE: Several = Several {
    sphere: 0.0,
    torus: 0.0,
    lemniscate: 0.0,
    quadric: 0.0,
    a: 1.0,
    b: 1.0,
    c: 1.0,
    wave: 0.0,
    k: 1.0,
};
pub(crate) const FREE: Forces = Forces { g: 0.0, spring: 0.0, wave: 0.0, kink: 0.0 };

/// A scene whose evaluations are counted, at a microsecond each.
pub(crate) struct Counting<C, E, N, const D: usize> {
    pub(crate) name: String,
    pub(crate) scene: Scene<C, E, N, D>,
    pub(crate) start: State<D>,
    pub(crate) duration: f64,
    pub(crate) counts: Vec<Counts>,
    /// Positions at the end, of the bodies that come last; none where a series of another order is to tell.
    pub(crate) exact: Option<Vec<f64>>,
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Counting<C, E, N, D> {
    pub(crate) fn clock(&self) -> Clock {
        let counts = self.counts.clone();
        Clock::of(move || 1e-6 * counts.iter().map(|counts| counts.all()).sum::<u64>() as f64)
    }

    pub(crate) fn within(&self, wish: f64, budget: f64) -> Result<Planned<D>, Error> {
        self.scene.within(wish).budget(budget).clock(self.clock()).simulate(&self.start, self.duration)
    }

    /// The exact positions at the end; else by a series of another order and other steps than any reference of prices
    /// has.
    pub(crate) fn truth(&self) -> Vec<f64> {
        self.exact.clone().unwrap_or_else(|| {
            let steps = (self.duration / 0.07).ceil();
            let method = Taylor::adaptive(26, self.duration / steps, 1e-18);
            let mut exact = self.scene.simulate(self.start.clone(), method).unwrap();
            exact.run(steps as u64).unwrap();
            exact.positions().flat_map(<[f64; D]>::from).collect()
        })
    }

    /// The farthest that a body is from there; NaN where a number is.
    pub(crate) fn off(&self, now: &BoxedSimulation<D>, truth: &[f64]) -> f64 {
        let now: Vec<f64> = now.positions().flat_map(<[f64; D]>::from).collect();
        let last = &now[now.len() - truth.len()..];
        let bodies = last.chunks(D).zip(truth.chunks(D));
        let distance =
            |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        bodies.map(distance).fold(0.0, larger)
    }

    /// All ladders, whole.
    pub(crate) fn prices(&self, budget: f64) -> Prices {
        self.scene.price(&self.start, self.duration).budget(budget).clock(self.clock()).measure().unwrap()
    }

    /// What a wish came to, against the whole ladders.
    pub(crate) fn tried(&self, wish: f64, budget: f64, truth: &[f64], all: &Prices) -> Trial {
        let (name, mut trial) = (self.name.clone(), Trial { wish, error: f64::INFINITY, ..Trial::default() });
        match self.within(wish, budget) {
            Ok(mut planned) => {
                let spent = planned.run().unwrap();
                let met = all.rows.iter().filter(|row| row.position.is_some_and(|error| error <= wish));
                let least = met.map(|row| row.seconds).fold(f64::INFINITY, f64::min) * self.duration;
                trial.error = self.off(&planned.simulation, truth);
                trial.cost = spent.seconds / least;
                trial.forecast = spent.seconds / spent.expected;
                trial.how = planned.to_string();
            }
            Err(error) => trial.how = error.to_string(),
        }
        Trial { name, ..trial }
    }
}

/// A wish, and what it came to.
#[derive(Default)]
pub(crate) struct Trial {
    pub(crate) name: String,
    pub(crate) wish: f64,
    /// The error of the whole run, or infinite where there is none.
    pub(crate) error: f64,
    /// Evaluations of the run, over those of the cheapest row of the ladder that meets the wish.
    pub(crate) cost: f64,
    /// Evaluations of the run, over those forecast.
    pub(crate) forecast: f64,
    pub(crate) how: String,
}

impl Trial {
    /// Whether the wish is met, at little more than the least that any row of the ladder costs, as was forecast.
    pub(crate) fn holds(&self) -> bool {
        self.error <= self.wish && self.cost <= 1.2 && (self.forecast - 1.0).abs() < 0.15
    }
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, wish, error, cost, forecast, how } = self;
        write!(f, "{name:18} {wish:6.0e} {error:8.1e} {cost:6.2} {forecast:6.2}  {how}")
    }
}

pub(crate) type OnSurface = Counting<Counted<Several>, With<(), Counted<Forces>, OnEach>, One, 3>;
pub(crate) type Linked = Counting<Network<2>, With<(), Counted<PlanarGravity>, OnEach>, Many, 2>;

pub(crate) fn on(name: &str, surface: Several, forces: Forces, start: State<3>, duration: f64) -> OnSurface {
    let (surface, forces) = (Counted::new(surface), Counted::new(forces));
    let counts = vec![surface.counts(), forces.counts()];
    let scene = Scene::on(surface).with(forces);
    let start = scene.project(&start).unwrap();
    Counting { name: name.into(), scene, start, duration, counts, exact: None }
}

pub(crate) fn exactly<C, E, N, const D: usize>(
    scene: Counting<C, E, N, D>,
    exact: &[f64],
) -> Counting<C, E, N, D> {
    Counting { exact: Some(exact.to_vec()), ..scene }
}

pub(crate) fn row(name: &str, having: &[(&str, &str)]) -> Row {
    table(name).into_iter().find(|row| having.iter().all(|(column, text)| row.text(column) == *text)).unwrap()
}

pub(crate) fn lemniscate() -> OnSurface {
    let (surface, forces) = (Several { lemniscate: 1.0, ..NONE }, Forces { g: 1.0, ..FREE });
    let exact = row("lemniscate_gravity", &[("theta_deg", "45"), ("ic", "f64"), ("t", "5.0")]);
    exactly(on("lemniscate", surface, forces, billiard_45(), 5.0), &exact.numbers(["x", "y", "z"]))
}

pub(crate) fn sphere() -> OnSurface {
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let (sin, cos) = (2.5_f64.sin(), 2.5_f64.cos());
    exactly(
        on("sphere", Several { sphere: 1.0, ..NONE }, FREE, start, 5.0),
        &[2.0 * cos, 1.2 * sin, 1.6 * sin],
    )
}

pub(crate) fn torus() -> OnSurface {
    let angle = std::f64::consts::FRAC_PI_6;
    let start = State::at([1.3, 0.0, 0.0]).moving([0.0, angle.cos(), angle.sin()]);
    let exact = row("torus_geodesic", &[("case", "30deg"), ("t", "5")]).numbers(["x", "y", "z"]);
    exactly(on("torus", Several { torus: 1.0, ..NONE }, FREE, start, 5.0), &exact)
}

/// Rods in a row from a pin at the origin, or among the bodies.
pub(crate) fn chain(name: &str, lengths: &[f64], start: &[[f64; 2]], g: f64, duration: f64) -> Linked {
    let weight = Counted::new(PlanarGravity { g });
    let rods: Vec<_> = lengths.iter().map(|&length| Counted::new(Rod { length })).collect();
    let counts = rods.iter().map(Counted::counts).chain([weight.counts()]).collect();
    let links = rods.into_iter().enumerate().map(|(i, rod)| (rod, [i, i + 1]));
    let scene = Scene::points(start.len()).link_each(links).pin(0, start[0]).with(weight);
    let start = scene.project(&State::of(start.iter().copied())).unwrap();
    Counting { name: name.into(), scene, start, duration, counts, exact: None }
}

pub(crate) fn pendulum() -> Linked {
    let exact = row("planar_pendulum", &[("theta0", "pi/2"), ("t", "5")]).numbers(["x", "y"]);
    exactly(chain("pendulum", &[1.0], &[[0.0, 0.0], [1.0, 0.0]], 1.0, 5.0), &exact)
}

pub(crate) fn double_pendulum(duration: f64) -> Linked {
    chain("double pendulum", &[1.0, 1.0], &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 1.0, duration)
}

/// A body of three different moments of inertia, free or with its weight off the centre.
pub(crate) fn rigid(name: &str, weight: f64) -> Counting<Rigid, With<(), Counted<Top>, OnEach>, One, 9> {
    let weight = Counted::new(Top { weight });
    let counts = vec![weight.counts()];
    let start = Rigid::start(&Matrix3::identity(), &[1.8, 0.4, -0.9].into());
    let scene = Scene::rigid(Rigid::new([0.6, 0.8, 1.0])).with(weight);
    Counting { name: name.into(), scene, start, duration: 1.0, counts, exact: None }
}

/// Numbers of a seed, from 0 to 1.
pub(crate) fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut random = SmallRng::seed_from_u64(seed);
    move || random.random()
}

/// An ellipsoid with waves on it, under weight, a spring and a wave of forces.
pub(crate) fn generated(seed: u64) -> OnSurface {
    let mut next = numbers(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * next();
    let [a, b, c] = [between(0.3, 1.5), between(0.3, 1.5), between(0.3, 1.5)];
    let surface = Several { quadric: 1.0, a, b, c, wave: between(0.0, 0.15), k: between(1.0, 2.5), ..NONE };
    let forces =
        Forces { g: between(-1.0, 1.0), spring: between(0.0, 1.0), wave: between(-0.4, 0.4), kink: 0.0 };
    let place = [between(-0.5, 0.5), between(-0.5, 0.5), 1.0 / c.sqrt()];
    let start = State::at(place).moving([between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0)]);
    on(&format!("quadric {seed}"), surface, forces, start, 4.0)
}

/// Two to six rods of random lengths in random directions.
pub(crate) fn generated_chain(seed: u64) -> Linked {
    let mut next = numbers(seed);
    let rods = 2 + (5.0 * next()) as usize;
    let lengths: Vec<f64> = (0..rods).map(|_| 0.5 + next()).collect();
    let mut places = vec![[0.0, 0.0]];
    for (i, length) in lengths.iter().enumerate() {
        let (sin, cos) = (0.2 + 1.2 * next()).sin_cos();
        places.push([places[i][0] + length * sin, places[i][1] - length * cos]);
    }
    chain(&format!("chain of {rods}, {seed}"), &lengths, &places, 1.0, 3.0)
}

/// A slider and its crank, which turns.
pub(crate) fn crank() -> Linked {
    let weight = Counted::new(PlanarGravity { g: 1.0 });
    let rods = [1.0, 2.0].map(|length| Counted::new(Rod { length }));
    let guide = Counted::new(Slider { point: [0.0; 2], direction: [1.0, 0.0] });
    let counts = vec![rods[0].counts(), rods[1].counts(), guide.counts(), weight.counts()];
    let links = rods.into_iter().enumerate().map(|(i, rod)| (rod, [i, i + 1]));
    let scene = Scene::points(3).link_each(links).link(guide, [[2]]).pin(0, [0.0; 2]).with(weight);
    let start =
        State::of([[0.0, 0.0], [0.6, 0.8], [2.43, 0.0]]).with_momenta([[0.0, 0.0], [0.8, -0.6], [0.0, 0.0]]);
    let start = scene.project(&start).unwrap();
    Counting { name: "slider-crank".into(), scene, start, duration: 5.0, counts, exact: None }
}

/// A chain of length 1 of this many rods that falls from the horizontal.
pub(crate) fn hanging(name: &str, rods: usize) -> Linked {
    let length = 1.0 / rods as f64;
    let places: Vec<_> = (0..=rods).map(|i| [length * i as f64, 0.0]).collect();
    chain(name, &vec![length; rods], &places, 1.0, if rods > 10 { 0.2 } else { 1.0 })
}

/// A free body, whose attitude is known.
pub(crate) fn free_body() -> Counting<Rigid, With<(), Counted<Top>, OnEach>, One, 9> {
    let free = row("rigid_body", &[("case", "free"), ("t", "1.0")]);
    let places = std::array::from_fn::<_, 9, _>(|i| free.number(&format!("Q{}{}", i / 3 + 1, i % 3 + 1)));
    exactly(rigid("free body", 0.0), &places)
}
