//! DOP853 and Taylor's method in lanes: as each trajectory alone but for rounding, with fixed steps and with a
//! tolerance; never silently on another sheet.

use crate::common::{bits, larger};
use rattle::ensemble::InstructionSet;
use rattle::nalgebra::Vector3;
use rattle::prelude::*;
use rattle::surfaces::{Lemniscate, Sphere};

potential! {
    struct Weight { g }
    |_x, y, z| g * z + y^2 / 4
}

const R: f64 = 1.0 / 6.0;

fn scene() -> Scene<Lemniscate, impl rattle::effect::list::Effects<3>, rattle::bodies::One, 3> {
    Scene::on(Lemniscate { a: 1.0, r: R }).with(Weight { g: 1.0 })
}

fn start(speed: f64, i: u32) -> State<3> {
    let angle = 0.37 * f64::from(i);
    State::at([0.0, 0.0, R]).moving([speed * angle.cos(), speed * angle.sin(), 0.0])
}

/// The largest difference of places and momenta from simulations by themselves, after a time of a half. Neighbouring
/// trajectories have parted by less than 30 times then, and rounding takes some 1e-16 in each of up to 50 steps.
fn off<P: Precision, M: Method + Copy>(precision: P, method: M, steps: u64) -> f64 {
    let mut ensemble = scene().ensemble_in(precision, (0..20).map(|i| start(1.0, i)), method).unwrap();
    ensemble.run(steps);
    assert_eq!(ensemble.plan().in_lanes, if InstructionSet::widest().fuses() { 20 } else { 0 });
    let apart = (0..20).map(|i| {
        let mut alone = scene().simulate(start(1.0, i), method).unwrap();
        alone.run(steps).unwrap();
        let state = ensemble.state(i as usize);
        assert!(ensemble.failure(i as usize).is_none() && state.time() == alone.time());
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        (q - alone.position()).norm().max((p - alone.momentum()).norm())
    });
    apart.fold(0.0, larger)
}

#[test]
fn as_alone_but_for_rounding() {
    let found = [
        off(Double, Dop853::new(0.01), 50),
        off(Compensated, Dop853::new(0.02), 25),
        off(Double, Dop853::adaptive(0.05, 1e-12), 10),
        off(Double, Dop853::adaptive(0.25, 1e-10), 2),
        off(Double, Dop853::adaptive(-0.25, 1e-10), 2),
        off(Double, Taylor::new(8, 0.01), 50),
        off(Compensated, Taylor::new(15, 0.02), 25),
        off(Double, Taylor::adaptive(12, 0.05, 1e-12), 10),
        off(Double, Taylor::adaptive(20, 0.25, 1e-14), 2),
        off(Double, Taylor::adaptive(9, -0.25, 1e-10), 2),
    ];
    println!("{found:?}");
    let fused = InstructionSet::widest().fuses();
    assert!(found.iter().all(|&off| off < 2e-13 && (off > 0.0) == fused), "{found:?}");
    assert!(off(Single, Dop853::new(0.02), 25) < 1e-3);
    // In units of time in which high coefficients do not overflow.
    assert!(off(Single, Taylor::new(40, 0.02), 25) < 1e-3);
    // In as many inner steps as places have digits for: without end otherwise.
    assert!(off(Single, Dop853::adaptive(0.5, 1e-13), 1) < 1e-3);
    assert!(off(Single, Taylor::adaptive(9, 0.25, 1e-13), 2) < 1e-3);
}

potential! {
    /// Its slope jumps at y = 0.
    struct Edge {}
    |_x, y, z| z + abs(y) / 3
}

constraint! {
    /// |q| = 1, about a place far from the origin.
    struct FarRing { x0 }
    |x, y| (x - x0)^2 + y^2 - 1
}

potential! {
    /// Its slope jumps at this x.
    struct Ledge { x0, slope }
    |x, y| y + slope * abs(x - x0)
}

/// Far from the origin too, where places are rounded to 1e-10, a lane meets as small a change of branch as a simulation
/// does, near the end of a step, and takes that step by itself, with the same numbers. Passed over, it would leave
/// momenta 3e-8 to 1e-7 off.
#[test]
fn small_changes_of_branch_are_met_far_from_the_origin() {
    let x0 = 1e6;
    let scene = Scene::on(FarRing { x0 }).with(Ledge { x0, slope: 1e-6 });
    let start = |i: u32| {
        let (sin, cos) = (-0.196 - 0.006 * f64::from(i)).sin_cos();
        scene.project(&State::at([x0 + sin, -cos]).moving([cos, sin])).unwrap()
    };
    let method = Taylor::adaptive(12, 0.25, 1e-9);
    let mut ensemble = scene.ensemble((0..8).map(start), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes, if InstructionSet::widest().fuses() { 8 } else { 0 });
    ensemble.run(1);
    for (i, state) in (0..).zip(ensemble.states()) {
        let mut alone = scene.simulate(start(i), method).unwrap();
        alone.run(1).unwrap();
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        let off = (q - alone.position()).norm().max((p - alone.momentum()).norm());
        // A rounding of places, which a lane hands over as they are.
        assert!(off < 2e-10, "{i}: {off:e}");
    }
}

