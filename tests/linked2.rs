use rattle::prelude::*;
constraint! {
    struct Rod { length }
    |a: [f64; 2], b: [f64; 2]| sum(i in 0..2, (a[i] - b[i])^2) - length^2
}
potential! {
    struct Weight { g }
    |x, y| g * y
}
#[test]
fn chain() {
    for n in [100usize, 1000, 10_000, 100_000] {
        let l = 1.0 / n as f64;
        let scene = Scene::points(n + 1)
            .link(Rod { length: l }, (0..n).map(|i| [i, i + 1]))
            .pin(0, [0.0, 0.0])
            .with(Weight { g: l });
        let scene = scene.mass(l);
        let start = State::of((0..=n).map(|i| [i as f64 * l, 0.0]));
        let c = std::time::Instant::now();
        let start = scene.project(&start).unwrap();
        let mut s = scene.simulate(start, Rattle::new(2e-4)).unwrap();
        println!("setup {:?}", c.elapsed());
        let c = std::time::Instant::now();
        let steps = (10_000_000 / n as u64).min(5000).min(10000000 / n as u64);
        let r = s.run(steps);
        println!(
            "{n} {:?} per step {:?} counts {:?} energy {:e} res {:e} {:?}",
            r,
            c.elapsed() / steps as u32,
            s.counts(),
            s.energy_error(),
            s.constraint_residual() / (2.0 * l),
            s.system().components().next().unwrap().to_string()
        );
    }
}
