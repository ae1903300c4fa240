//! The notebook's method: the volume that it is known to make, and the conservative method's depths.
//!
//! Its own figures take minutes: `cargo run --release --example dam_break -- notebook` finds 0.0137 and 266.4 cm²/s,
//! where the notebook has 0.013 and 266.5 on a mesh of Gmsh's.

use rattle_flow::{Flow, FlowError, Notebook, Resistance, dam_break};

#[test]
fn the_notebook_gains_volume_while_ground_gets_wet_and_none_after() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let mut simulation = dam_break::flow(mesh).simulate_by(depth, 1.0 / 32.0, Notebook::of).unwrap();
    let (mut gains, mut dry_until) = (vec![0.0], 0);
    for step in 1..=480 {
        simulation.step().unwrap();
        assert!(simulation.depth().iter().all(|&h| h >= 0.0));
        gains.push(simulation.budget().remainder());
        if simulation.depth().iter().any(|&h| h <= 1e-8) {
            dry_until = step;
        }
    }
    // What Newton's method leaves, 10⁻⁸ of the residual, is a volume of 10⁻⁹ a step.
    assert!(gains.windows(2).all(|pair| pair[1] >= pair[0] - 1e-8), "the volume falls");
    assert!((50..470).contains(&dry_until), "dry until {dry_until}");
    assert!(
        gains[dry_until] > 0.05 && gains[480] - gains[dry_until] < 1e-6,
        "{} {}",
        gains[dry_until],
        gains[480]
    );
}

/// Both are of first order: what they differ by is halved with the mesh, less what fronts spoil.
#[test]
fn the_two_methods_come_together_as_the_mesh_gets_fine() {
    let apart = [0.5, 0.25].map(|spacing| {
        let mesh = dam_break::mesh(spacing).unwrap();
        let depth = dam_break::depth(&mesh);
        let step = spacing / 8.0;
        let flow = || dam_break::flow(mesh.clone());
        let mut theirs = flow().simulate_by(depth.clone(), step, Notebook::of).unwrap();
        let mut ours = flow().simulate(depth, step).unwrap();
        let steps = (1.0 / step) as usize;
        theirs.run(steps).unwrap();
        ours.run(steps).unwrap();
        let difference: Vec<f64> =
            theirs.depth().iter().zip(ours.depth()).map(|(a, b)| (a - b).abs()).collect();
        (
            mesh.volume(&difference).unwrap() / ours.volume(),
            (theirs.mean_flux() / ours.mean_flux() - 1.0).abs(),
        )
    });
    assert!(apart[1].0 < 0.75 * apart[0].0 && apart[1].1 < 0.75 * apart[0].1, "{apart:?}");
}

/// What the notebook does not have is said before a step, and what would change nothing is let through.
#[test]
fn what_the_notebook_leaves_out_is_refused() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let start = |flow: Flow| {
        let depth = dam_break::depth(flow.mesh());
        match flow.simulate_by(depth, 0.1, Notebook::of) {
            Ok(_) => None,
            Err(FlowError::NotServed { what, .. }) => Some(what),
            Err(other) => panic!("{other}"),
        }
    };
    let flow = || dam_break::flow(mesh.clone());
    assert_eq!(start(flow().infiltration(|[_, y]| if y < 1.0 { 0.01 } else { 0.0 })), Some("infiltration"));
    assert_eq!(start(flow().outlet(0.1, |[_, y]| y < 1e-9)), Some("outlets"));
    assert_eq!(start(flow().inflow(|_, _| 0.1, |[_, y]| y < 1e-9)), Some("inflow"));
    assert_eq!(start(Flow::over(mesh.clone(), Resistance::Manning)), Some("the law of Gauckler and Manning"));
    assert_eq!(start(flow().rain(|_, _| 0.1).infiltration(|_| 0.0)), None);
}
