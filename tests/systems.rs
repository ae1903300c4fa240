//! Which method moves which system: the table on the front page and in the reference, asked of every pair.

mod common;
use common::*;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::nalgebra::Matrix3;
use rattle::prelude::*;
use rattle::scene::Hold;

constraint! {
    /// A straight line through the origin that turns in the plane.
    struct TurningLine { omega }
    |x, y, t| y * cos(omega * t) - x * sin(omega * t)
}

constraint! {
    /// Two points of the plane at a distance.
    struct Rod { length }
    |a: [f64; 2], b: [f64; 2]| sum(i in 0..2, (a[i] - b[i])^2) - length^2
}

phase_constraint! {
    /// The unit sphere of phase space.
    struct Hopf {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}

hamiltonian! {
    /// Weight.
    struct Falling { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}

/// "yes" where a system is moved, "–" where it is refused before the run.
fn moves<C: Hold<D>, E: rattle::effect::Effects<D>, N: rattle::bodies::Count, S: Method, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: &S,
) -> &'static str {
    match scene.simulate(scene.staggered(start, method), method.clone()) {
        Ok(mut simulation) => {
            simulation.run(3).unwrap();
            assert_ne!(&simulation.state(), start, "{}", method.name());
            "yes"
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(method.name()) || text.contains("free bodies"), "{text}");
            "–"
        }
    }
}

fn row<S: Method>(name: &str, method: &S) -> String {
    let surface = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let free = Scene::points(2).with(PlanarGravity { g: 1.0 });
    let linked = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
    let linked = linked.with(PlanarGravity { g: 1.0 });
    let moving = Scene::points(1).link_moving(TurningLine { omega: 0.8 }, [[0]]);
    let acting = Scene::point().link_acting(Pendulum { length: 1.0 }, [[0]], [[true, false]]);
    let acting = acting.with(PlanarGravity { g: 1.0 });
    let rigid = Scene::rigid(Rigid::new([0.6, 0.8, 1.0]));
    let phase = Scene::in_phase_space(Hopf {}, Falling { g: 0.3 });
    let hanging = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    let turning = Rigid::start(&Matrix3::identity(), &[1.8, 0.4, -0.9].into());
    let on_the_sphere = phase.project(&State::at([-0.55, -0.83])).unwrap();
    let found = [
        moves(&surface, &billiard_45(), method),
        moves(&free, &State::of([[0.0, 0.0], [1.0, 0.0]]), method),
        moves(&linked, &hanging, method),
        moves(&moving, &State::of([[1.0, 0.0]]).moving([0.0, 0.8]), method),
        moves(&acting, &State::at([0.6, 0.8]), method),
        moves(&rigid, &turning, method),
        moves(&phase, &on_the_sphere, method),
    ];
    format!("| {name} | {} |", found.join(" | "))
}

#[test]
fn the_table_of_the_front_page() {
    let h = 0.01;
    let rows = [
        row("`Rattle`, and compositions of it", &Rattle::new(h)),
        row("`Rattle`, and compositions of it", &Composition::new(SUZUKI_1990_ORDER_4, h)),
        row("`Lobatto`", &Lobatto::<5>::new(h)),
        row(
            "`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`",
            &Geodesic::new(h, 2),
        ),
        row(
            "`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`",
            &PositionVerlet::new(h),
        ),
        row("`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`", &Shake::new(h)),
        row(
            "`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`",
            &SymplecticEuler::new(h),
        ),
        row("`Leapfrog`", &Leapfrog::new(h)),
        row("`Dop853`", &Dop853::new(h)),
        row("`Taylor`", &Taylor::new(16, h)),
        row("`Bdf2`", &Bdf2::new(h)),
    ];
    let pages = [include_str!("../docs/methods.md"), include_str!("../rattle-core/src/motion/method.rs")];
    for (row, page) in rows.iter().flat_map(|row| pages.map(|page| (row, page))) {
        println!("{row}");
        assert!(page.lines().any(|line| line.trim_start_matches("//! ") == row), "a page lacks\n{row}");
    }
}
