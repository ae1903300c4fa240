//! Checkpoints of other runs: what differs is told, however little it weighs beside the rest and however far from the
//! origin it is; what differs by rounding alone is taken, and so are files that were written before so much was told.

use rattle::checkpoint::{Checkpoint, Data, Record, encode};
use rattle::effect::{Langevin, LinearDrag, VelocityRescaling};
use rattle::links::planar::Rod;
use rattle::potentials::planar::{Spring, gravitation};
use rattle::prelude::*;
use rattle::surfaces::Sphere;

potential! {
    /// A dimple far from the origin.
    struct Dimple { depth, at }
    |x, y| -depth * exp(-((x - at)^2 + (y - at)^2))
}

constraint! {
    /// A small circle far from the origin.
    struct Ring { at, r }
    |x, y| (x - at)^2 + (y - at)^2 - r^2
}

/// A run of this parameter.
type Begin<'a> = &'a dyn Fn(f64) -> Box<dyn Checkpoint>;

/// A checkpoint of the first one is taken by the same, and refused by the second, which differs in this part.
fn refused(begin: Begin<'_>, [file, here]: [f64; 2], part: &str) {
    for [file, here] in [[file, here], [here, file]] {
        let mut run = begin(file);
        run.take_steps(3).unwrap();
        let record = run.checkpoint();
        begin(file).resume(&record).unwrap();
        let mut other = begin(here);
        let before = encode(&other.checkpoint());
        let told = other.resume(&record).map_err(|error| error.to_string());
        let is_told = told.as_ref().is_err_and(|told| told.contains(&format!("another run ({part}")));
        assert!(is_told, "{file:e} for {here:e}: {told:?}");
        assert!(encode(&other.checkpoint()) == before);
    }
}

/// As simulations, and in lanes.
macro_rules! refused_both_ways {
    ($scene:expr, $start:expr, $h:expr, $parameters:expr, $part:expr) => {
        refused(&|x| Box::new($scene(x).simulate($start(x), Rattle::new($h)).unwrap()), $parameters, $part);
        let lanes = |x| {
            let ensemble = $scene(x).ensemble(vec![$start(x); 3], Rattle::new($h)).unwrap();
            assert_eq!(ensemble.plan().in_lanes, 3);
            Box::new(ensemble) as Box<dyn Checkpoint>
        };
        refused(&lanes, $parameters, $part);
    };
}

/// What acts on a small place is told there, too: a thousandth of the distance from the origin is far beside it.
#[test]
fn small_things_far_from_the_origin_count() {
    for at in [0.0, 1e3, 1e5, 1e6] {
        let scene = |depth| Scene::point().with(Dimple { depth, at });
        let start = |_| State::at([at + 0.3, at]).moving([0.0, 0.1]);
        refused_both_ways!(scene, start, 0.01, [1.0, 2.0], "effect 0");
        // At rest in the middle there is no force.
        let resting = |_| State::at([at, at]);
        let part = if at < 1e4 { "effect 0" } else { "energies" };
        refused_both_ways!(scene, resting, 0.01, [1.0, 2.0], part);
        let scene = |r| Scene::on(Ring { at, r });
        let start = |r| State::at([at + r, at]).moving([0.0, 0.1]);
        refused_both_ways!(scene, start, 0.01, [1.0, 1.0 + 1e-6], "constraints");
    }
    let scene = |depth| Scene::on(Ring { at: 1e6, r: 1.0 }).with(Dimple { depth, at: 1e6 });
    let start = |_| State::at([1e6 + 1.0, 1e6]).moving([0.0, 0.1]);
    refused_both_ways!(scene, start, 0.01, [1.0, 1.0 + 1e-6], "effect 0");
}

