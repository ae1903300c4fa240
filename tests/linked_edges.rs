//! Edges of links, over which `over_kinks` takes bodies.

use rattle::prelude::*;

constraint! {
    /// A plane with an edge at x = d.
    struct Sheet { a, b, c, k, d }
    |x, y, z| a * x + b * y + c * z - k * abs(x - d)
}

/// Two links of one type on one body, of which one is met at its edge: over the ridge of a roof, along a wall. The
/// momentum along x and y stays, and that along z turns over.
#[test]
fn of_two_links_of_one_type_the_one_that_is_met() {
    let roof = Sheet { a: 0.0, b: 0.0, c: 1.0, k: 0.5, d: 0.0 };
    let wall = Sheet { a: 0.3, b: 1.0, c: 0.0, k: 0.0, d: 5.0 };
    for links in [[roof, wall], [wall, roof]] {
        let scene = Scene::point().link(links[0], [[0]]).link(links[1], [[0]]);
        let start = State::at([-0.52, 0.156, 0.26]).moving([1.0, -0.3, -0.5]);
        let start = scene.project(&start).unwrap();
        let mut simulation = scene.simulate(start, Rattle::new(0.1)).unwrap().over_kinks().unwrap();
        simulation.run(10).unwrap();
        let ends = [(simulation.momentum(), [1.0, -0.3, 0.5]), (simulation.position(), [0.48, -0.144, 0.24])];
        for (found, right) in ends {
            // Straight on: some roundings a step, and the edge is met within some.
            assert!((0..3).all(|i| (found[i] - right[i]).abs() < 1e-14), "{found} {right:?}");
        }
    }
}
