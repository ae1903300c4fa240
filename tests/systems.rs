//! Which method moves which system: the table of `docs/guide/methods.md` and of the reference, asked of every pair.

use crate::common::*;
use rattle::Error;
use rattle::checkpoint::{decode, encode};
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::links::planar::{Rod, TurningLine};
use rattle::nalgebra::Matrix3;
use rattle::prelude::*;
use rattle::scene::Hold;
use std::collections::BTreeSet;

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

/// "yes" where a system is moved, "–" where it is refused before the run, and then who can move it, if the error says
/// so.
fn moves<C: Hold<D>, E: rattle::effect::Effects<D>, N: rattle::bodies::Count, S: Method, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: &S,
) -> (&'static str, Option<Vec<&'static str>>) {
    match scene.simulate(scene.staggered(start, method).unwrap(), method.clone()) {
        Ok(mut simulation) => {
            simulation.run(3).unwrap();
            assert_ne!(&simulation.state(), start, "{}", method.name());
            goes_on_from_checkpoints(scene, start, method, simulation);
            ("yes", None)
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(method.name()) || text.contains("free bodies"), "{text}");
            let Error::CannotMove { others, .. } = error else { return ("–", None) };
            ("–", Some(others))
        }
    }
}

/// Where a run is stopped, written to a file's bytes and gone on from, nothing differs, in any bit of anything kept.
fn goes_on_from_checkpoints<C, E, N, S: Method, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: &S,
    mut simulation: Simulation<C::System<E, N>, S, D>,
) where
    C: Hold<D>,
    E: rattle::effect::Effects<D>,
    N: rattle::bodies::Count,
{
    let bytes = encode(&simulation.checkpoint());
    let start = scene.staggered(start, method).unwrap();
    let mut again = scene.simulate(start, method.clone()).unwrap();
    again.resume(&decode(&bytes, "the checkpoint").unwrap()).unwrap();
    assert_eq!(encode(&again.checkpoint()), bytes, "{}: read and written again", method.name());
    for simulation in [&mut simulation, &mut again] {
        simulation.run(9).unwrap();
    }
    assert_eq!(again.steps(), 12);
    let [whole, parts] = [simulation, again].map(|simulation| encode(&simulation.checkpoint()));
    assert_eq!(whole, parts, "{}: gone on", method.name());
}

fn row<S: Method>(method: &S) -> [(&'static str, Option<Vec<&'static str>>); 7] {
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
    [
        moves(&surface, &billiard_45(), method),
        moves(&free, &State::of([[0.0, 0.0], [1.0, 0.0]]), method),
        moves(&linked, &hanging, method),
        moves(&moving, &State::of([[1.0, 0.0]]).moving([0.0, 0.8]), method),
        moves(&acting, &State::at([0.6, 0.8]), method),
        moves(&rigid, &turning, method),
        moves(&phase, &on_the_sphere, method),
    ]
}

#[test]
fn the_table_of_methods_and_systems() {
    let h = 0.01;
    let rows = [
        ("`Rattle`, and compositions of it", row(&Rattle::new(h))),
        ("`Rattle`, and compositions of it", row(&Composition::new(SUZUKI_1990_ORDER_4, h))),
        ("`Baoab`, `Brownian`", row(&Baoab::new(h))),
        ("`NoseHoover`", row(&NoseHoover::new(1.0, 0.5, h))),
        ("`Baoab`, `Brownian`", row(&Brownian::new(1.0, 0.1, 1, h))),
        ("`Lobatto`", row(&Lobatto::<5>::new(h))),
        (
            "`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`",
            row(&Geodesic::new(2, h)),
        ),
        (
            "`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`",
            row(&PositionVerlet::new(h)),
        ),
        ("`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`", row(&Shake::new(h))),
        (
            "`Geodesic`, `PositionVerlet`, and compositions; `Shake`, `SymplecticEuler`",
            row(&SymplecticEuler::new(h)),
        ),
        ("`Leapfrog`", row(&Leapfrog::new(h))),
        ("`Dop853`", row(&Dop853::new(h))),
        ("`Taylor`", row(&Taylor::new(16, h))),
        ("`Bdf2`", row(&Bdf2::new(h))),
    ];
    let pages =
        [include_str!("../docs/guide/methods.md"), include_str!("../rattle-core/src/motion/method.rs")];
    for (row, page) in rows.iter().flat_map(|row| pages.map(|page| (row, page))) {
        let (name, found) = row;
        let row = format!("| {name} | {} |", found.each_ref().map(|(found, _)| *found).join(" | "));
        println!("{row}");
        assert!(page.lines().any(|line| line.trim_start_matches("//! ") == row), "a page lacks\n{row}");
    }
    // An error names those that have a "yes", and no others.
    let mut told = 0;
    let of_others = [("`Variable`", row(&Variable::of(Rattle::new(h), 0.3)))];
    for system in 0..rows[0].1.len() {
        let able = rows.iter().chain(&of_others).filter(|(_, found)| found[system].0 == "yes");
        let able: BTreeSet<_> = able.flat_map(|(name, _)| name.split('`').skip(1).step_by(2)).collect();
        for others in rows.iter().filter_map(|(_, found)| found[system].1.as_ref()) {
            assert_eq!(others.iter().copied().collect::<BTreeSet<_>>(), able);
            told += 1;
        }
    }
    assert!(told > 5, "{told}");
}

/// Methods that are made of others, and so have no row of their own.
const OF_OTHERS: [&str; 2] = ["Composition", "Variable"];

/// Every method of the core is exported, in the prelude, and in a row of the table, which the test above holds.
#[test]
fn every_method_has_its_row() {
    let (exports, prelude) = include_str!("../src/lib.rs").split_once("pub mod prelude").unwrap();
    let table = include_str!("../docs/guide/methods.md");
    let mut seen = 0;
    for file in std::fs::read_dir("rattle-core/src/methods").unwrap() {
        let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
        for method in text.lines().filter_map(made_here) {
            assert!(exports.contains(&format!("::{method};")), "src/lib.rs does not export `{method}`");
            let mut names = prelude.split(|letter: char| !letter.is_alphanumeric());
            assert!(names.any(|name| name == method), "the prelude lacks `{method}`");
            let quoted = format!("`{method}`");
            let row = table.lines().any(|line| line.starts_with("| `") && line.contains(&quoted));
            assert!(row != OF_OTHERS.contains(&method), "docs/guide/methods.md: the row of {quoted}");
            seen += 1;
        }
    }
    assert!(seen > 14, "{seen}");
}

/// The method that a line makes: a type with a constant step, or one that says itself what a method is.
fn made_here(line: &str) -> Option<&str> {
    let fixed = line.strip_prefix("pub type ").filter(|rest| rest.contains("= Fixed<"));
    let own = || line.starts_with("impl").then(|| line.split_once(" Method for "))?.map(|(_, name)| name);
    let name = fixed.or_else(own)?.split(|letter: char| !letter.is_alphanumeric()).next()?;
    (name != "Fixed").then_some(name)
}