/// A lane that meets another branch of a potential takes the step by itself, and ends behind it.
#[test]
fn branches_of_potentials_are_not_passed_over() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Edge {});
    let starts: Vec<_> = (0..20)
        .map(|i| {
            let angle = 0.1 + 0.3 * f64::from(i);
            State::at([angle.cos(), angle.sin(), 0.0]).moving([0.4 * angle.sin(), -0.4 * angle.cos(), 0.3])
        })
        .collect();
    let method = Taylor::adaptive(12, 0.25, 1e-10);
    let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
    assert_eq!(ensemble.plan().in_lanes == 20, InstructionSet::widest().fuses());
    ensemble.run(40);
    let mut met = 0;
    for (i, start) in starts.into_iter().enumerate() {
        let side = start.positions().next().unwrap().y;
        let mut alone = scene.simulate(start, method).unwrap();
        alone.run(40).unwrap();
        let off = (ensemble.state(i).positions().next().unwrap() - alone.position()).norm();
        let lost = alone.energy_error().abs();
        met += usize::from(side * alone.position().y < 0.0);
        assert!(lost < 2e-8 && off < 2e-7, "{i}: {lost:e} {off:e}");
    }
    assert!(met > 3, "{met}");
}

/// Halved steps leave 2⁻ⁿ of the error of a method of order n; the reference is a simulation with a tolerance, by the
/// other method.
#[test]
fn of_their_orders() {
    fn order<M: Method>(method: impl Fn(f64) -> M, exact: impl Method) -> f64 {
        let mut exact = scene().simulate(start(1.0, 2), exact).unwrap();
        exact.run(5).unwrap();
        let [one, two] = [10_u32, 20].map(|steps| {
            let mut ensemble = scene().ensemble([start(1.0, 2)], method(0.5 / f64::from(steps))).unwrap();
            ensemble.run(steps.into());
            (ensemble.state(0).positions().next().unwrap() - exact.position()).norm()
        });
        println!("{one:e} {two:e}");
        (one / two).log2()
    }
    let (dop853, taylor) = (Dop853::adaptive(0.1, 1e-15), Taylor::adaptive(18, 0.1, 1e-15));
    let orders = [
        (8.0, order(Dop853::new, taylor)),
        (4.0, order(|h| Taylor::new(4, h), dop853)),
        (7.0, order(|h| Taylor::new(7, h), dop853)),
    ];
    assert!(orders.iter().all(|(expected, order)| (order - expected).abs() < 1.0), "{orders:?}");
}

/// Round a great circle three times, in steps so short that their own error is 1e-20: what is off is rounding.
#[test]
fn compensated_sums() {
    fn off<P: Precision>(precision: P, method: impl Method) -> f64 {
        let scene = Scene::on(Sphere { r: 1.0 });
        let starts = (0..16).map(|i| {
            let (sin, cos) = f64::from(i).sin_cos();
            State::at([1.0, 0.0, 0.0]).moving([0.0, cos, sin])
        });
        let mut ensemble = scene.ensemble_in(precision, starts, method).unwrap();
        ensemble.run(900);
        let off = |state: State<3>| (state.positions().next().unwrap() - Vector3::x()).norm();
        ensemble.states().map(off).fold(0.0, larger)
    }
    let h = std::f64::consts::TAU / 300.0;
    let dop853 = [off(Compensated, Dop853::new(h)), off(Double, Dop853::new(h))];
    let taylor = [off(Compensated, Taylor::new(12, h)), off(Double, Taylor::new(12, h))];
    println!("{dop853:?} {taylor:?}");
    assert!([dop853, taylor].iter().all(|[less, more]| *less < 0.5 * more), "{dop853:?} {taylor:?}");
}

