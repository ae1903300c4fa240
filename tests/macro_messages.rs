//! Every mistake in an expression is reported at its own token, all of them at once, and nothing else is: no second
//! wave of errors from what could not be generated.
//!
//! The compiler is asked with the library that this program was built with, where trybuild would compile all that is
//! needed once more (60 CPU seconds). `MESSAGES=write cargo test --test language macro_messages::` writes what it says.

use std::env::consts::DLL_EXTENSION;
use std::env::{current_exe, var_os};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Beside each program what the compiler says of it.
const FOLDER: &str = "tests/messages";

#[test]
fn messages() {
    let programs = fs::read_dir(FOLDER).unwrap().map(|file| file.unwrap().path());
    let mut programs: Vec<_> =
        programs.filter(|file| file.extension().is_some_and(|kind| kind == "rs")).collect();
    programs.sort();
    assert!(programs.len() >= 9, "{programs:?}");

    let libraries =
        [("rattle", library("rattle", "rlib")), ("rattle_macros", library("rattle_macros", DLL_EXTENSION))];
    let mut others = vec![];
    for program in programs {
        let said = said_of(&program, &libraries);
        let expected = program.with_extension("stderr");
        if var_os("MESSAGES").is_some_and(|wish| wish == "write") {
            fs::write(&expected, &said).unwrap();
        } else if said != fs::read_to_string(&expected).unwrap_or_default() {
            others.push(format!("{}, expected {}:\n\n{said}", program.display(), expected.display()));
        }
    }
    assert!(others.is_empty(), "{}", others.join("\n"));
}

/// A library of the same folder of artefacts: the newest, as others there have other features or other sources.
fn library(name: &str, kind: &str) -> PathBuf {
    let folder = current_exe().unwrap().parent().unwrap().to_owned();
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap());
    let libraries = files.filter(|file| {
        let file = file.file_name().into_string().unwrap();
        file.contains(&format!("{name}-")) && file.ends_with(kind)
    });
    libraries.max_by_key(|file| file.metadata().unwrap().modified().unwrap()).unwrap().path()
}

/// What the compiler says of a program, which it must refuse: without the count of errors at the end, and without lines
/// of the library, which it does not find from there, nor their numbers. Of sizes, which it knows when it makes code,
/// the errors' own lines: the others are about the insides of a panic.
fn said_of(program: &Path, libraries: &[(&str, PathBuf)]) -> String {
    let of_sizes = program.file_stem().is_some_and(|name| name == "sizes");
    let emit = if of_sizes { "obj" } else { "metadata" };
    let mut rustc = Command::new("rustc");
    rustc.args(["--edition", "2024", "--crate-type", "bin", "--emit", emit, "-A", "unused"]);
    rustc.arg("--out-dir").arg(env!("CARGO_TARGET_TMPDIR"));
    for (name, file) in libraries {
        rustc.arg("--extern").arg(format!("{name}={}", file.display()));
        rustc.arg("-L").arg(format!("dependency={}", file.parent().unwrap().display()));
    }
    let result = rustc.arg(program.file_name().unwrap()).current_dir(FOLDER).output().unwrap();
    assert!(!result.status.success(), "{} compiles", program.display());

    let said = String::from_utf8(result.stderr).unwrap();
    let lines = said.split("error: aborting due to").next().unwrap().trim_end().lines();
    let without_number = |line: &str| match line.split_once(".rs:") {
        Some((place, _)) if place.contains("--> rattle") => format!("{place}.rs\n"),
        _ => format!("{line}\n"),
    };
    lines.filter(|line| !of_sizes || line.starts_with("error")).map(without_number).collect()
}