/// Each mass, each equation and the force on each body has a size of its own.
#[test]
fn what_is_small_beside_the_rest_counts() {
    let two = || State::of([[0.0, 0.0], [1.0, 0.0]]).with_momenta([[0.1, 0.0], [0.0, 1e-12]]);
    let scene = |m| Scene::points(2).masses([m, 1e-12]);
    refused_both_ways!(scene, |_| two(), 0.01, [1.0, 1.0 + 1e-6], "masses");
    let scene = |m| Scene::points(2).masses([1.0, m]);
    refused_both_ways!(scene, |_| two(), 0.01, [1e12, 2e12], "masses");
    let scene = |m| Scene::points(3).with(gravitation(1.0, [1.0, 1e-3, m]));
    let start = |_| State::of([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]]);
    refused_both_ways!(scene, start, 0.01, [1e-14, 2e-14], "effect 0");
    let spring = |stiffness, pair| Spring { stiffness, length: 1.0 }.over([pair]);
    let scene = |k| Scene::points(4).with(spring(1e12, [0, 1])).with(spring(k, [2, 3]));
    let start = |_| State::of([[0.0, 0.0], [1.0, 0.0], [5.0, 0.0], [6.0, 0.0]]);
    refused_both_ways!(scene, start, 1e-7, [1.0, 2.0], "effect 1");
    let scene = |l| Scene::points(4).link(Rod { length: 1e6 }, [[0, 1]]).link(Rod { length: l }, [[2, 3]]);
    let start = |l| State::of([[0.0, 0.0], [1e6, 0.0], [5.0, 0.0], [5.0 + l, 0.0]]);
    refused_both_ways!(scene, start, 1e-4, [1.0, 1.01], "constraints");
}

/// What is the same but for its roundings.
mod one_way {
    use rattle::prelude::*;
    potential! { pub(super) struct Bond { k, l } |a: [f64; 2], b: [f64; 2]| k * (norm(a - b) - l)^2 / 2 }
    potential! { pub(super) struct Bowl { k, at } |x, y| k * ((x - at)^2 + (y - at)^2) / 2 }
    constraint! { pub(super) struct Ball { r } |x, y, z| x^2 + y^2 + z^2 - r^2 }
    potential! { pub(super) struct Dent { at } |x, y, _z| -exp(-((x - at)^2 + y^2)) }
}

/// And here with other ones.
mod another_way {
    use rattle::prelude::*;
    potential! {
        pub(super) struct Bond { k, l }
        |a: [f64; 2], b: [f64; 2]| k / 2 * (hypot(a[0] - b[0], b[1] - a[1]) - l / 3 - l * 2 / 3)^2
    }
    potential! {
        pub(super) struct Bowl { k, at }
        |x, y| k * ((x - at / 3 - at * 2 / 3)^2 + (at / 7 - y + at * 6 / 7)^2) / 2
    }
    constraint! { pub(super) struct Ball { r } |x, y, z| (z - r) * (z + r) + y^2 + x^2 }
    potential! { pub(super) struct Dent { at } |x, y, _z| -exp(-(x - at)^2) * exp(-y^2) }
}

/// Checkpoints of each are taken by the other. Returns how many numbers differ in them by more than 1e-9 of themselves.
fn taken(mut one: impl Checkpoint, mut another: impl Checkpoint) -> usize {
    let numbers = |record: &Record| {
        let told = record.fields().iter().filter(|field| field.name.contains("run/"));
        let numbers = told.filter_map(|field| match &field.data {
            Data::Numbers(numbers) => Some(numbers.clone()),
            _ => None,
        });
        numbers.flatten().collect::<Vec<_>>()
    };
    let mut differ = 0;
    for steps in [0, 3] {
        one.take_steps(steps).unwrap();
        another.take_steps(steps).unwrap();
        let records = [one.checkpoint(), another.checkpoint()];
        let [a, b] = records.each_ref().map(numbers);
        differ += a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 1e-9 * a.abs().max(b.abs())).count();
        another.resume(&records[0]).unwrap();
        one.resume(&records[1]).unwrap();
        another.resume(&records[1]).unwrap();
    }
    differ
}

