//! What was shown cannot be taken back: bodies are shown on their own sheets, whatever moves them side by side.

use crate::common::larger;
use rattle::potentials::Gravity;
use rattle::prelude::*;

constraint! {
    /// |q| = 1, and below a height a thousand more spheres in each unit of length.
    struct CloseBelow { k, w, height }
    |x, y, z| sin((1 + k * (1 + tanh(w * (height - z)))) * (sqrt(x^2 + y^2 + z^2) - 1))
}

constraint! {
    /// A rod, which to the right of x = 1.1 may have a thousand other lengths as well.
    struct CloseRight { k }
    |a: [f64; 2], b: [f64; 2]| sin((1 + k * (1 + tanh(5 * (b[0] - 1.1)))) * (norm(b - a) - 1))
}

/// How far off the sphere a body was shown; or how far off its length, 1, a rod of a chain.
struct Off(f64);

impl<const D: usize> Observer<D> for Off {
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        let rods = now.positions.windows(2).map(|ends| (ends[1] - ends[0]).norm());
        let sphere = (now.positions.len() == 1).then(|| now.position().norm());
        self.0 = rods.chain(sphere).fold(self.0, |most, length| larger(most, (length - 1.0).abs()));
    }
    fn join(&mut self, next: Self) {
        self.0 = larger(self.0, next.0);
    }
}

/// What was shown cannot be taken back: that bodies are on their own sheet is asked before, however many states are
/// written side by side until then. And where |∇g| changes a thousandfold within a step or two, neither what is
/// extrapolated from the steps before leads anywhere, nor is a body among the spheres unnoticed until it has left them.
#[test]
fn what_is_shown_is_on_its_own_sheet() {
    let starts = (0..100).map(|i| {
        let (sin, cos) = (f64::from(i) * 0.06).sin_cos();
        State::at([0.0, 0.0, 1.0]).moving([0.5 * cos, 0.5 * sin, 0.0])
    });
    let steps = if cfg!(long) { 300 } else { 90 };
    for (k, shown) in [(100.0, [1, steps]), (500.0, [3, steps])] {
        let scene = Scene::on(CloseBelow { k, w: 20.0, height: -0.5 }).with(Gravity { g: 1.0 });
        for every in shown {
            let mut ensemble = scene.ensemble(starts.clone(), Rattle::new(0.1)).unwrap();
            let off = ensemble.observe(steps, every, || Off(0.0));
            assert!(off.0 < 1e-12, "{:e} off, k = {k}, shown each {every}", off.0);
            assert_eq!(ensemble.failures().count(), 0);
        }
    }
}

/// So it is where momenta are drawn anew, and where each step is looked at by itself as far as it leads astray: among
/// sheets that come near later they would be shown up to 0.3, 0.004 and 0.02 off.
#[test]
fn what_is_shown_is_on_its_own_sheet_whatever_is_looked_at() {
    fn spheres(k: f64, w: f64, height: f64, g: f64, method: impl Method) -> f64 {
        let starts = (0..16).map(|i| {
            let (sin, cos) = (f64::from(i) * 0.375).sin_cos();
            let speed = 0.5 + 0.5 * f64::from(i % 7) / 7.0;
            State::at([0.0, 0.0, 1.0]).moving([speed * cos, speed * sin, 0.0])
        });
        let scene = Scene::on(CloseBelow { k, w, height }).with(Gravity { g });
        scene.ensemble(starts, method).unwrap().observe(60, 1, || Off(0.0)).0
    }
    let drawn = spheres(100.0, 20.0, -0.5, 1.0, Brownian::new(1.0, 0.3, 3, 0.1));
    let collocated = spheres(1000.0, 5.5, -0.38, 1.8, Lobatto::<3>::new(0.3));

    let scene = Scene::points(3)
        .link(CloseRight { k: 3000.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(rattle::potentials::planar::weights(1.0, [1.0; 3]));
    let starts = (0..100).map(|i| {
        let rate = 0.2 + 0.028 * f64::from(i);
        let momenta = [0.0, rate, 2.0 * rate].map(|speed| [speed, 0.0]);
        State::of([[0.0, 0.0], [0.0, -1.0], [0.0, -2.0]]).with_momenta(momenta)
    });
    let linked = scene.ensemble(starts, Taylor::new(8, 0.2)).unwrap().observe(90, 1, || Off(0.0)).0;
    let found = [drawn, collocated, linked];
    assert!(found.iter().all(|&off| 0.0 < off && off < 1e-12), "{found:?}");
}
