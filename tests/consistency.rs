//! What can drift is held here: imports run downward, the rules' table, documents and folders agree, the page of the
//! command line shows what the program says.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must stop")]

#[path = "common/imports.rs"]
mod reader;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// All files under `dir` with this extension, sorted.
fn files(dir: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The table of `docs/architecture.md`: who may import whom. A cell names modules in backquotes or plain, by commas.
fn allowed() -> BTreeMap<String, BTreeSet<String>> {
    let page = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let mut table: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let words = |cell: &str| -> Vec<String> {
        cell.split(',').map(|word| word.trim().trim_matches('`').to_owned()).filter(|word| !word.is_empty()).collect()
    };
    for row in page.lines().skip_while(|l| !l.starts_with("| module |")).skip(2).take_while(|l| l.starts_with('|')) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let modules = words(cells[0]);
        let imports = if cells[1] == "each other" { modules.clone() } else { words(cells[1]) };
        for module in &modules {
            table.insert(module.clone(), imports.iter().cloned().collect());
        }
    }
    table
}

/// The modules of ours that a text names: `crate::x`, and each `x` of `use crate::{x, ...}`. Tests at the end of a file
/// may import what they like.
fn imports(text: &str) -> BTreeSet<String> {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let code: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let word = |s: &str| s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            Some(list) => {
                let list = list.split(';').next().unwrap_or_default();
                let mut depth = 0;
                let mut start = true;
                for (i, c) in list.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' => depth -= 1,
                        ',' if depth == 0 => start = true,
                        c if start && depth == 0 && c.is_alphabetic() => {
                            found.insert(word(&list[i..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
            None => {
                found.insert(word(rest));
            }
        }
    }
    found
}

#[test]
fn imports_run_downward() {
    let allowed = allowed();
    assert!(allowed.len() >= 9, "the table of docs/architecture.md was not found");
    let source = root().join("src");
    let mut faults = Vec::new();
    for path in files(&source, "rs") {
        let relative = path.strip_prefix(&source).unwrap();
        let module = relative.components().next().unwrap().as_os_str().to_string_lossy().replace(".rs", "");
        if ["lib", "main", "cli"].contains(&module.as_str()) || relative.ends_with("tests.rs") {
            continue;
        }
        let Some(may) = allowed.get(&module) else {
            faults.push(format!("{module} is not in the table of docs/architecture.md"));
            continue;
        };
        for import in imports(&fs::read_to_string(&path).unwrap()) {
            if allowed.contains_key(&import) && import != module && !may.contains(&import) {
                faults.push(format!("src/{} imports {import}, which {module} may not", relative.display()));
            }
        }
    }
    assert!(faults.is_empty(), "imports run upward or sideways:\n{}", faults.join("\n"));
}

/// The names of what lies in a directory, without their endings.
fn names(dir: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(root().join(dir)).into_iter().flatten().flatten();
    let stem = |path: PathBuf| path.file_stem().map(|s| s.to_string_lossy().into_owned());
    entries.filter_map(|entry| stem(entry.path())).filter(|name| name != "README").collect()
}

#[test]
fn a_rule_is_one_number_in_three_places() {
    let table = lanewright::rules::table().unwrap();
    let table: BTreeSet<String> = table.iter().map(|row| row.requirement.id.clone()).collect();
    // Not about a map: about the user's settings (src/triage), about two maps (src/report/diff); tests of their own.
    let mut documents = names("rules");
    assert!(documents.remove("triage") && documents.remove("diff") && documents.remove("pictures"));
    assert_eq!(table, documents, "the table of src/rules/mod.rs and the documents of rules/");
    assert_eq!(table, names("tests/rules"), "the table of src/rules/mod.rs and the folders of tests/rules/");
}

#[test]
fn every_file_says_what_it_is() {
    let mut faults = Vec::new();
    for dir in ["src", "tests", "examples", "benches"] {
        for path in files(&root().join(dir), "rs") {
            if !fs::read_to_string(&path).unwrap().starts_with("//!") {
                faults.push(path.strip_prefix(root()).unwrap().display().to_string());
            }
        }
    }
    assert!(faults.is_empty(), "the first line must be `//! what the file is`:\n{}", faults.join("\n"));
}

#[test]
fn imports_are_found() {
    let found = imports("use crate::{a::B, c::{d, E}, f};\nuse crate::g::h;\nfn x() -> crate::i::J {}\n// crate::no\n");
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["a", "c", "f", "g", "i"]);
}

/// The rooms of the builder in the order of the data, as `docs/architecture.md` has them in the first column of a table.
fn rooms() -> Vec<String> {
    let page = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let rows = page.lines().skip_while(|line| !line.starts_with("| room |")).skip(2).take_while(|l| l.starts_with('|'));
    let first =
        |row: &str| row.trim_matches('|').split('|').next().map(|cell| cell.trim().trim_matches('`').to_owned());
    rows.filter_map(first).collect()
}

/// All files of the library, by their paths from `src` on.
fn sources() -> Vec<(String, String)> {
    let source = root().join("src");
    let named = |path: PathBuf| {
        let name = path.strip_prefix(&source).unwrap().to_string_lossy().replace('\\', "/");
        (name, fs::read_to_string(path).unwrap())
    };
    files(&source, "rs").into_iter().map(named).collect()
}

/// What is wrong with imports inside the builder: those of a room that comes later, and those that close a circle of files.
fn builder_faults(files: &[(String, String)], rooms: &[String]) -> Vec<String> {
    let inside = |module: &reader::Module| module.first().is_some_and(|name| name == "builder") && module.len() > 1;
    let imports: Vec<reader::Import> =
        reader::imports(files).into_iter().filter(|it| inside(&it.from) && inside(&it.to)).collect();
    let place = |module: &reader::Module| rooms.iter().position(|room| *room == module[1]);
    let mut faults = Vec::new();
    for import in &imports {
        // What is in no room leads through all of them.
        if let Some(from) = place(&import.from)
            && place(&import.to).is_none_or(|to| to > from)
        {
            faults.push(format!("{}, which comes later", import.told()));
        }
    }
    for circle in reader::circles(&imports) {
        faults.push(format!("a circle: {}", circle.iter().map(reader::Import::told).collect::<Vec<_>>().join("; ")));
    }
    faults
}

#[test]
fn the_builder_imports_only_what_comes_before() {
    let rooms = rooms();
    assert!(rooms.len() >= 12, "the table of rooms of docs/architecture.md was not found");
    for room in &rooms {
        let path = root().join("src/builder").join(room);
        assert!(path.is_dir() || path.with_extension("rs").is_file(), "there is no room {room} in src/builder");
    }
    let faults = builder_faults(&sources(), &rooms);
    assert!(faults.is_empty(), "{} imports of the builder are out of order:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn an_import_out_of_order_is_found_however_it_is_written() {
    let rooms = ["tags".to_owned(), "lanes".to_owned()];
    let told = |planted: &str, other: &str| {
        let files = [
            ("builder/mod.rs", "pub mod tags;\npub mod lanes;\n"),
            ("builder/tags/mod.rs", "pub mod values;\npub use values::Width;\n"),
            ("builder/tags/values.rs", planted),
            ("builder/lanes/mod.rs", "pub mod cut;\npub use cut::Cut;\n"),
            ("builder/lanes/cut.rs", other),
        ];
        let files: Vec<_> = files.iter().map(|(file, text)| ((*file).to_owned(), (*text).to_owned())).collect();
        builder_faults(&files, &rooms)
    };
    let good = "use crate::builder::tags::Width;\npub struct Cut;\n";
    assert_eq!(told("pub struct Width;\n", good), Vec::<String>::new());
    for planted in [
        "use crate::builder::lanes::Cut;\n",
        "use crate::{builder::{lanes::{self, Cut}}};\n",
        "use super::super::lanes::cut::Cut;\n",
        "fn f(_: crate::builder::lanes::Cut) {}\n",
        "fn f() { use super::super::lanes::Cut as Other; }\n",
        "pub use crate::builder::lanes::cut as other;\n",
    ] {
        let faults = told(planted, "pub struct Cut;\n");
        assert!(
            faults.iter().any(|fault| fault.starts_with("src/builder/tags/values.rs:1 imports")),
            "{planted}{faults:?}"
        );
    }
    let circle = "use super::Cut;\npub struct Gap;\n";
    let faults = told("pub struct Width;\n", &format!("{circle}use super::super::lanes;\nfn g(_: lanes::Cut) {{}}\n"));
    assert!(faults.is_empty() || faults.iter().all(|fault| fault.starts_with("a circle")), "{faults:?}");
}
