//! What must agree within the project: imports run downward; the table, the documents and the folders of the rules match; links lead
//! somewhere.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must stop")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

mod imports;
mod links;

use imports::{Import, circles, imports};

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

/// The rows of a table of `docs/architecture.md`, by the begin of its heading; cells without their backquotes.
fn table(heading: &str) -> Vec<Vec<Vec<String>>> {
    let page = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let words = |cell: &str| -> Vec<String> {
        cell.split(',').map(|word| word.trim().trim_matches('`').to_owned()).filter(|word| !word.is_empty()).collect()
    };
    let rows = page.lines().skip_while(|line| !line.starts_with(heading)).skip(2).take_while(|l| l.starts_with('|'));
    rows.map(|row| row.trim_matches('|').split('|').map(words).collect()).collect()
}

/// Who may import whom.
fn layers() -> BTreeMap<String, BTreeSet<String>> {
    let mut allowed = BTreeMap::new();
    for cells in table("| module |") {
        allowed.extend(cells[0].iter().map(|module| (module.clone(), cells[1].iter().cloned().collect())));
    }
    allowed
}

/// The stages of the builder in their order.
fn stages() -> Vec<String> {
    table("| stage |").into_iter().filter_map(|cells| cells.into_iter().next()?.into_iter().next()).collect()
}

/// All files of `src`, by their paths from there on.
fn sources() -> Vec<(String, String)> {
    let source = root().join("src");
    let name = |path: &Path| path.strip_prefix(&source).unwrap().to_string_lossy().into_owned();
    files(&source, "rs").iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect()
}

/// Imports that a layer of the crate may not have.
fn across_layers(imports: &[Import], allowed: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let mut faults = Vec::new();
    for import in imports {
        let [Some(from), Some(to)] = [import.from.first(), import.named.first()] else { continue };
        match allowed.get(from) {
            _ if from == to || from == "cli" => {}
            Some(may) if may.contains(to) => {}
            Some(_) => faults.push(format!("{}, which {from} may not", import.told())),
            None => faults.push(format!("{}: {from} is not in the table of docs/architecture.md", import.told())),
        }
    }
    faults
}

/// Imports of a later stage of the builder.
fn up_the_stages(imports: &[Import], stages: &[String]) -> Vec<String> {
    let stage = |module: &[String]| -> Option<String> {
        (module.len() > 1 && module[0] == "builder").then(|| module[1].clone())
    };
    let place = |stage: &String| stages.iter().position(|other| other == stage);
    let mut faults = Vec::new();
    for import in imports {
        let [Some(from), Some(to)] = [stage(&import.from), stage(&import.to)] else { continue };
        match [place(&from), place(&to)] {
            [Some(own), Some(other)] if own >= other => {}
            [Some(_), Some(_)] => faults.push(format!("{}, a later stage than {from}", import.told())),
            _ => faults.push(format!("{}: no row of docs/architecture.md for one of them", import.told())),
        }
    }
    faults
}

#[test]
fn imports_run_downward() {
    let (allowed, imports) = (layers(), imports(&sources()));
    assert!(allowed.len() >= 9, "the table of docs/architecture.md was not found");
    let faults = across_layers(&imports, &allowed);
    assert!(faults.is_empty(), "imports run upward or sideways:\n{}", faults.join("\n"));
}

