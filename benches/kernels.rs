//! What one of each costs: a function of a constraint or a potential, an elementary function, a step.
//!
//! ```text
//! cargo bench --bench kernels -- --quiet   a minute; without `--quiet` also the changes since the last run
//! cargo bench --bench kernels lemniscate   those with this in their name
//! ```
//!
//! A line is `what/function/numbers  time: [low estimate high]`: of one evaluation at one point, or of one step of one
//! trajectory, with the ends of an interval of 95 % confidence.
//! `f64` goes point by point, as a simulation does. `lanes` goes 64 side by side, as ensembles do, with the widest
//! instructions of this processor, and is the time of one of them; `lanes of f32` in single precision. Evaluations are
//! measured one after the other without waiting for results, so that a step takes longer than what it is made of.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use rattle::bodies::One;
use rattle::effect::Effects;
use rattle::ensemble::{Double, InstructionSet, Precision, Single};
use rattle::instructions::Work;
use rattle::kernel::{ConstraintKernel, PairKernel, PotentialKernel};
use rattle::lanes::{Fused, Lane};
use rattle::potentials::{Gravity, LennardJones};
use rattle::prelude::*;
use rattle::real::Real;
use rattle::scene::Hold;
use rattle::surfaces::{Clebsch, Lemniscate, Sphere, Torus};
use std::array::from_fn;
use std::hint::black_box;
use std::marker::PhantomData;
use std::time::{Duration, Instant};

constraint! {
    /// Waves, a hill and a step.
    struct Landscape { height }
    |x, y, z| z - height * exp(-x^2 - y^2) + sin(3 * x) * cos(y) / 8 + tanh(x) / 4
}

potential! {
    /// Weight, and a well.
    struct Well { g, depth }
    |x, y, z| g * z - depth * exp(-x^2 - y^2)
}

/// Trajectories of a full block of an ensemble.
const LANES: usize = 64;

/// What is asked of a kernel K at a point q with a direction v: N numbers.
trait Function<T, K, const N: usize> {
    fn of(kernel: &K, q: [T; 3], v: [T; 3]) -> [T; N];
}

macro_rules! functions {
    ($($name:ident: $law:ident<$($size:literal),*> -> $n:literal |$kernel:ident, $q:ident, $v:ident| $result:expr;)*) => {$(
        struct $name;
        impl<T: Real, K: $law<T $(, $size)*>> Function<T, K, $n> for $name {
            #[inline(always)]
            fn of($kernel: &K, $q: [T; 3], $v: [T; 3]) -> [T; $n] {
                $result
            }
        }
    )*};
}
functions! {
    Value: ConstraintKernel<3, 1> -> 1 |kernel, q, _v| kernel.value(&q);
    Gradient: ConstraintKernel<3, 1> -> 3 |kernel, q, _v| kernel.jacobian(&q)[0];
    Both: ConstraintKernel<3, 1> -> 4 |kernel, q, _v| {
        let ([g], [[x, y, z]]) = kernel.value_and_jacobian(&q);
        [g, x, y, z]
    };
    HessianVector: ConstraintKernel<3, 1> -> 3 |kernel, q, v| kernel.hessian_vector(&q, &v)[0];
    Jet: ConstraintKernel<3, 1> -> 3 |kernel, q, v| {
        let ([g], [dg], [ddg]) = kernel.jet(&q, &v);
        [g, dg, ddg]
    };
    Energy: PotentialKernel<3> -> 1 |kernel, q, _v| [kernel.value(&q)];
    Slope: PotentialKernel<3> -> 3 |kernel, q, _v| kernel.gradient(&q);
    PairEnergy: PairKernel<> -> 1 |kernel, q, _v| [kernel.value(q[2])];
    PairSlope: PairKernel<> -> 1 |kernel, q, _v| [kernel.slope(q[2])];
}

/// |x| < 3, 0 < y < 1, 1 < z < 4: where all functions are defined, of x, y or z.
fn coordinate(axis: usize, i: usize) -> f64 {
    let [low, high] = [[-3.0, 3.0], [0.05, 0.95], [1.1, 4.0]][axis];
    let part = [0.618, 0.414, 0.732][axis] * (i as f64 + 0.5);
    low + (high - low) * (part - part.floor())
}

type Columns<const N: usize> = [[Fused<f64>; LANES]; N];

/// A function at 64 points side by side, again and again.
struct Loop<'a, F, K, const N: usize> {
    kernel: &'a K,
    points: &'a Columns<3>,
    repetitions: u64,
    function: PhantomData<F>,
}

