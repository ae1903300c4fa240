//! Bodies of many links: the motion is that of an orthonormal basis, and costs are linear in the links.

use crate::common::linked::{apart, coordinates, random};
use crate::common::*;
use nalgebra::Matrix3;
use rand::{SeedableRng, rngs::StdRng};
use rattle::Error;
use rattle::error::{NetworkMistake, StartFailure};
use rattle::links::Rod;
use rattle::network::LinearAlgebra::{Automatic, Elimination, Orthogonal};
use rattle::network::{LinearAlgebra, Mass};
use rattle::prelude::*;

/// Links between bodies at random places, some of them pinned.
struct Scenery {
    name: &'static str,
    links: Vec<[usize; 2]>,
    places: Vec<[f64; 3]>,
    masses: Vec<Mass<3>>,
    pins: Vec<usize>,
}

impl Scenery {
    fn new(name: &'static str, links: Vec<[usize; 2]>) -> Self {
        let bodies = links.iter().flatten().max().unwrap() + 1;
        let mut rng = StdRng::seed_from_u64(7);
        let places = (0..bodies).map(|_| random(&mut rng)).collect();
        Self { name, links, places, masses: vec![Mass::Unit; bodies], pins: Vec::new() }
    }

    fn run<S: Method>(&self, by: LinearAlgebra, method: S, steps: u64) -> (Vec<f64>, u64) {
        let length = |&[a, b]: &[usize; 2]| {
            let square = (0..3).map(|d| (self.places[a][d] - self.places[b][d]).powi(2));
            square.sum::<f64>().sqrt()
        };
        let rods = self.links.iter().map(|link| (Rod { length: length(link) }, *link));
        let mut scene = Scene::points::<3>(self.places.len())
            .link_each(rods)
            .masses(self.masses.iter().copied())
            .linear_algebra(by);
        for &pin in &self.pins {
            scene = scene.pin(pin, self.places[pin]);
        }
        let scene = scene.with(Gravity { g: 1.0 });
        let mut rng = StdRng::seed_from_u64(8);
        let momenta = self.places.iter().map(|_| random::<3>(&mut rng)).collect::<Vec<_>>();
        let start = scene.project(&State::of(self.places.iter().copied()).with_momenta(momenta)).unwrap();
        let mut simulation = scene.simulate(start, method).unwrap();
        simulation.run(steps).unwrap();
        assert!(simulation.constraint_residual() <= 1e-14, "{}", simulation.constraint_residual());
        assert!(simulation.cotangent_residual() <= 1e-13, "{}", simulation.cotangent_residual());
        if by == Automatic {
            let report = simulation.system().components().next().unwrap();
            assert_eq!(report.by, Elimination, "{}: {report}", self.name);
            assert!(report.fill <= report.equations, "{}: {report}", self.name);
        }
        (coordinates(&simulation.state()), simulation.counts().corrections)
    }
}

fn star(leaves: usize) -> Vec<[usize; 2]> {
    (1..=leaves).map(|leaf| [0, leaf]).collect()
}

/// Hubs in a row, with leaves each.
fn caterpillar(hubs: usize, leaves: usize) -> Vec<[usize; 2]> {
    let spine = (1..hubs).map(|i| [i - 1, i]);
    let leaf = |hub, leaf| hubs + hub * leaves + leaf;
    spine.chain((0..hubs).flat_map(|hub| (0..leaves).map(move |i| [hub, leaf(hub, i)]))).collect()
}

fn sceneries() -> Vec<Scenery> {
    let wheel = star(40).into_iter().chain((1..40).step_by(2).map(|i| [i, i + 1])).collect();
    let heavy = Scenery { masses: vec![Mass::from(1e6); 41], ..Scenery::new("heavy leaves", star(40)) };
    let heavy = Scenery { masses: [vec![Mass::Unit], heavy.masses[1..].to_vec()].concat(), ..heavy };
    let matrix = Matrix3::new(2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 3.0);
    let coupled = Scenery { masses: vec![Mass::from(matrix); 41], ..Scenery::new("mass matrices", star(40)) };
    let hung = Scenery { pins: vec![41], ..Scenery::new("hung on a pin", star(41)) };
    // From the hub by way of body 1 to a pin in the same line, and the same by way of body 2.
    let mut straight = Scenery::new("straight to pins", [star(40), vec![[1, 41], [2, 42]]].concat());
    straight.pins = vec![41, 42];
    for leaf in [1, 2] {
        straight.places[40 + leaf] =
            std::array::from_fn(|d| 2.0 * straight.places[leaf][d] - straight.places[0][d]);
    }
    // Two such lines from each of six hubs: twelve equations without a pivot.
    let (hubs, leaves) = (6, 30);
    let mut lines = Scenery::new("many lines to pins", {
        let ends = (0..2 * hubs).map(|i| [hubs + i / 2 * leaves + i % 2, hubs + hubs * leaves + i]);
        caterpillar(hubs, leaves).into_iter().chain(ends).collect()
    });
    for i in 0..2 * hubs {
        let (hub, leaf, pin) = (i / 2, hubs + i / 2 * leaves + i % 2, hubs + hubs * leaves + i);
        lines.places[pin] = std::array::from_fn(|d| 2.0 * lines.places[leaf][d] - lines.places[hub][d]);
        lines.pins.push(pin);
    }
    vec![
        lines,
        Scenery::new("star", star(40)),
        Scenery::new("wheel", wheel),
        Scenery::new("caterpillar", caterpillar(4, 30)),
        heavy,
        coupled,
        hung,
        straight,
    ]
}