/// Another library, compiler or processor rounds otherwise; where forces or equations cancel, nothing but roundings is
/// left of them.
#[test]
fn roundings_are_no_other_run() {
    let mut differ = 0;
    macro_rules! taken {
        ($way:ident: $scene:expr, $start:expr) => {
            let h = 0.01;
            let one = {
                use one_way as $way;
                $scene
            };
            let another = {
                use another_way as $way;
                $scene
            };
            let runs = (one.simulate($start, Rattle::new(h)), another.simulate($start, Rattle::new(h)));
            differ += taken(runs.0.unwrap(), runs.1.unwrap());
            let starts = || vec![$start; 3];
            let runs = (one.ensemble(starts(), Rattle::new(h)), another.ensemble(starts(), Rattle::new(h)));
            differ += taken(runs.0.unwrap(), runs.1.unwrap());
        };
    }
    // Bonds at their length, along a slanted line: all forces are roundings.
    let chain = |i: usize| [0.31 + 0.6 * 0.7 * i as f64, 0.8 * 0.7 * i as f64];
    let bonds = (0..4).map(|i| [i, i + 1]);
    let start = || State::of((0..5).map(chain));
    taken!(way: Scene::points(5).with(way::Bond { k: 1.0, l: 0.7 }.over(bonds.clone())), start());
    // At the bottom of a bowl, near the origin and far from it.
    for at in [0.0, 0.3, 1e6 / 3.0] {
        taken!(way: Scene::point().with(way::Bowl { k: 3.0, at }), State::at([at, at]));
        taken!(way: Scene::point().with(way::Bowl { k: 3.0, at }), State::at([at * (1.0 + 1e-15), at]));
    }
    for r in [1e-9, 1.0, 1e6 / 3.0] {
        let start = || State::at([0.6 * r, 0.0, 0.8 * r]).moving([0.0, 0.1 * r, 0.0]);
        taken!(way: Scene::on(way::Ball { r }).with(way::Dent { at: 0.6 * r }), start());
    }
    assert!(differ > 20, "only {differ} numbers were roundings");
}

/// Files of before have less in them, and are read.
#[test]
fn files_in_which_less_is_told_are_taken() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(rattle::potentials::Gravity { g: 1.0 });
    let start = || State::at([0.6, 0.8, 0.0]).moving([0.0, 0.0, 1.0]);
    let older = |record: Record| {
        let is_older = |name: &str| !name.contains("at its places") && !name.contains("precision");
        let fields =
            record.fields().iter().filter(|field| is_older(&field.name)).cloned().collect::<Vec<_>>();
        assert!(fields.len() < record.fields().len());
        Record::of(fields)
    };
    let begin = || scene.simulate(start(), Rattle::new(0.01)).unwrap();
    let mut run = begin();
    run.run(7).unwrap();
    let mut again = begin();
    again.resume(&older(run.checkpoint())).unwrap();
    assert!(encode(&again.checkpoint()) == encode(&run.checkpoint()));
    let begin = || scene.ensemble_in(Single, vec![start(); 3], Rattle::new(0.01)).unwrap();
    let mut run = begin();
    run.run(7);
    let mut again = begin();
    again.resume(&older(run.checkpoint())).unwrap();
    assert!(encode(&again.checkpoint()) == encode(&run.checkpoint()));
}

