//! A program that is killed at any moment, and started again, ends with the bits of one that never was. The program is
//! this test itself, with a task in its environment.

use rattle::checkpoint::{Checkpoint, Ended, Saving, encode, read};
use rattle::effect::Langevin;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;
use std::env;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::Duration;

use rand::{RngExt, SeedableRng, rngs::StdRng};

const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
/// Saved so often that some kills come while a file is written.
fn every(task: &str) -> u64 {
    if task == "ensemble" { 16 } else { 256 }
}
const FOREVER: u64 = u64::MAX / 2;

fn start(i: u32) -> State<3> {
    let angle = 0.37 * f64::from(i);
    State::at([0.0, 0.0, SURFACE.r]).moving([angle.cos(), angle.sin(), 0.0])
}

/// What is simulated: a particle in a heat bath, or an ensemble of which some trajectories end.
fn run(task: &str) -> Box<dyn Checkpoint> {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    if task == "ensemble" {
        let fast = |i: u32| if i.is_multiple_of(9) { start(i).moving([15.0, 10.0, 0.0]) } else { start(i) };
        return Box::new(scene.ensemble((0..70).map(fast), Rattle::new(0.01)).unwrap());
    }
    let bath = Langevin { friction: 0.1, temperature: 0.1, seed: 16 };
    Box::new(scene.with(bath).simulate(start(1), Rattle::new(0.01)).unwrap())
}

/// The program: goes on from the file, if there is one, and saves.
#[test]
#[ignore = "is started by the others"]
fn program() {
    let Ok(task) = env::var("RATTLE_TASK") else { return };
    let path = env::var("RATTLE_FILE").unwrap();
    let steps: u64 = env::var("RATTLE_STEPS").unwrap().parse().unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let told = stop.clone();
    ctrlc::set_handler(move || told.store(true, Ordering::Relaxed)).unwrap();
    let mut run = run(&task);
    let saving = Saving::to(&path).every(every(&task)).until(stop);
    saving.restore(&mut *run).unwrap();
    println!("started");
    match saving.run_to(&mut *run, steps).unwrap() {
        Ended::Done => println!("done"),
        Ended::Stopped => println!("stopped after {} steps; start it again to go on", run.steps_taken()),
    }
}

fn started(task: &str, path: &Path, steps: u64) -> Child {
    Command::new(env::current_exe().unwrap())
        .args(["program", "--exact", "--ignored", "--nocapture"])
        .envs([("RATTLE_TASK", task), ("RATTLE_FILE", path.to_str().unwrap())])
        .env("RATTLE_STEPS", steps.to_string())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

fn steps_in(path: &Path) -> u64 {
    let record = read(path).unwrap_or_else(|error| panic!("{error}"));
    let mut again = run(if record.field("group 0/steps").is_some() { "ensemble" } else { "particle" });
    again.resume(&record).unwrap();
    again.steps_taken()
}

/// Which file stands there: a new one has another time or length.
fn version(path: &Path) -> Option<(std::time::SystemTime, u64)> {
    let found = fs::metadata(path).ok()?;
    Some((found.modified().ok()?, found.len()))
}

/// Kills the program so many times, each at a random moment after it saved so often, or before; lets it end, and
/// compares with one that was left alone.
fn killed(task: &str, times: u32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rattle");
    let mut random = StdRng::seed_from_u64(16);
    let (mut last, mut advanced) = (0, 0);
    for life in 0..times {
        let mut program = started(task, &path, FOREVER);
        for _ in 0..life % 3 {
            let before = version(&path);
            while version(&path) == before {
                assert!(program.try_wait().unwrap().is_none(), "ended by itself");
                sleep(Duration::from_micros(200));
            }
        }
        sleep(Duration::from_micros(random.random_range(0..10_000)));
        program.kill().unwrap(); // SIGKILL
        program.wait().unwrap();
        if path.exists() {
            let now = steps_in(&path);
            assert!(now >= last && now.is_multiple_of(every(task)), "{now} steps after {last}");
            advanced += u32::from(now > last);
            last = now;
        }
    }
    assert!(advanced >= times / 3 * 2, "of {times} lives {advanced} were longer than a checkpoint");
    let whole = last + 1000;
    let ended = started(task, &path, whole).wait_with_output().unwrap();
    assert!(String::from_utf8_lossy(&ended.stdout).contains("done"));
    let mut alone = run(task);
    alone.take_steps(whole).unwrap();
    assert!(fs::read(&path).unwrap() == encode(&alone.checkpoint()), "other bits after {whole} steps");
    println!("{task}: killed {times} times in {whole} steps, {advanced} of the lives got on");
}

#[test]
fn a_killed_program_goes_on() {
    killed("particle", 10);
    killed("ensemble", 10);
}

/// `cargo test --release --test killed -- --ignored a_thousand_kills --nocapture`
#[test]
#[ignore = "takes a minute"]
fn a_thousand_kills() {
    killed("particle", 500);
    killed("ensemble", 500);
}

#[cfg(unix)]
#[test]
fn interrupted_it_ends_after_the_step_and_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rattle");
    let program = started("particle", &path, FOREVER);
    while !path.exists() {
        sleep(Duration::from_millis(1)); // until it saved first: then it listens
    }
    let told = Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap();
    let ended = program.wait_with_output().unwrap();
    assert!(told.success() && ended.status.success());
    let words = String::from_utf8_lossy(&ended.stdout);
    let steps = steps_in(&path);
    assert!(words.contains(&format!("stopped after {steps} steps; start it again")), "{words}");
}

/// Folders are made before the first step, and a place where nothing can be written is told then.
#[test]
fn a_run_that_cannot_be_saved_does_not_begin() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing/folder/run.rattle");
    let mut one = run("particle");
    let saving = Saving::to(&path).every(5);
    let mut begun = false;
    saving
        .run_to_by(&mut *one, 10, 1, |run, steps, _| {
            begun = begun || path.parent().is_some_and(Path::is_dir);
            run.take_steps(steps)
        })
        .unwrap();
    assert!(begun && path.is_file());
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "something is left beside the file");

    for place in [folder.path().to_path_buf(), path.join("below a file")] {
        let mut one = run("particle");
        assert!(Saving::to(&place).run_to(&mut *one, 10).is_err());
        assert_eq!(one.steps_taken(), 0, "{}", place.display());
    }
}
