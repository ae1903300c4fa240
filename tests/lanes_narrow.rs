//! Links that nearly depend on each other in some lanes of a row: those go by themselves, and sights of them tell what
//! they tell of simulations.

use crate::common::PlanarGravity;
use crate::lanes_linked::Told;
use rattle::links::planar::Rod;
use rattle::method::Method;
use rattle::prelude::*;

/// A parallelogram that hangs from two pins, at this angle to the line through them, and four rods that hang from it.
fn start(angle: f64) -> State<2> {
    let (sin, cos) = angle.sin_cos();
    let corner = [2.0 + cos, -sin];
    let hanging = (1..5).map(|i| [corner[0], corner[1] - f64::from(i)]);
    State::of([[0.0, 0.0], [2.0, 0.0], [cos, -sin], corner].into_iter().chain(hanging))
}

#[test]
fn sights_of_narrow_lanes_beside_wide_ones() {
    fn check<S: Method>(method: &S) {
        let long = |ends: [usize; 2]| Rod { length: if ends == [2, 3] { 2.0 } else { 1.0 } };
        let rods = [[0, 2], [1, 3], [2, 3], [3, 4], [4, 5], [5, 6], [6, 7]];
        let scene = Scene::points(8)
            .link_each(rods.map(|ends| (long(ends), ends)))
            .pin(0, [0.0, 0.0])
            .pin(1, [2.0, 0.0])
            .with(PlanarGravity { g: 0.3 });
        // The second and the fourth are nearly flat: normals are at 1e-5 to each other.
        let starts: Vec<_> = [1.0, 1e-5, 0.9, 2e-5, 0.8].map(start).into_iter().collect();
        let mut ensemble = scene.ensemble(starts.iter().cloned(), method.clone()).unwrap();
        let seen = ensemble.observe(30, 10, || Each::of(Told::default));
        let scenes = vec![scene.clone(); 5];
        let mut sweep =
            Ensemble::sweep(Double, scenes.iter().zip(starts.iter().cloned()), method.clone()).unwrap();
        let swept = sweep.observe(30, 10, || Each::of(Told::default));
        for (i, start) in starts.iter().enumerate() {
            for told in [&seen, &swept] {
                // λ of flat ones is 1e5, and known to 1e-16 over the sine.
                let off = told.get(i).unwrap().off_alone(&scene, start, method);
                let allowed = if i % 2 == 1 { 1e-4 } else { 1e-11 };
                println!("{}, {i}: {off:e}", method.name());
                assert!(off < allowed, "{}, {i}: {off:e}", method.name());
            }
        }
    }
    check(&Rattle::new(1e-4));
    check(&Dop853::new(1e-4));
}
