//! What CI services run: the hook of pre-commit, the action's cache, the release.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::root;

/// The shell command of the hook that takes the program on the PATH.
fn system_hook() -> String {
    let hooks = fs::read_to_string(root().join(".pre-commit-hooks.yaml")).unwrap();
    let hook = hooks.split("- id: ").find(|hook| hook.starts_with("lanewright-system")).unwrap();
    hook.lines().find_map(|line| line.trim().strip_prefix("entry: ")).unwrap().to_owned()
}

#[test]
fn the_hook_takes_a_file_whose_name_begins_as_an_option_does() {
    let dir = tempfile::tempdir().unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_lanewright")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    for (map, code) in [("vm-03-02/good.osm", 0), ("vm-03-08/bad-lane-node-missing.osm", 1)] {
        let map = root().join("tests/rules").join(map);
        let name = "--fail-on=never-lanelet2_map.osm";
        fs::copy(map, dir.path().join(name)).unwrap();
        let mut hook = Command::new("sh");
        hook.args(["-c", &format!("{} \"$1\"", system_hook()), "hook", name]).env("PATH", &path);
        let run = hook.current_dir(dir.path()).output().unwrap();
        let said = String::from_utf8_lossy(&run.stdout).into_owned() + &String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(code), "{said}");
        assert!(said.contains("finding") || said.contains("error"), "{said}");
    }
}

/// The action's own files, as far as they decide which version it is.
fn action(dir: &Path) {
    for file in ["Cargo.toml", "Cargo.lock", "pyproject.toml", "src/lib.rs", "python/Cargo.toml", "rules/vm-03-08.md"] {
        let to = dir.join(file);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(root().join(file), to).unwrap();
    }
}

fn key(source: &Path, wheel: &str) -> String {
    let script = root().join("scripts/action_version.sh");
    let run = Command::new(script).arg(source).env("WHEEL", wheel).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap()
}

#[test]
fn the_action_s_cache_is_of_one_version() {
    let dir = tempfile::tempdir().unwrap();
    action(dir.path());
    let first = key(dir.path(), "");
    assert_eq!(key(dir.path(), ""), first);
    let mut seen = vec![first];
    let mut another = |key: String| {
        assert!(key.lines().count() == 1 && !seen.contains(&key), "{key} is that of another version");
        seen.push(key);
    };
    fs::write(dir.path().join("src/lib.rs"), "// another version").unwrap();
    another(key(dir.path(), ""));
    fs::write(dir.path().join("rules/vm-03-08.md"), "another rule").unwrap();
    another(key(dir.path(), ""));
    let wheel = dir.path().join("one.whl");
    let at = wheel.to_str().unwrap();
    for content in ["a wheel", "another wheel"] {
        fs::write(&wheel, content).unwrap();
        another(key(dir.path(), at));
    }
    another(key(dir.path(), "https://example.org/lanewright.whl"));
    let action = fs::read_to_string(root().join("action.yml")).unwrap();
    assert!(action.contains("steps.version.outputs.key") && !action.contains("hashFiles(format"));
}

#[test]
fn a_release_runs_the_tests() {
    let workflow = fs::read_to_string(root().join(".github/workflows/release.yml")).unwrap();
    let release = workflow.split("\n  release:\n").nth(1).unwrap();
    let needed = release.lines().find_map(|line| line.trim().strip_prefix("needs: ")).unwrap();
    assert!(needed.contains("test"), "{needed}");
    assert!(
        workflow.split("\n  test:\n").nth(1).unwrap().split("\n  linux:").next().unwrap().contains("run: make test")
    );
}
