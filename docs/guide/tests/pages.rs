//! The pages hold together: links lead somewhere, all pages are in the book and their programs among the tests, and the
//! mistakes that the guide lists are those that the macros tell.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All files that end so, but for what is built.
fn files(ending: &str) -> Vec<PathBuf> {
    fn collect(folder: &Path, ending: &str, into: &mut Vec<PathBuf>) {
        let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        entries.sort();
        for path in entries {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                if !name.starts_with('.') && !["target", "out", "node_modules"].contains(&name.as_str()) {
                    collect(&path, ending, into);
                }
            } else if name.ends_with(ending) {
                into.push(path);
            }
        }
    }
    let mut found = Vec::new();
    collect(&root(), ending, &mut found);
    assert!(found.len() > 4, "{ending}: only {} files", found.len());
    found
}

/// What is relative to the project's folder, with slashes.
fn within_project(path: &Path) -> String {
    path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/")
}

/// The names in a folder of files that end so, and of folders, without the ending.
fn names(folder: &str, ending: &str) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let wanted = entries.filter(|path| path.is_dir() || path.to_string_lossy().ends_with(ending));
    wanted.map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect()
}

/// The text outside of blocks of code.
fn prose(text: &str) -> Vec<&str> {
    let mut code = false;
    let outside = |line: &&str| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    };
    text.lines().filter(outside).collect()
}

/// What links and pictures point to.
fn targets(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in prose(text) {
        // Code within a line shows links, and has none.
        let words: String = line.split('`').step_by(2).collect::<Vec<_>>().join("·");
        for part in words.split("](").skip(1) {
            found.extend(part.split(')').next().map(|target| target.trim().to_string()));
        }
    }
    found
}

/// The anchors of the headings of a page, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text).into_iter().filter(|line| line.starts_with('#'));
    let anchor = |heading: &str| {
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
    };
    headings.map(anchor).collect()
}