/// What was computed to sixteen digits does not go on with seven, nor the other way.
#[test]
fn precisions_are_told_apart() {
    fn check(method: &impl Method) {
        // On the plane z = 0 little differs: a checkpoint of the one was taken by the other.
        let scene = Scene::on(rattle::surfaces::Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 });
        let starts = || (0..3).map(|i| State::at([f64::from(i), 0.0, 0.0]).moving([0.3, 0.1, 0.0]));
        let double = scene.ensemble_in(Double, starts(), method.clone()).unwrap();
        let single = scene.ensemble_in(Single, starts(), method.clone()).unwrap();
        let sums = scene.ensemble_in(Compensated, starts(), method.clone()).unwrap();
        let mut all = [double, single, sums];
        for ensemble in &mut all {
            assert_eq!(ensemble.plan().in_lanes, 3, "{}", method.name());
            ensemble.run(5);
        }
        for (file, here) in [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)] {
            let record = all[file].checkpoint();
            let told = all[here].resume(&record).map_err(|error| error.to_string());
            // Where sums are compensated there are more fields, of which the first is told.
            let words = ["another run (precision): it was written by", "the checkpoint does not fit"];
            let found = words.iter().position(|words| told.as_ref().is_err_and(|told| told.contains(words)));
            let may_be_fields = [file, here].contains(&2);
            assert!(
                found == Some(0) || found == Some(1) && may_be_fields,
                "{}: {file} for {here}: {told:?}",
                method.name()
            );
        }
    }
    check(&Rattle::new(0.01));
    check(&Lobatto::<3>::new(0.01));
    check(&Dop853::new(0.01));
    check(&Taylor::new(8, 0.01));
    check(&Brownian::new(1.0, 0.5, 7, 0.01));
}

/// In lanes, too, an option that the file lacks is told, and the other way round.
#[test]
fn retry_is_told_in_lanes() {
    let scene = Scene::on(Sphere { r: 1.0 });
    let begin = |retry: f64| {
        let starts = (0..3).map(|i| State::at([1.0, 0.0, 0.0]).moving([0.0, 0.5 + f64::from(i), 0.0]));
        let ensemble = scene.ensemble(starts, Rattle::new(0.1)).unwrap();
        assert_eq!(ensemble.plan().in_lanes, 3);
        Box::new(ensemble.retry(retry as u32)) as Box<dyn Checkpoint>
    };
    refused(&begin, [0.0, 6.0], "options");
    refused(&begin, [4.0, 6.0], "options");
}

/// Splittings of the same stages, of which one has flows in the middle of its steps and one around them.
#[test]
fn when_flows_act_is_a_part_of_the_method() {
    let heat = || Langevin { friction: 0.5, temperature: 0.2, seed: 3 };
    let other = |a: &mut dyn Checkpoint, b: &mut dyn Checkpoint| {
        a.take_steps(3).unwrap();
        b.take_steps(3).unwrap();
        let told = b.resume(&a.checkpoint()).unwrap_err().to_string();
        assert!(told.contains("another run (method)"), "{told}");
        a.resume(&a.checkpoint()).unwrap();
    };
    let rods = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).with(heat());
    let line = || vec![State::of([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]); 3];
    let mut around = rods.ensemble(line(), Geodesic::new(2, 0.01)).unwrap();
    let mut middle = rods.ensemble(line(), Baoab::new(0.01)).unwrap();
    assert_eq!((around.plan().in_lanes, middle.plan().in_lanes), (3, 3));
    other(&mut around, &mut middle);
    other(&mut middle, &mut around);
    let ball = Scene::on(Sphere { r: 1.0 }).with(LinearDrag::new(0.3));
    let start = || vec![State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]); 3];
    let mut around = ball.ensemble(start(), Geodesic::new(2, 0.01)).unwrap();
    let mut middle = ball.ensemble(start(), Baoab::new(0.01)).unwrap();
    other(&mut around, &mut middle);
    other(&mut middle, &mut around);
}

phase_constraint! {
    /// The three-sphere, with positions in units of a.
    struct Hopf { a }
    |q: [f64; 2], p: [f64; 2]| dot(q, q) / a^2 + dot(p, p) - 1
}

hamiltonian! {
    struct Steep { a, b, g }
    |q: [f64; 2], p: [f64; 2]| a * (dot(p, p) / 2 + b * dot(p, p)^3) + g * q[1]
}