impl<F: Function<Fused<f64>, K, N>, K, const N: usize> Work for Loop<'_, F, K, N> {
    type Done = ();
    #[inline(always)]
    fn run(self) {
        let mut results = [[Fused(0.0); LANES]; N];
        for _ in 0..self.repetitions {
            side_by_side::<F, K, N>(self.kernel, black_box(self.points), &mut results);
            black_box(&results);
        }
    }
}

#[inline(always)]
fn side_by_side<F: Function<Fused<f64>, K, N>, K, const N: usize>(
    kernel: &K,
    [x, y, z]: &Columns<3>,
    results: &mut Columns<N>,
) {
    for i in 0..LANES {
        let of = F::of(kernel, [x[i], y[i], z[i]], [z[i], x[i], y[i]]);
        for n in 0..N {
            results[n][i] = of[n];
        }
    }
}

/// The time that work takes, of which each repetition does 64.
fn each(work: impl FnOnce()) -> Duration {
    let begin = Instant::now();
    work();
    begin.elapsed() / LANES as u32
}

type Group<'a> = BenchmarkGroup<'a, WallTime>;

fn measure<F, K, L, const N: usize>(group: &mut Group<'_>, name: &str, (scalar, lanes): (&K, &L))
where
    F: Function<f64, K, N> + Function<Fused<f64>, L, N>,
{
    group.bench_function(format!("{name}/f64"), |bencher| {
        let points: [[f64; 3]; LANES] = from_fn(|i| from_fn(|axis| coordinate(axis, i)));
        let all = || {
            for &[x, y, z] in black_box(&points) {
                black_box(<F as Function<f64, K, N>>::of(scalar, [x, y, z], [z, x, y]));
            }
        };
        bencher.iter_custom(|repetitions| each(|| (0..repetitions).for_each(|_| all())));
    });
    group.bench_function(format!("{name}/lanes"), |bencher| {
        let points: Columns<3> = from_fn(|axis| from_fn(|i| Fused(coordinate(axis, i))));
        bencher.iter_custom(|repetitions| {
            let (kernel, points, function) = (lanes, &points, PhantomData::<F>);
            let work = Loop::<'_, F, L, N> { kernel, points, repetitions, function };
            each(|| <Fused<f64> as Lane>::run(InstructionSet::widest(), work))
        });
    });
}

fn constraints(criterion: &mut Criterion) {
    constraint(criterion, "sphere", &Sphere { r: 1.0 });
    constraint(criterion, "torus", &Torus { major: 1.0, minor: 0.3 });
    constraint(criterion, "lemniscate", &Lemniscate { a: 1.0, r: 1.0 / 6.0 });
    constraint(criterion, "landscape", &Landscape { height: 0.5 });
    constraint(criterion, "clebsch", &Clebsch {});
}

fn constraint<C: Constraint<3, 1>>(criterion: &mut Criterion, name: &str, surface: &C) {
    let group = &mut criterion.benchmark_group(name);
    let kernels = (&surface.kernel::<f64>(), &surface.kernel::<Fused<f64>>());
    measure::<Value, _, _, 1>(group, "value", kernels);
    measure::<Gradient, _, _, 3>(group, "gradient", kernels);
    measure::<Both, _, _, 4>(group, "value_and_jacobian", kernels);
    measure::<HessianVector, _, _, 3>(group, "hessian_vector", kernels);
    measure::<Jet, _, _, 3>(group, "jet", kernels);
}

fn potentials(criterion: &mut Criterion) {
    let group = &mut criterion.benchmark_group("well");
    let well = Well { g: 1.0, depth: 0.5 };
    let kernels = (&Potential::<3>::kernel::<f64>(&well), &Potential::<3>::kernel::<Fused<f64>>(&well));
    measure::<Energy, _, _, 1>(group, "value", kernels);
    measure::<Slope, _, _, 3>(group, "gradient", kernels);
}

fn pairs(criterion: &mut Criterion) {
    let group = &mut criterion.benchmark_group("lennard_jones");
    let pair = LennardJones { epsilon: 1.0, sigma: 1.0 };
    let kernels = (&pair.kernel::<f64>(), &pair.kernel::<Fused<f64>>());
    measure::<PairEnergy, _, _, 1>(group, "value", kernels);
    measure::<PairSlope, _, _, 1>(group, "slope", kernels);
}

/// Elementary functions: `f64` has those of the system's library, `lanes` those of ensembles.
fn elementary(criterion: &mut Criterion) {
    let group = &mut criterion.benchmark_group("functions");
    macro_rules! each_of {
        ($($name:ident($($axis:literal),*))*) => {$({
            struct Elementary;
            impl<T: Real> Function<T, (), 1> for Elementary {
                #[inline(always)]
                fn of((): &(), q: [T; 3], _: [T; 3]) -> [T; 1] {
                    [Real::$name($(q[$axis]),*)]
                }
            }
            measure::<Elementary, (), (), 1>(group, stringify!($name), (&(), &()));
        })*};
    }
    each_of! {
        sqrt(2) exp(0) ln(2) log2(2) log10(2) sin(0) cos(0) tan(0) asin(1) acos(1) atan(0) atan2(0, 1) sinh(0) cosh(0) tanh(0)
        asinh(0) acosh(2) atanh(1) powf(2, 0) cbrt(0) hypot(0, 1) erf(0)
    }
}

/// Steps of a particle under gravity, on the lemniscate; RATTLE on the landscape.
fn steps(criterion: &mut Criterion) {
    let group = &mut criterion.benchmark_group("step");
    let scene = Scene::on(Lemniscate { a: 1.0, r: 1.0 / 6.0 }).with(Gravity { g: 1.0 });
    alone(group, "rattle", &scene, Rattle::new(0.01));
    side_by_side_in(Double, group, "rattle/lanes", &scene, Rattle::new(0.01));
    side_by_side_in(Single, group, "rattle/lanes of f32", &scene, Rattle::new(0.01));
    let composition = || Composition::new(SUZUKI_1990_ORDER_4, 0.02);
    alone(group, "composition", &scene, composition());
    side_by_side_in(Double, group, "composition/lanes", &scene, composition());
    alone(group, "shake", &scene, Shake::new(0.01));
    alone(group, "lobatto", &scene, Lobatto::<4>::new(0.05));
    alone(group, "taylor", &scene, Taylor::new(16, 0.01));

    let scene = Scene::on(Landscape { height: 0.5 }).with(Gravity { g: 1.0 });
    alone(group, "landscape", &scene, Rattle::new(0.01));
    side_by_side_in(Double, group, "landscape/lanes", &scene, Rattle::new(0.01));
    side_by_side_in(Single, group, "landscape/lanes of f32", &scene, Rattle::new(0.01));
}

fn start<C: Hold<3>, E: Effects<3>>(scene: &Scene<C, E, One, 3>, i: usize) -> State<3> {
    let angle = 0.1 * i as f64 + 0.7;
    let near = State::at([0.0, 0.0, 1.0 / 6.0]).moving([angle.cos(), angle.sin(), 0.0]);
    scene.project(&near).expect("a point near the surface")
}

fn alone<C: Hold<3>, E: Effects<3>, S: Method>(
    group: &mut Group<'_>,
    name: &str,
    scene: &Scene<C, E, One, 3>,
    method: S,
) {
    group.bench_function(format!("{name}/f64"), |bencher| {
        bencher.iter_custom(|steps| {
            let start = start(scene, 0);
            let mut simulation = scene.simulate(start, method.clone()).expect("a start on the surface");
            let begin = Instant::now();
            simulation.run(steps).expect("steps within reach");
            begin.elapsed()
        });
    });
}

fn side_by_side_in<P: Precision, C: Hold<3> + 'static, E: Effects<3>, S: Method>(
    precision: P,
    group: &mut Group<'_>,
    name: &str,
    scene: &Scene<C, E, One, 3>,
    method: S,
) {
    group.bench_function(name, |bencher| {
        bencher.iter_custom(|steps| {
            let starts = (0..LANES).map(|i| start(scene, i));
            let mut ensemble =
                scene.ensemble_in(precision, starts, method.clone()).expect("starts on the surface");
            let begin = Instant::now();
            ensemble.run(steps);
            let time = begin.elapsed() / LANES as u32;
            assert_eq!(ensemble.failures().count(), 0);
            time
        });
    });
}

fn short() -> Criterion {
    let (warm, long) = (Duration::from_millis(100), Duration::from_millis(300));
    Criterion::default().warm_up_time(warm).measurement_time(long).sample_size(20).nresamples(2000)
}

criterion_group! {
    name = kernels;
    config = short();
    targets = constraints, potentials, pairs, elementary, steps
}
criterion_main!(kernels);
