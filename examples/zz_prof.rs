use rattle::potentials::LennardJones;
use rattle::prelude::*;
fn cpu() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}
fn main() {
    let n: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let side = (n as f64 / 0.8).cbrt();
    let rows = (n as f64).cbrt().ceil() as usize;
    let mut x = 0.1_f64;
    let mut rnd = || {
        x = 3.99 * x * (1.0 - x);
        x - 0.5
    };
    let start = State::of((0..n).map(|i| {
        [i % rows, i / rows % rows, i / rows / rows].map(|k| (k as f64 + 0.5) * side / rows as f64)
    }))
    .with_momenta((0..n).map(|_| [rnd() * 4.0, rnd() * 4.0, rnd() * 4.0]));
    for skin in std::env::args().skip(2) {
        let skin: f64 = skin.parse().unwrap();
        let within =
            LennardJones { epsilon: 1.0, sigma: 1.0 }.within(2.5).shifted().skin(skin).periodic([side; 3]);
        let mut s = Scene::points::<3>(n).with(within).simulate(start.clone(), Rattle::new(0.004)).unwrap();
        s.run(200).unwrap();
        let t = cpu();
        let steps = (3_000_000 / n) as u64;
        s.run(steps).unwrap();
        println!(
            "skin {skin}: {:.1} ns per body and step; T = {:.2}",
            (cpu() - t) / steps as f64 / n as f64 * 1e9,
            s.momenta().map(|p| p.norm_squared()).sum::<f64>() / 3.0 / n as f64
        );
    }
}