#[test]
fn links_lead_somewhere() {
    let (mut followed, mut broken) = (0, Vec::new());
    for page in files(".md") {
        let text = fs::read_to_string(&page).unwrap();
        for target in targets(&text) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            followed += 1;
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let at = if path.is_empty() { page.clone() } else { page.parent().unwrap().join(path) };
            let fine = at.exists()
                && (anchor.is_empty() || anchors(&fs::read_to_string(&at).unwrap()).contains(anchor));
            if !fine {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(followed > 60, "only {followed} links were found");
    assert!(broken.is_empty(), "dead links:\n{}", broken.join("\n"));
}

#[test]
fn every_page_is_in_the_book_and_its_programs_are_tests() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let tests = fs::read_to_string(root().join("docs/guide/lib.rs")).unwrap();
    let mut programs = 0;
    for page in fs::read_dir(root().join("docs/guide")).unwrap().map(|entry| entry.unwrap().path()) {
        if page.extension().is_none_or(|extension| extension != "md") {
            continue;
        }
        let name = page.file_name().unwrap().to_string_lossy().into_owned();
        assert!(summary.contains(&format!("(guide/{name})")), "{name} is not in docs/SUMMARY.md");
        let number = fs::read_to_string(&page).unwrap().matches("\n```rust").count();
        programs += number;
        assert!(number == 0 || tests.contains(&format!("\"{name}\"")), "{name} is not in docs/guide/lib.rs");
    }
    assert!(programs > 20, "only {programs} programs");
}

#[test]
fn the_gallery_has_every_surface_and_example() {
    let page = fs::read_to_string(root().join("docs/guide/gallery.md")).unwrap();
    let (surfaces, examples) = (names("src/surfaces", ".html"), names("examples", ".rs"));
    assert!(surfaces.len() >= 40 && examples.len() > 20);
    for name in surfaces {
        assert!(page.contains(&format!("/{name}.webp)")), "{name}: cargo run --release --example gallery");
    }
    for name in examples {
        assert!(page.contains(&format!("| `{name}` |")), "{name}: cargo run --release --example gallery");
    }
}

#[test]
fn every_example_benchmark_and_ignored_test_has_its_command() {
    let page = fs::read_to_string(root().join("docs/guide/examples.md")).unwrap();
    let (examples, flow) = (names("examples", ".rs"), names("rattle-flow/examples", ".rs"));
    assert!(examples.len() > 25 && flow.len() > 1, "{examples:?} {flow:?}");
    let mut missing = Vec::new();
    for name in examples.iter().chain(&flow) {
        if !page.contains(&format!("--example {name}`")) && !page.contains(&format!("--example {name} ")) {
            missing.push(format!("--example {name}"));
        }
    }
    for name in names("benches", ".rs").iter().filter(|name| !["common", "peers"].contains(&name.as_str())) {
        if !page.contains(&format!("--bench {name}")) {
            missing.push(format!("--bench {name}"));
        }
    }
    let mut ignored = 0;
    for file in files(".rs") {
        let mut lines = fs::read_to_string(&file).unwrap();
        lines.retain(|c| c != ' ');
        if !lines.contains("\n#[ignore=") || file.ends_with("killed.rs") {
            continue; // that of `killed` is started by another, which has its row
        }
        ignored += 1;
        let folder = file.parent().unwrap().file_stem().unwrap().to_string_lossy().into_owned();
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let name = if name == "main" { folder } else { name };
        let commands = [format!(" {name}::"), format!("`{name}::"), format!("--test {name} ")];
        if !commands.iter().any(|command| page.contains(command)) {
            missing.push(format!("the ignored test of {}", within_project(&file)));
        }
    }
    assert!(ignored > 15, "only {ignored} files with ignored tests");
    assert!(missing.is_empty(), "docs/guide/examples.md has no row of:\n{}", missing.join("\n"));
}

/// The variants of the enumerations of a file.
fn variants(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let mut inside = false;
    let mut found = Vec::new();
    for line in text.lines() {
        inside = (inside || line.starts_with("pub enum ")) && line != "}";
        let Some(name) =
            line.strip_prefix("    ").filter(|line| inside && line.starts_with(char::is_uppercase))
        else {
            continue;
        };
        found.push(name.split(|c: char| !c.is_alphanumeric()).next().unwrap().to_string());
    }
    found
}

#[test]
fn every_failure_of_a_step_has_its_row() {
    let page = fs::read_to_string(root().join("docs/guide/failures.md")).unwrap();
    // These hold another failure, which has its row.
    let wrappers = ["Surface", "Linked", "Rigid", "Phase", "Method", "Effect"];
    let folder = root().join("rattle-core/src/error/step");
    let mut failures: Vec<String> =
        fs::read_dir(folder).unwrap().flat_map(|entry| variants(&entry.unwrap().path())).collect();
    failures.retain(|name| !wrappers.contains(&name.as_str()));
    assert!(failures.len() > 35, "only {}", failures.len());
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    failures.retain(|name| !rows.iter().any(|row| row.contains(&format!("`{name}`"))));
    assert!(failures.is_empty(), "docs/guide/failures.md has no row of {}", failures.join(", "));
}

/// The words of a line that are paths: files of Rust, Python and the shell, and what lies in a folder `src`.
fn paths_in(line: &str) -> Vec<&str> {
    let part = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
    let words = line.split(|c: char| !part(c)).map(|word| word.trim_matches(['.', '/']));
    let is_path = |word: &&str| {
        let ends = [".rs", ".py", ".sh"].iter().any(|ending| word.ends_with(ending));
        let crates = ["rattle-core/src/", "rattle-symbolic/src/", "rattle-flow/src/", "rattle-macros/src/"];
        word.contains('/') && (ends || crates.iter().any(|folder| word.starts_with(folder)))
    };
    words.filter(is_path).collect()
}

#[test]
fn paths_in_comments_and_pages_are_there() {
    // The file of a method that somebody may write, and one that is written while mutants are looked for.
    let exceptions = ["methods/name.rs", "rattle-core/src/mutant.rs"];
    let endings = [".rs", ".py", ".sh", ".md"];
    let all: Vec<PathBuf> = endings.iter().flat_map(|ending| files(ending)).collect();
    let known: Vec<String> = all.iter().map(|path| format!("/{}", within_project(path))).collect();
    let (mut followed, mut gone) = (0, Vec::new());
    for file in &all {
        for (number, line) in fs::read_to_string(file).unwrap().lines().enumerate() {
            let comment = line.trim_start().starts_with(['/', '#', '"', '*', '|']);
            if !comment && !file.to_string_lossy().ends_with(".md") {
                continue;
            }
            for path in paths_in(line) {
                followed += 1;
                let there = [root(), file.parent().unwrap().into()].iter().any(|at| at.join(path).exists())
                    || known.iter().any(|known| known.ends_with(&format!("/{path}")));
                if !there && !exceptions.contains(&path) {
                    gone.push(format!("{}:{}: {path}", within_project(file), number + 1));
                }
            }
        }
    }
    assert!(followed > 150, "only {followed} paths were found");
    assert!(gone.is_empty(), "nothing is there:\n{}", gone.join("\n"));
}

#[test]
fn prose_is_at_most_120_columns_wide() {
    let mut long = Vec::new();
    let mut lines = 0;
    for (ending, comment) in [(".md", ""), (".rs", "//")] {
        for file in files(ending) {
            if file.file_name().unwrap().to_string_lossy().starts_with("hard-cases") {
                continue; // written by programs, mostly tables
            }
            let text = fs::read_to_string(&file).unwrap();
            let mut fenced = false;
            for (number, line) in text.lines().enumerate() {
                let trimmed = line.trim_start();
                if !trimmed.starts_with(comment) {
                    fenced = false;
                    continue;
                }
                let words = trimmed.trim_start_matches(['/', '!']).trim();
                let fence = words.starts_with("```");
                fenced ^= fence;
                let prose = !fenced && !fence && !words.starts_with(['|', '#']) && words.contains(' ');
                lines += usize::from(prose);
                if prose && line.chars().count() > 120 {
                    long.push(format!("{}:{}", file.display(), number + 1));
                }
            }
        }
    }
    assert!(lines > 5000, "only {lines} lines of prose");
    assert!(long.is_empty(), ".ci/wrap wraps these:\n{}", long.join("\n"));
}

#[test]
fn words_that_people_search_lead_somewhere() {
    let sources: String = files(".rs").iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    let words = [
        "friction", "thermostat", "sample", "uniform", "dt", "joint", "hinge", "motor", "restart",
        "timestep", "noise", "Langevin", "contact", "pendulum",
    ];
    for word in words {
        assert!(sources.contains(&format!("#[doc(alias = \"{word}\")]")), "no page is found by {word}");
    }
}

#[test]
fn mistakes_are_listed_as_the_macros_tell_them() {
    let messages: String =
        files(".stderr").iter().map(|path| fs::read_to_string(path).unwrap()).collect::<Vec<_>>().join("\n");
    let page = fs::read_to_string(root().join("docs/guide/constraints.md")).unwrap();
    let table = page.split("| written | message |").nth(1).unwrap();
    let rows: Vec<_> = table.lines().skip(2).take_while(|line| line.starts_with('|')).collect();
    assert!(rows.len() > 30, "only {} rows", rows.len());
    let mut untold = Vec::new();
    for row in rows {
        // A bar inside of a cell is written `\|`, and … stands for what differs.
        let row = row.replace("\\|", "¦");
        let message = row.split('|').nth(2).unwrap().trim().replace('¦', "|");
        for part in message.split('…').map(str::trim) {
            if !messages.contains(part) {
                untold.push(part.to_string());
            }
        }
    }
    assert!(untold.is_empty(), "no message of the macros has:\n{}", untold.join("\n"));
}
