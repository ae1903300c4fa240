//! The house: no circle between files, and no import that runs up from a lower layer to a higher one.
//!
//! Read off the `use` lines and paths of the sources. `ARCHITECTURE.md` shows the same layers. Documentation may name
//! what stands higher; tests inside a file may import anything.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Layers from the ground up; a folder is named by its path, and what is beside each other does not know each other.
const CORE: &[&[&str]] = &[
    &["number", "error"],
    &["kernel"],
    &["effect", "geometry"],
    &["motion"],
    &["solve"],
    &["systems", "methods"],
    &["scene"],
    &["run"],
    &["instances"],
];

/// Systems that stand on another.
const SYSTEMS: &[&[&str]] = &[&["surface", "network", "rigid", "phase"], &["linked"]];

/// A code file longer than this has more than one subject. Tables are data.
const LONGEST: usize = 600;
const TABLES: &[&str] = &["motion/tables.rs"];

type Module = Vec<String>;

/// A crate's files by module, and what each imports of the others.
struct House {
    files: BTreeMap<Module, String>,
    arrows: BTreeMap<Module, BTreeSet<Module>>,
}

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// The text without comments, imports for documentation, and test modules.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let mut lines = Vec::new();
    let mut for_documentation = false;
    for line in text.lines() {
        let line = line.split("//").next().unwrap();
        if line.trim() == "#[cfg(doc)]" {
            for_documentation = true;
        } else if for_documentation {
            for_documentation = !line.contains(';');
        } else {
            lines.push(line);
        }
    }
    lines.join("\n")
}

/// The paths that a tree of imports stands for.
fn leaves(tree: &str) -> Vec<String> {
    let Some(open) = tree.find('{') else {
        return vec![tree.split(" as ").next().unwrap().split_whitespace().collect()];
    };
    let (head, body) = (&tree[..open], &tree[open + 1..tree.rfind('}').unwrap()]);
    let (mut depth, mut item, mut found) = (0, String::new(), Vec::new());
    for c in body.chars().chain([',']) {
        match c {
            ',' if depth == 0 => {
                if !item.trim().is_empty() {
                    found.extend(leaves(item.trim()).iter().map(|leaf| format!("{}{leaf}", head.trim())));
                }
                item.clear();
                continue;
            }
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        item.push(c);
    }
    found
}

/// All paths in the text that begin in this crate, and children of the module that imports name.
fn paths(text: &str) -> Vec<String> {
    let (mut found, mut rest, mut import) = (Vec::new(), String::new(), String::new());
    for line in text.lines() {
        let begins = line.split_whitespace().find(|word| !word.starts_with("pub")) == Some("use");
        if import.is_empty() && !begins {
            rest.push_str(line);
            rest.push('\n');
            continue;
        }
        import.push_str(line.split_once("use ").filter(|_| begins).map_or(line, |(_, tree)| tree));
        if let Some((tree, _)) = import.clone().split_once(';') {
            found.extend(leaves(tree));
            import.clear();
        }
    }
    for root in ["crate::", "super::", "self::"] {
        for (at, _) in rest.match_indices(root) {
            if !rest[..at].ends_with([':', '_']) && !rest[..at].ends_with(char::is_alphanumeric) {
                let path = rest[at..].chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c));
                found.push(path.collect());
            }
        }
    }
    found
}