/// Momenta decide what is compared in phase space, in lanes as in a simulation.
#[test]
fn hamiltonians_are_told_apart_where_momenta_are() {
    for a in [1.0, 1e-10] {
        let scene = |b, g| Scene::in_phase_space(Hopf { a }, Steep { a, b, g });
        let start =
            |b, g| scene(b, g).project(&State::at([-0.55 * a, -0.83 * a]).moving([0.03, 0.02])).unwrap();
        let run = |b, g| {
            let ensemble = scene(b, g).ensemble(vec![start(b, g); 3], Rattle::new(0.01)).unwrap();
            assert_eq!(ensemble.plan().in_lanes, 3);
            Box::new(ensemble) as Box<dyn Checkpoint>
        };
        refused(&|b| run(b, 0.3), [0.1, 0.2], "");
        refused(&|g| run(0.1, g), [0.3, 0.4], "");
        let one = |b| {
            let ensemble = scene(b, 0.3).ensemble(vec![State::at([a, 0.0]); 3], Rattle::new(0.01)).unwrap();
            Box::new(ensemble) as Box<dyn Checkpoint>
        };
        refused(&one, [0.1, 0.1001], ""); // places are a power of two
    }
}

hamiltonian! {
    /// A fast body under gravity: of so much energy at rest that its weight is far below the rounding of it.
    struct Heavy { c, g }
    |x, p| sqrt(c^2 * p^2 + c^4) + g * x
}

/// What momenta change by is compared beside H, of which it may be less than a rounding.
#[test]
fn hamiltonians_are_told_apart_by_forces() {
    let scene = |g| Scene::hamiltonian(Heavy { c: 3e8, g });
    let start = |_| State::at([1.0]).moving([0.5]);
    refused_both_ways!(scene, start, 0.01, [9.81, 1.62], "rates of momenta");
}

force! {
    /// Drag by a speed, and by its square.
    struct Rubbing { a, b }
    |_q: [f64; 3], v: [f64; 3]| -(a + b * norm(v)) * v
}

potential! {
    /// A pulse.
    struct Pulse { force, tau }
    |_x, _y, z, t| force * z * exp(-(t / tau)^2)
}

/// So are pulses, and stops of any size.
#[test]
fn what_is_short_or_small_is_told_apart() {
    let start = || State::of([[0.0; 3], [4e-10, 0.0, 0.0]]).with_momenta([[1e-23, 0.0, 2e-23]; 2]);
    let pulse = |force| {
        let scene = Scene::points::<3>(2).mass(6.6e-26).with(Pulse { force, tau: 1e-13 });
        Box::new(scene.simulate(start(), Rattle::new(1e-15)).unwrap()) as Box<dyn Checkpoint>
    };
    refused(&pulse, [1e-12, 2e-12], "effect 0 after a step");
    let stopped = |r| {
        let run = Scene::points::<3>(2).mass(6.6e-26).simulate(start(), Rattle::new(1e-15)).unwrap();
        Box::new(run.collide(rattle::effect::Stop::below(Sphere { r })).unwrap()) as Box<dyn Checkpoint>
    };
    refused(&stopped, [1e-8, 1e-8 * (1.0 + 1e-6)], "options");
}

