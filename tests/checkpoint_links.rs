//! Checkpoints behind links: a link that leads nowhere is not where no run has been, and a link stays one.

#![cfg(unix)]

use crate::common::*;
use rattle::checkpoint::{CheckpointError, Ended, Save, Saving};
use rattle::prelude::*;
use rattle::system::System;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

fn fall() -> Simulation<impl System<f64, 2>, Rattle, 2> {
    Scene::point().with(PlanarGravity { g: 1.0 }).simulate(State::at([0.0, 1.0]), Rattle::new(0.1)).unwrap()
}

fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).unwrap().is_symlink()
}

#[test]
fn a_run_does_not_begin_anew_where_its_checkpoint_cannot_be_reached() {
    let folder = tempfile::tempdir().unwrap();
    let [none, link] = ["none.rattle", "run.rattle"].map(|name| folder.path().join(name));
    for to in ["missing/run.rattle", "missing.rattle", "run.rattle"] {
        symlink(to, &link).unwrap();
        let error = Saving::to(&link).restore(&mut fall()).unwrap_err();
        assert!(matches!(error, CheckpointError::Io { .. }), "{error}");
        assert!(is_link(&link), "to {to}");
        fs::remove_file(&link).unwrap();
    }
    symlink("away", folder.path().join("disk")).unwrap();
    let away = Saving::to(folder.path().join("disk/run.rattle")).restore(&mut fall()).unwrap_err();
    assert!(away.to_string().contains("a link that leads nowhere"), "{away}");
    assert!(!Saving::to(&none).restore(&mut fall()).unwrap());
    assert!(!Saving::to(folder.path().join("none/run.rattle")).restore(&mut fall()).unwrap());
    assert_eq!(Saving::to(&none).run_to(&mut fall(), 10).unwrap(), Ended::Done);
}

/// The first save makes the file to which a link leads, whether the link tells its place from the root or from itself.
#[test]
fn a_link_stays_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("far")).unwrap();
    symlink("second.rattle", at("first.rattle")).unwrap();
    symlink("far/run.rattle", at("second.rattle")).unwrap();
    symlink(at("far/other.rattle"), at("third.rattle")).unwrap();
    symlink("missing/run.rattle", at("nowhere.rattle")).unwrap();
    for (link, file) in [("first.rattle", "far/run.rattle"), ("third.rattle", "far/other.rattle")] {
        for steps in [5, 10] {
            let mut simulation = fall();
            simulation.run(steps).unwrap();
            simulation.save(at(link)).unwrap();
            assert!(is_link(&at(link)) && !is_link(&at(file)), "{link}");
            let mut restored = fall();
            assert!(Saving::to(at(link)).restore(&mut restored).unwrap());
            assert_eq!(restored.steps(), steps);
        }
    }
    assert!(is_link(&at("second.rattle")));
    assert!(Saving::to(at("nowhere.rattle")).run_to(&mut fall(), 10).is_err());
    assert!(is_link(&at("nowhere.rattle")));
    assert_eq!(fs::read_dir(at("far")).unwrap().count(), 2, "something is left beside the files");
}

/// What an error says is so when a file is read as well as when it is written.
#[test]
fn errors_of_files_say_what_is_so() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing/run.rattle");
    let mut simulation = fall();
    for error in [simulation.save(&missing).unwrap_err(), simulation.restore(&missing).unwrap_err()] {
        let message = error.to_string();
        assert!(message.contains("no checkpoint was changed") && !message.contains("last"), "{message}");
    }
}