impl House {
    fn of(root: &str) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
        let mut paths_of_files = Vec::new();
        sources(&root, &mut paths_of_files);
        let mut files = BTreeMap::new();
        for path in paths_of_files {
            let relative = path.strip_prefix(&root).unwrap().with_extension("");
            let mut module: Module = relative.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
            if ["mod", "lib", "main"].contains(&module.last().unwrap().as_str()) {
                module.pop();
            }
            files.insert(module, fs::read_to_string(path).unwrap());
        }
        Self::made_of(files)
    }

    /// A house of files with these texts.
    fn made_of(files: BTreeMap<Module, String>) -> Self {
        let mut arrows = BTreeMap::new();
        for (module, text) in &files {
            let text = code(text);
            let mut to = BTreeSet::new();
            for path in paths(&text) {
                let mut at: Module = Vec::new();
                let mut parts = path.split("::").peekable();
                match *parts.peek().unwrap() {
                    "crate" => drop(parts.next()),
                    "self" => {
                        at.clone_from(module);
                        parts.next();
                    }
                    "super" => {
                        at.clone_from(module);
                        while parts.next_if_eq(&"super").is_some() {
                            at.pop();
                        }
                    }
                    child => {
                        at.clone_from(module);
                        at.push(child.to_owned());
                        if !files.contains_key(&at) {
                            continue; // another crate
                        }
                        at.pop();
                    }
                }
                let mut best = files.contains_key(&at).then(|| at.clone());
                for part in parts {
                    at.push(part.to_owned());
                    if files.contains_key(&at) {
                        best = Some(at.clone());
                    }
                }
                to.extend(best.filter(|best| best != module));
            }
            arrows.insert(module.clone(), to);
        }
        Self { files, arrows }
    }

    /// Files that can be come back to by going along imports.
    fn circles(&self) -> Vec<String> {
        let reached = |from: &Module| {
            let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
            while let Some(module) = next.pop() {
                next.extend(self.arrows[module].iter().filter(|to| seen.insert((*to).clone())));
            }
            seen
        };
        self.files.keys().filter(|module| reached(module).contains(*module)).map(|m| m.join("::")).collect()
    }

    /// Imports from a layer to another one beside or above it.
    fn upwards(&self, within: &[&str], layers: &[&[&str]]) -> Vec<String> {
        let room = |module: &Module| {
            let inside = module.len() > within.len() && module.iter().zip(within).all(|(a, b)| a == b);
            inside.then(|| module[within.len()].clone())
        };
        let layer = |room: &str| {
            let found = layers.iter().position(|rooms| rooms.contains(&room));
            found.unwrap_or_else(|| panic!("{room} has no layer: give it one here and in ARCHITECTURE.md"))
        };
        let mut found = Vec::new();
        for (from, to) in self.arrows.iter().flat_map(|(from, to)| to.iter().map(move |to| (from, to))) {
            if let (Some(below), Some(above)) = (room(from), room(to))
                && below != above
                && layer(&below) <= layer(&above)
            {
                found.push(format!("{} imports {}", from.join("::"), to.join("::")));
            }
        }
        found
    }
}

#[test]
fn no_file_imports_itself_by_way_of_others() {
    for root in ["rattle-core/src", "rattle-symbolic/src", "src"] {
        let house = House::of(root);
        assert!(house.arrows.values().map(BTreeSet::len).sum::<usize>() > 3, "{root}: nothing was read");
        assert_eq!(house.circles(), Vec::<String>::new(), "{root}: these files are in circles");
    }
}

#[test]
fn imports_run_down() {
    let house = House::of("rattle-core/src");
    assert_eq!(house.upwards(&[], CORE), Vec::<String>::new());
    assert_eq!(house.upwards(&["systems"], SYSTEMS), Vec::<String>::new());
}

/// A circle of two files by way of a third, and an import from a lower layer, are found where they are planted.
#[test]
fn circles_and_imports_that_run_up_are_seen() {
    let file = |path: &str, text: &str| (path.split("::").map(str::to_owned).collect(), text.to_owned());
    let house = |text_of_b: &str| {
        House::made_of(BTreeMap::from([
            file("number::a", ""),
            file("kernel::b", text_of_b),
            file("motion::c", "use crate::kernel::b::{X, Y};\nuse crate::number::a::Z;"),
        ]))
    };
    let sound = house("use crate::number::a::Z;");
    assert_eq!((sound.circles(), sound.upwards(&[], CORE)), (vec![], vec![]));
    let unsound = house("fn f() { crate::motion::c::g() }");
    assert_eq!(unsound.circles(), ["kernel::b", "motion::c"]);
    assert_eq!(unsound.upwards(&[], CORE), ["kernel::b imports motion::c"]);
}