/// Which of so many trajectories end, each third of which is fast: none but those. The others have the bits that they
/// have without them, in other divisions of the run, by other instructions, and where a checkpoint is gone on from.
/// Asked for the ensemble of trajectories of these numbers, by an instruction set.
pub(crate) fn who_end<const D: usize>(
    number: u32,
    of: impl Fn(&[u32], InstructionSet) -> Ensemble<D>,
) -> Vec<(usize, rattle::Error)> {
    let (numbers, calm): (Vec<u32>, Vec<u32>) =
        ((0..number).collect(), (0..number).filter(|i| !fast(*i)).collect());
    let widest = InstructionSet::widest();
    let mut all = of(&numbers, widest);
    all.run(40);
    let record = all.checkpoint();
    all.run(20);
    let mut resumed = of(&numbers, widest);
    resumed.resume(&record).unwrap();
    resumed.run(20);
    let mut narrow = of(&calm, InstructionSet::Avx2);
    let mut calm_ones = of(&calm, widest);
    calm_ones.run(60);
    narrow.run(60);
    for (n, &i) in calm.iter().enumerate() {
        let expected = bits(&calm_ones.state(n));
        assert_eq!(bits(&all.state(i as usize)), expected, "trajectory {i}");
        assert_eq!(bits(&resumed.state(i as usize)), expected, "trajectory {i} resumed");
        if narrow.instruction_set().fuses() {
            assert_eq!(bits(&narrow.state(n)), expected, "trajectory {i} by narrow registers");
        }
    }
    let ended: Vec<_> = all.failures().map(|(i, error)| (i, error.clone())).collect();
    println!("{:?}", ended.iter().map(|(i, _)| i).collect::<Vec<_>>());
    assert!(ended.iter().all(|&(i, _)| fast(i as u32)), "{ended:?}");
    ended
}

/// Whether [those that end](who_end), and some if so is asked, end by the error that they end by alone.
pub(crate) fn end_as_alone<const D: usize>(
    number: u32,
    some_end: bool,
    of: impl Fn(&[u32], InstructionSet) -> Ensemble<D>,
    alone: impl Fn(u32) -> rattle::Error,
) {
    let ended = who_end(number, of);
    assert!(!some_end || !ended.is_empty());
    for (i, found) in ended {
        assert_eq!(found.to_string(), alone(i as u32).to_string(), "trajectory {i}");
    }
}

/// Whether the trajectory of this number is too fast for its steps.
pub(crate) fn fast(i: u32) -> bool {
    i.is_multiple_of(3)
}

/// Trajectories too fast for their steps end, as they do alone, and [the others](who_end) go on.
#[test]
fn who_fails_touches_no_one_else() {
    fn check<M: Method + Copy>(method: M, some_end: bool) {
        let start = |i: u32| start(if fast(i) { 30.0 } else { 1.0 }, i);
        let ended = who_end(22, |numbers, set| {
            Ensemble::of(Double, &scene(), numbers.iter().map(|&i| start(i)), method, set).unwrap()
        });
        assert!(!some_end || !ended.is_empty());
        for (i, found) in ended {
            let mut alone = scene().simulate(start(i as u32), method).unwrap();
            let error = alone.run(60).unwrap_err();
            let kind = std::mem::discriminant(&error);
            assert_eq!(std::mem::discriminant(&found), kind, "trajectory {i}: {error}");
        }
    }
    check(Dop853::new(0.02), true);
    check(Dop853::adaptive(0.02, 1e-9), false);
    check(Taylor::new(8, 0.02), true);
    check(Taylor::adaptive(10, 0.02, 1e-9), false);
}

/// On shells as close as a step leads astray each motion stays on its own, or ends. Without being looked at, nine of
/// the last twenty would go on from another one.
#[test]
fn shells_are_not_changed_in_silence() {
    constraint! {
        struct Shells { k }
        |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
    }
    let (mut right, mut refused) = (0, 0);
    for (k, h) in [(30.0, 0.3), (300.0, 0.5), (1e7, 1.0), (1e8, 0.8)] {
        let start = |i: u32| {
            let angle = 0.2 * f64::from(i);
            State::at([1.0, 0.0, 0.0]).moving([0.0, angle.cos(), angle.sin()])
        };
        let scene = Scene::on(Shells { k }).with(Weight { g: 1.0 });
        let mut check = |mut ensemble: Ensemble<3>| {
            ensemble.run(4);
            for (i, state) in ensemble.states().enumerate() {
                let off = (state.positions().next().unwrap().norm() - 1.0).abs();
                assert!(off < 0.1 / k, "k = {k}, h = {h}, trajectory {i}: {off:e} off");
                *if ensemble.failure(i).is_some() { &mut refused } else { &mut right } += 1;
            }
        };
        let starts = || (0..20).map(start);
        check(scene.ensemble(starts(), Dop853::new(h)).unwrap());
        check(scene.ensemble(starts(), Dop853::adaptive(h, 1e-6)).unwrap());
        check(scene.ensemble(starts(), Taylor::new(8, h)).unwrap());
        check(scene.ensemble(starts(), Taylor::adaptive(8, h, 1e-6)).unwrap());
    }
    println!("{right} right, {refused} refused");
    assert!(right > 160, "{right} right, {refused} refused");
}
