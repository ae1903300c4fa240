//! Links whose multipliers act on chosen coordinates: what moves is known in closed form, as the other coordinates move
//! as if there were no links.

use crate::common::linked::Rod;
use rattle::Error;
use rattle::error::StartFailure;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::network::LinearAlgebra;
use rattle::prelude::*;

constraint! {
    /// A plane in four dimensions.
    struct Slope { a, b, c, d }
    |x, y, z, w| a * x + b * y + c * z + d * w
}

constraint! {
    /// A plane that is bent.
    struct Bent { a, b, c, bend }
    |x, y, z| a * x + b * y + c * z + bend * (x^2 + y^2 - z^2)
}

constraint! {
    /// A floor.
    struct Floor {}
    |_x, y| y
}

/// Acting on coordinate i alone.
fn along<const D: usize>(i: usize) -> [[bool; D]; 1] {
    [std::array::from_fn(|j| i == j)]
}

/// G Aᵀ is regular, with a leading minor that is negative, or zero: x = −G⁻¹d w where w moves evenly.
#[test]
fn minors_of_any_sign() {
    let pairs = [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let chain = [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]];
    let [d, start, v] = [[-1.0, 1.0, 0.5], [0.7; 3], [0.6; 3]];
    for (rows, algebra) in [
        (pairs, LinearAlgebra::Automatic),
        (pairs, LinearAlgebra::Elimination),
        (chain, LinearAlgebra::Automatic),
    ] {
        let g = Matrix3::from_fn(|i, j| rows[i][j]);
        let way = -g.try_inverse().unwrap() * Vector3::from(d);
        let place = |w: f64| [way.x * w, way.y * w, way.z * w, w];
        let mut scene = Scene::point().linear_algebra(algebra);
        for i in [1, 0, 2] {
            let [a, b, c] = rows[i];
            scene = scene.link_acting(Slope { a, b, c, d: d[i] }, [[0]], along(i));
        }
        let state = State::at(place(start[0])).moving(place(v[0]));
        let end = place(start[0] + v[0]);
        // All is linear: what rounding leaves of ten steps of numbers below 4.
        let check = |q: rattle::nalgebra::SVector<f64, 4>| {
            assert!((0..4).all(|i| (q[i] - end[i]).abs() < 1e-13), "{rows:?} {algebra:?}: {q} {end:?}");
        };
        let mut newton = scene.simulate(state.clone(), Rattle::new(0.1)).unwrap();
        newton.run(10).unwrap();
        check(newton.position());
        let mut broyden = scene.simulate(state.clone(), Rattle::new(0.1).solved_by(Broyden)).unwrap();
        broyden.run(10).unwrap();
        check(broyden.position());
        let mut simplified = scene.simulate(state.clone(), Rattle::new(0.1).solved_by(Simplified)).unwrap();
        simplified.run(10).unwrap();
        check(simplified.position());
        let mut projected = scene.simulate(state, Dop853::new(0.1)).unwrap();
        projected.run(10).unwrap();
        check(projected.position());
    }
}

/// The same on surfaces that are bent: z moves evenly, and x and y go with it.
#[test]
fn bent_with_a_negative_minor() {
    for order in [[0, 1], [1, 0]] {
        let mut scene = Scene::point();
        for i in order {
            let of = [[1.0, 2.0, -1.0], [2.0, 1.0, 1.0]][i];
            scene = scene.link_acting(Bent { a: of[0], b: of[1], c: of[2], bend: 0.1 }, [[0]], along(i));
        }
        // Of G v = 0 at the origin.
        let state = State::at([0.0; 3]).moving([-1.0, 1.0, 1.0]);
        let mut simulation = scene.simulate(state, Rattle::new(0.05)).unwrap();
        simulation.run(10).unwrap();
        let q = simulation.position();
        assert!((q.z - 0.5).abs() < 1e-15 && simulation.constraint_residual() < 1e-15, "{q}");
        assert!(q.x < -0.45 && q.y > 0.4, "{q}");
    }
}

/// What is wrong is told: rods that depend on each other where a link acts on chosen coordinates, or two links that act
/// in one way.
#[test]
fn dependent_links_beside_one_that_acts() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let rods = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]];
    let length =
        |a: usize, b: usize| f64::hypot(corners[a][0] - corners[b][0], corners[a][1] - corners[b][1]);
    let scene = Scene::points::<2>(4).link_acting(Floor {}, [[0]], [[true, true]]);
    let scene = scene.link_each(rods.map(|[a, b]| (Rod { length: length(a, b) }, [a, b])));
    let error = scene.simulate(State::of(corners), Rattle::new(0.01)).map(drop).unwrap_err();
    let Error::Start { cause: StartFailure::Dependent { equation, .. }, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(equation.link, "Rod");

    let scene = Scene::point()
        .link_acting(Slope { a: 1.0, b: 1.0, c: 1.0, d: 0.0 }, [[0]], along(0))
        .link_acting(Slope { a: 1.0, b: 1.0, c: -1.0, d: 0.0 }, [[0]], along(1));
    let error = scene.simulate(State::at([0.0; 4]), Rattle::new(0.01)).map(drop).unwrap_err();
    assert!(matches!(error, Error::Start { cause: StartFailure::CannotAct { .. }, .. }), "{error}");
}