#[test]
#[cfg(long)]
fn hubs_move_as_by_a_basis() {
    for scenery in sceneries() {
        let check = |what: &str, hubs: (Vec<f64>, u64), basis: (Vec<f64>, u64)| {
            let off = apart(&hubs.0, &basis.0);
            println!("{}, {what}: {off:.1e}, corrections {} and {}", scenery.name, hubs.1, basis.1);
            assert!(off <= 2e-12, "{}, {what}: {off:e}", scenery.name);
            let more = hubs.1 as f64 / (basis.1 as f64).max(1.0);
            // Multipliers of heavy leaves lose as many digits as these are heavier than the hub, and so does a guess.
            let most = if scenery.name == "heavy leaves" { 2.0 } else { 1.1 };
            assert!(more <= most, "{}, {what}: {} corrections, {}", scenery.name, hubs.1, basis.1);
        };
        let by = |by| scenery.run(by, Rattle::new(0.01), 16);
        check("Newton", by(Automatic), by(Orthogonal));
        let by = |by| scenery.run(by, Rattle::new(0.01).solved_by(Symmetric), 16);
        check("symmetric", by(Automatic), by(Orthogonal));
        let by = |by| scenery.run(by, Rattle::new(0.01).solved_by(Broyden), 16);
        check("Broyden", by(Automatic), by(Orthogonal));
        let by = |by| scenery.run(by, Lobatto::<3>::new(0.01), 4);
        check("Lobatto", by(Automatic), by(Orthogonal));
    }
}

/// What a basis is for: the same link twice, of few links and of many.
#[test]
fn dependent_equations_at_a_hub_are_found() {
    let mut twice = Scenery::new("twice", [star(40), vec![[0, 40]]].concat());
    twice.places[40] = [0.5, 0.0, 0.0];
    let scene = |links: &[[usize; 2]], by| {
        let points = links.iter().flatten().max().unwrap() + 1;
        Scene::points::<3>(points).link(Rod { length: 1.0 }, links.iter().copied()).linear_algebra(by)
    };
    let place = |i: usize| {
        let (a, b) = (i as f64, 0.3 * i as f64);
        if i == 0 { [0.0; 3] } else { [a.cos() * b.cos(), a.sin() * b.cos(), b.sin()] }
    };
    for (leaves, by) in [(40, Elimination), (3000, Automatic)] {
        let links = [star(leaves), vec![[0, leaves / 2]]].concat();
        let state = State::of((0..=leaves).map(place));
        let error = scene(&links, by).simulate(state, Rattle::new(0.01)).map(drop).unwrap_err();
        let text = error.to_string();
        let Error::Start { cause: StartFailure::Dependent { sine, equation, equations, most }, .. } = error
        else {
            panic!("{error}")
        };
        assert_eq!((equations, most), (leaves + 1, 1000));
        assert!(text.contains(if leaves < 1000 { "ask for" } else { "up to 1000" }), "{text}");
        assert!(sine <= 1e-7 && equation.bodies == [0, leaves / 2], "{sine:e}, {equation}");
    }
    // What is asked for beyond what it serves is refused at once.
    let state = State::of((0..=1001).map(place));
    let error = scene(&star(1001), Orthogonal).simulate(state, Rattle::new(0.01)).map(drop).unwrap_err();
    let refused = NetworkMistake::TooManyForBasis { equations: 1001, most: 1000 };
    assert_eq!(error, Error::Network(refused));
    let links = [star(40), vec![[0, 20]]].concat();
    let simulation =
        scene(&links, Automatic).simulate(State::of((0..=40).map(place)), Rattle::new(0.01)).unwrap();
    let report = simulation.system().components().next().unwrap();
    assert_eq!((report.equations, report.rank, report.by), (41, 40, Orthogonal));
}

/// Bytes asked for by setting up and projecting, for each link, do not grow with their number; nor does a step ask for
/// any.
#[test]
#[cfg(long)]
fn setting_up_is_linear_in_the_links() {
    type Family = (&'static str, fn(usize) -> Vec<[usize; 2]>, Vec<usize>);
    let families: [Family; 6] = [
        ("star", star, vec![]),
        ("star on a pinned hub", star, vec![0]),
        ("path", |n| (0..n).map(|i| [i, i + 1]).collect(), vec![]),
        ("binary tree", |n| (0..n).map(|i| [i / 2, i + 1]).collect(), vec![]),
        ("binary tree on a pinned root", |n| (0..n).map(|i| [i / 2, i + 1]).collect(), vec![0]),
        ("trees of hubs", |n| (0..n).map(|i| [i / 50, i + 1]).collect(), vec![]),
    ];
    for (name, links, pins) in families {
        let bytes = [1000, 30_000].map(|n| {
            let place = |i: usize| {
                let i = i as f64;
                [(1.3 * i).cos(), (2.1 * i).sin(), (0.7 * i).cos()]
            };
            let length = |&[a, b]: &[usize; 2]| {
                let (a, b) = (place(a), place(b));
                (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
            };
            let links = links(n);
            let rods = links.iter().map(|link| (Rod { length: length(link) }, *link));
            let scene = Scene::points::<3>(n + 1).link_each(rods);
            let scene = pins.iter().fold(scene, |scene, &pin| scene.pin(pin, place(pin)));
            let start = State::of((0..=n).map(place));
            let mut simulation = None;
            let setup = allocation_counter::measure(|| {
                let start = scene.project(&start).unwrap();
                simulation = Some(scene.simulate(start, Rattle::new(1e-3)).unwrap());
            });
            let step = allocation_counter::measure(|| simulation.as_mut().unwrap().run(2).unwrap());
            assert_eq!(step.count_total, 0, "{name}");
            setup.bytes_total as f64 / n as f64
        });
        println!("{name}: {:.0} and {:.0} bytes a link", bytes[0], bytes[1]);
        assert!(bytes[1] <= 1.4 * bytes[0], "{name}: {bytes:?}");
    }
}