/// In seconds, where a thousandth is ages: nothing is left there of velocities, whatever the rate.
#[test]
fn fast_flows_are_told_apart_by_what_they_do_in_a_step() {
    let heat = 4e-21;
    let langevin = |friction| Langevin { friction, temperature: heat, seed: 1 };
    let rescaling = |time| VelocityRescaling { time, temperature: heat, seed: 1 };
    let drag = |rate| LinearDrag::new(6.6e-26 * rate);
    macro_rules! told {
        ($flow:expr, $parameters:expr) => {{
            let points = |x| Scene::points::<3>(2).mass(6.6e-26).with($flow(x));
            let start = || State::of([[0.0; 3], [4e-10, 0.0, 0.0]]).with_momenta([[1e-23, 0.0, 2e-23]; 2]);
            refused(
                &|x| Box::new(points(x).simulate(start(), Baoab::new(1e-15)).unwrap()),
                $parameters,
                "flow 0",
            );
            let rod = |x| points(x).link(rattle::links::Rod { length: 4e-10 }, [[0, 1]]);
            let rods = |x| {
                let ensemble = rod(x).ensemble(vec![start(); 3], Rattle::new(1e-15)).unwrap();
                assert_eq!(ensemble.plan().in_lanes, 3);
                Box::new(ensemble) as Box<dyn Checkpoint>
            };
            refused(&rods, $parameters, "flow 0");
        }};
    }
    told!(langevin, [1e12, 5e12]);
    told!(rescaling, [1e-12, 2e-12]);
    told!(drag, [1e12, 5e12]);
    let rubbed = |b| {
        let scene = Scene::on(Sphere { r: 1e-10 }).with(Rubbing { a: 1e12, b });
        let start = State::at([1e-10, 0.0, 0.0]).moving([0.0, 1e4, 0.0]);
        Box::new(scene.ensemble(vec![start; 3], Rattle::new(1e-15)).unwrap()) as Box<dyn Checkpoint>
    };
    refused(&rubbed, [1e8, 2e8], "flow 0");
    let towed = |b| {
        let scene = Scene::points(2).mass(6.6e-26).link(rattle::links::Rod { length: 4e-10 }, [[0, 1]]);
        let start = State::of([[0.0; 3], [4e-10, 0.0, 0.0]]).with_momenta([[0.0, 1e-23, 0.0]; 2]);
        let rubbed = scene.with(Rubbing { a: 0.0, b });
        Box::new(rubbed.ensemble(vec![start; 3], Rattle::new(1e-15)).unwrap()) as Box<dyn Checkpoint>
    };
    refused(&towed, [2e-15, 4e-15], "flow 0");
    let ball = |rate| {
        let scene = Scene::on(Sphere { r: 1e-10 }).mass(6.6e-26).with(drag(rate));
        let start = State::at([1e-10, 0.0, 0.0]).moving([0.0, 1e-23, 0.0]);
        Box::new(scene.ensemble(vec![start; 3], Rattle::new(1e-15)).unwrap()) as Box<dyn Checkpoint>
    };
    refused(&ball, [1e12, 5e12], "flow 0");
}

/// Records are made by hand, too: lists that are shorter or longer than their shapes are refused, one by one.
#[test]
fn lists_have_the_lengths_that_they_name() {
    let refused = |run: &mut dyn Checkpoint| {
        run.take_steps(3).unwrap();
        let (fields, before) = (run.checkpoint().fields().to_vec(), encode(&run.checkpoint()));
        for (i, longer) in (0..fields.len()).flat_map(|i| [(i, false), (i, true)]) {
            let mut fields = fields.clone();
            match &mut fields[i].data {
                Data::Numbers(list) if longer => list.push(0.0),
                Data::Numbers(list) if !list.is_empty() => drop(list.pop()),
                Data::Counts(list) if longer => list.push(0),
                Data::Counts(list) if !list.is_empty() => drop(list.pop()),
                _ => continue,
            }
            let name = fields[i].name.clone();
            assert!(run.resume(&Record::of(fields)).is_err(), "{name}, longer: {longer}");
            assert!(encode(&run.checkpoint()) == before, "{name}");
        }
    };
    let start = || State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    let ball = Scene::on(Sphere { r: 1.0 }).with(Langevin { friction: 0.5, temperature: 0.2, seed: 3 });
    refused(&mut ball.simulate(start(), Rattle::new(0.01).guess(LastMultiplier)).unwrap());
    refused(&mut ball.ensemble(vec![start(); 3], Rattle::new(0.01)).unwrap());
    let free = Scene::on(Sphere { r: 1.0 });
    refused(&mut free.ensemble(vec![start(); 3], NoseHoover::new(1.0, 0.5, 0.01)).unwrap());
    let rods = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]);
    let line = || State::of([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
    refused(&mut rods.simulate(line(), Rattle::new(0.01)).unwrap());
    refused(&mut rods.ensemble(vec![line(); 3], Rattle::new(0.01)).unwrap());
}