#[test]
fn the_builder_s_stages_import_only_those_before_them() {
    let (stages, sources) = (stages(), sources());
    let there: BTreeSet<String> = names("src/builder").into_iter().filter(|it| it != "mod" && it != "tests").collect();
    assert_eq!(there, stages.iter().cloned().collect(), "src/builder and the table of docs/architecture.md");
    let faults = up_the_stages(&imports(&sources), &stages);
    assert!(faults.is_empty(), "stages import later ones:\n{}", faults.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let told = |circle: &Vec<Import>| circle.iter().map(Import::told).collect::<Vec<_>>().join("\n");
    let faults: Vec<String> = circles(&imports(&sources())).iter().map(told).collect();
    assert!(faults.is_empty(), "files import each other in circles:\n{}", faults.join("\n\n"));
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
    // Not about a map: about the user's settings (src/triage), about two maps (src/report/diff, src/api/conflicts.rs); tests of their own.
    let mut documents = names("rules");
    assert!(["triage", "diff", "merge", "pictures"].iter().all(|other| documents.remove(*other)));
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

/// Files of a small crate.
fn crate_of(files: &[(&str, &str)]) -> Vec<Import> {
    let files: Vec<_> = files.iter().map(|(file, text)| ((*file).to_owned(), (*text).to_owned())).collect();
    imports(&files)
}

/// What a file imports that lies at `builder/b/own.rs`, by the lines.
fn found(own: &str) -> Vec<(usize, String)> {
    let root = "pub mod a;\npub mod b;\npub mod c;\n";
    let others = [
        ("builder/mod.rs", root),
        ("builder/a.rs", ""),
        ("builder/b/mod.rs", "mod own;\nmod low;\npub use low::Low;\n"),
    ];
    let more =
        [("builder/b/low.rs", ""), ("builder/c/mod.rs", "mod deep;\npub use deep::Deep;\n"), ("builder/c/deep.rs", "")];
    let imports = crate_of(&[&others[..], &more[..], &[("builder/b/own.rs", own), ("parallel.rs", "")]].concat());
    let own = imports.into_iter().filter(|it| it.file == "src/builder/b/own.rs");
    let mut found: Vec<_> = own.map(|it| (it.line, it.to.join("::"))).collect();
    found.sort();
    found
}

#[test]
fn every_form_of_import_is_recognised() {
    let is = |own: &str, expected: &[(usize, &str)]| {
        let expected: Vec<_> = expected.iter().map(|(line, to)| (*line, (*to).to_owned())).collect();
        assert_eq!(found(own), expected, "{own}");
    };
    is("use crate::builder::a::A;\n", &[(1, "builder::a")]);
    is("\nuse super::super::c::X as Y;\n", &[(2, "builder::c")]);
    is(
        "use super::{\n    low,\n    super::{a::{self, B}, c::deep::D},\n};\n",
        &[(2, "builder::b::low"), (3, "builder::a"), (3, "builder::a"), (3, "builder::c::deep")],
    );
    is("use crate::builder::c::Deep;\nuse super::Low;\n", &[(1, "builder::c::deep"), (2, "builder::b::low")]);
    is("pub use crate::builder::c::Deep;\n", &[(1, "builder::c::deep")]);
    is("fn f(c: char) -> bool { c == '\"' || super::super::c::g(\"x\") }\n", &[(1, "builder::c")]);
    is(
        "mod inner {\n    use super::super::low::L;\n}\nuse super::low::L;\n",
        &[(2, "builder::b::low"), (4, "builder::b::low")],
    );
    is("fn f() { crate::parallel::g(); }\n", &[(1, "parallel")]);
    is(
        "// use crate::builder::c;\nconst A: &str = \"crate::builder::c\";\nconst B: &str = r#\"crate::builder::c \" \"#;\n",
        &[],
    );
    is("use std::fmt;\n#[cfg(test)]\nmod tests {\n    use crate::builder::c::X;\n}\n", &[]);
    is("#[cfg(test)]\nuse crate::builder::c::X;\nuse crate::builder::a::A;\n", &[(3, "builder::a")]);
    let imports = crate_of(&[("a.rs", "#[path = \"other/b.rs\"]\nmod b;\n"), ("other/b.rs", "use super::X;\n")]);
    assert_eq!(imports.iter().map(Import::told).collect::<Vec<_>>(), ["src/other/b.rs:1 imports a"]);
}

#[test]
fn wrong_imports_are_reported() {
    let stages = ["a", "b", "c"].map(str::to_owned);
    let up = |own: &str| {
        let files = [("builder/mod.rs", ""), ("builder/a.rs", ""), ("builder/b/own.rs", own), ("builder/c/mod.rs", "")];
        up_the_stages(&crate_of(&files), &stages)
    };
    assert_eq!(up("use crate::builder::a::A;\n"), [""; 0]);
    for own in [
        "use crate::builder::c::C;",
        "use super::super::c::C;",
        "pub use super::super::{a::A, c::C};",
        "fn f() { super::super::c::g() }",
    ] {
        assert_eq!(
            up(&format!("\n{own}\n")),
            ["src/builder/b/own.rs:2 imports builder::c, a later stage than b"],
            "{own}"
        );
    }
    let layers =
        BTreeMap::from([("low".to_owned(), BTreeSet::new()), ("high".to_owned(), BTreeSet::from(["low".to_owned()]))]);
    let imports = crate_of(&[("low.rs", "use super::high::X;\n"), ("high.rs", "use crate::low;\n")]);
    assert_eq!(across_layers(&imports, &layers), ["src/low.rs:1 imports high, which low may not"]);
    let told = |files: &[(&str, &str)]| circles(&crate_of(files)).concat().iter().map(Import::told).collect::<Vec<_>>();
    let pair = [
        ("a/mod.rs", "mod x;\nmod y;\npub use x::X;\npub use y::Y;\n"),
        ("a/x.rs", "use super::Y;\n"),
        ("a/y.rs", "fn f() { super::x::g() }\n"),
    ];
    assert_eq!(told(&pair), ["src/a/x.rs:1 imports a::y", "src/a/y.rs:1 imports a::x"], "through a re-export");
    let child = [("a/mod.rs", "mod x;\nfn f() { x::g() }\n"), ("a/x.rs", "use super::T;\n")];
    assert_eq!(told(&child), ["src/a/mod.rs:2 imports a::x", "src/a/x.rs:1 imports a"], "parent and child");
    assert_eq!(told(&[pair[0], pair[1], ("a/y.rs", "")]), [""; 0], "to hand on is no import");
}

/// Who writes to a terminal: one module; and that which puts an output on standard output where it is asked to.
const WRITERS: [&str; 2] = ["cli/output.rs", "api/files/step.rs"];
/// Who may hand bytes to it as they are: formats of `report`, which show no foreign text as it is, and completions.
const RAW: [&str; 6] =
    ["cli/check.rs", "cli/diff.rs", "cli/packaging.rs", "cli/planner.rs", "cli/stats.rs", "cli/tier4.rs"];

/// Foreign text goes to a terminal through `cli/output.rs`, which shows what would steer it.
#[test]
fn no_output_goes_around_the_one_that_shows_foreign_text() {
    let mut faults = Vec::new();
    for (name, text) in sources() {
        let code: String = text.split("#[cfg(test)]").next().unwrap_or_default().to_owned();
        for (at, line) in code.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//")) {
            let mut told = |why: &str| faults.push(format!("src/{name}:{}: {why}: {}", at + 1, line.trim()));
            let prints = ["println!(", "print!(", "io::stdout", "io::stderr"];
            if !WRITERS.contains(&name.as_str()) && prints.iter().any(|way| line.contains(way)) {
                told("output::print and output::complain write to terminals");
            }
            if !RAW.contains(&name.as_str()) && !WRITERS.contains(&name.as_str()) && line.contains("print_with(") {
                told("output::print shows foreign text");
            }
        }
        // A file's name can have several lines: in a line of output it is shown by output::shown.
        if name.starts_with("cli/") {
            let statements = code.split([';', '{', '}']).collect::<Vec<_>>().join(" ; ");
            for statement in statements.split(" ; ").filter(|part| part.contains(".display()")) {
                if ["output::print", "output::tell", "output::complain"].iter().any(|way| statement.contains(way)) {
                    faults.push(format!("src/{name}: output::shown shows a path: {}", statement.trim()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "output that goes around cli/output.rs:\n{}", faults.join("\n"));
}
