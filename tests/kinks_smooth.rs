//! Where curvature jumps and the normal does not, there is no kink, however far a step goes.

use rattle::prelude::*;

constraint! {
    /// Two straight lines and two half circles.
    struct Stadium {}
    |x, y| { let d = max(abs(x) - 1, 0); d^2 + y^2 - 1 }
}

#[test]
fn jumps_of_curvature_are_no_kinks() {
    let scene = Scene::on(Stadium {});
    for (h, tolerance) in [(2.0_f64, 1e-5), (0.1, 1e-9)] {
        let mut fell = Vec::new();
        for i in 0..50 {
            let x = -0.893 + 0.0357 * f64::from(i);
            let start = State::at([x, -1.0]).moving([1.0, 0.0]);
            let mut run = scene.simulate(start, Taylor::adaptive(18, h, tolerance)).unwrap();
            if let Err(error) = run.run((20.0 / h) as u64) {
                fell.push(format!("{x}: {error}"));
            }
        }
        assert!(fell.is_empty(), "h = {h}: {} of 50\n{}", fell.len(), fell.join("\n"));
    }
}
