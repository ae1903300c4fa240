//! Runs that save themselves when some time has passed.

use crate::common::*;
use rattle::checkpoint::{Ended, Save, Saving};
use rattle::prelude::*;
use std::time::Duration;

/// After no time at all, the file holds the run as it is whenever steps are about to be taken.
#[test]
fn files_are_as_far_as_their_runs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rattle");
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let begin = || scene.simulate(billiard_45(), Rattle::new(0.01)).unwrap();
    let (mut run, mut seen) = (begin(), vec![]);
    let saving = Saving::to(&path).every_time(Duration::ZERO);
    let ended = saving.run_to_by(&mut run, 100, 1, |run, part, _| {
        if run.steps() > 0 {
            let mut saved = begin();
            saved.restore(&path).unwrap();
            assert_eq!(bits(&saved.state()), bits(&run.state()));
            seen.push(saved.steps());
        }
        run.run(part)
    });
    assert_eq!((ended.unwrap(), run.steps()), (Ended::Done, 100));
    assert!(seen.len() > 3 && seen.is_sorted_by(|a, b| a < b), "{seen:?}");
    // Without a time, at the end alone.
    let end = folder.path().join("end.rattle");
    let late = Saving::to(&end).every_time(Duration::MAX).run_to_by(&mut begin(), 100, 1, |run, part, _| {
        assert!(!end.exists());
        run.run(part)
    });
    assert!(late.unwrap() == Ended::Done && end.exists());
}