/// Who reads `use` lines wrongly finds no circle anywhere.
#[test]
fn arrows_are_read_off_imports_and_paths() {
    let found = paths(&code(
        "use crate::a::{b, c::{d, e as f}};\npub(crate) use super::g;\n// use crate::comment;\nfn x() { crate::h::i() }\n\
         #[cfg(doc)]\nuse crate::doc;\n#[cfg(test)]\nmod tests { use crate::test; }",
    ));
    assert_eq!(found, ["crate::a::b", "crate::a::c::d", "crate::a::c::e", "super::g", "crate::h::i"]);
}

#[test]
fn files_have_one_subject() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for package in
        ["", "rattle-core", "rattle-flow", "rattle-macros", "rattle-symbolic", "optimised", "vectorised"]
    {
        for folder in ["src", "tests", "benches", "examples"].map(|folder| root.join(package).join(folder)) {
            if folder.exists() {
                sources(&folder, &mut files);
            }
        }
    }
    assert!(files.len() > 500, "{}", files.len());
    for path in files.iter().filter(|path| !TABLES.iter().any(|table| path.ends_with(table))) {
        let lines = fs::read_to_string(path).unwrap().lines().count();
        assert!(lines <= LONGEST, "{}: {lines} lines", path.display());
    }
}

/// A test that is left out for want of speed is one that `cargo long` runs.
#[test]
fn what_is_left_out_runs_elsewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let alias = fs::read_to_string(root.join(".cargo/config.toml")).unwrap();
    assert!(alias.contains("--workspace") && alias.contains("'--cfg', 'long'"), "{alias}");
    let mut files = Vec::new();
    for folder in
        ["tests", "optimised/tests", "vectorised/tests", "rattle-flow/tests", "rattle-symbolic/tests"]
    {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 80, "{}", files.len());
    let mut left_out = 0;
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        for line in text.lines().map(str::trim) {
            let left = line.starts_with("#[cfg") && line.contains("long");
            let told = line == "#[cfg(long)]" || line.contains("cargo long");
            assert!(!left || told, "{}: {line}", path.display());
            left_out += usize::from(left);
        }
    }
    assert!((80..200).contains(&left_out), "{left_out} tests, and parts of tests, are left out");
}

/// Programs of tests are named in `Cargo.toml`: a file that none of them takes in would never run.
#[test]
fn every_test_is_in_a_program() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["tests", "optimised/tests"] {
        let mut files = Vec::new();
        sources(&root.join(folder).join("programs"), &mut files);
        let mut taken: String = files.iter().map(|file| fs::read_to_string(file).unwrap()).collect();
        taken += &fs::read_to_string(root.join(folder).join("../Cargo.toml"))
            .unwrap()
            .replace("name = ", "\"../")
            .replace("../\"", "../");
        for entry in fs::read_dir(root.join(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let Some(stem) = name.strip_suffix(".rs") else { continue };
            let alone = taken.contains(&format!("\"../{stem}\""));
            let together = taken.contains(&format!("\"../{name}\"]\nmod {stem};"));
            assert!(alone != together, "{folder}/{name} is in no program, or in two: see {folder}/programs");
        }
    }
}

/// What a simulation costs is told at its end: not where prices are the subject, pictures of many scenes, or water.
#[test]
fn every_simulation_of_the_examples_ends_with_its_bill() {
    const OTHERS: [&str; 5] = ["accuracy", "dam_break.rs", "gallery.rs", "surface_pictures.rs", "valley.rs"];
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut files = Vec::new();
    sources(&examples, &mut files);
    files.retain(|file| !OTHERS.iter().any(|other| file.starts_with(examples.join(other))));
    let mut simulating = 0;
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        if [".simulate(", ".ensemble("].iter().any(|verb| text.contains(verb)) {
            simulating += 1;
            assert!(text.contains(".bill()"), "{} prints no bill", file.display());
        }
    }
    assert!(simulating > 20, "{simulating}");
}
