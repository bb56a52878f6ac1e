//! git: merges and shows maps by element and meaning, once a repository is told to.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::config::NAME;
use super::error::{Error, ErrorKind};
use super::files;
use crate::report::failure::Failure;

/// The file that says which files of a repository git treats in a way of their own.
const ATTRIBUTES: &str = ".gitattributes";
/// The files of a repository that are maps, unless somebody says otherwise.
pub const MAPS: &str = "*.osm";

/// What a repository is to be told.
#[derive(Clone, Debug)]
pub struct GitSetup {
    /// The repository's directory.
    pub root: PathBuf,
    /// What is to be done, in order.
    pub steps: Vec<SetupStep>,
}

/// One thing that a repository is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetupStep {
    /// What is told: a key of git's configuration, or a line of `.gitattributes`.
    pub what: SetupKind,
    /// Whether the repository knows it already.
    pub is_done: bool,
}

/// What a repository is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SetupKind {
    /// A key of the repository's own configuration, and its value.
    Config(&'static str, String),
    /// A line of `.gitattributes`.
    Attribute(String),
}

impl GitSetup {
    /// What the repository around a directory lacks so that git merges and shows the maps that match a pattern of
    /// [gitattributes](https://git-scm.com/docs/gitattributes) by element and meaning; whether what git merges is left unchecked.
    ///
    /// # Errors
    ///
    /// Where there is no git, no repository, or no name for this program.
    pub fn plan(dir: &Path, pattern: &str, unchecked: bool) -> Result<Self, Error> {
        Self::planned(dir, pattern, unchecked).map_err(ErrorKind::Read.of())
    }

    fn planned(dir: &Path, pattern: &str, unchecked: bool) -> Result<Self, Failure> {
        if pattern.is_empty() || pattern.contains(char::is_whitespace) || pattern.starts_with(['#', '!', '"']) {
            let failure = Failure::new(format!("`{pattern}` is no pattern of .gitattributes"));
            return Err(failure.help("give one like *.osm, or maps/**/lanelet2_map.osm"));
        }
        let root = PathBuf::from(git(dir, &["rev-parse", "--show-toplevel"])?);
        let program = program()?;
        let unchecked = if unchecked { " --no-check" } else { "" };
        let config = [
            ("merge.lanewright.name", "Lanelet2 maps by element and meaning".to_owned()),
            ("merge.lanewright.driver", format!("{program} merge --base %O %A %B -o %A --path %P{unchecked}")),
            ("diff.lanewright.textconv", format!("{program} git-text")),
            // The line of the element that a change is in stands above it.
            ("diff.lanewright.xfuncname", "^[a-z].*$".to_owned()),
        ];
        let config = config.into_iter().map(|(key, value)| {
            let is_done = git(&root, &["config", "--local", "--get", key]).is_ok_and(|said| said == value);
            SetupStep { what: SetupKind::Config(key, value), is_done }
        });
        let known = attributes(&root)?;
        let lines = [format!("{pattern} merge=lanewright diff=lanewright"), format!("{NAME} merge=lanewright")];
        let lines = lines.into_iter().map(|line| {
            let is_done = known.lines().any(|one| one.split_whitespace().eq(line.split_whitespace()));
            SetupStep { what: SetupKind::Attribute(line), is_done }
        });
        Ok(Self { steps: config.chain(lines).collect(), root })
    }

    /// Does what is not done yet.
    ///
    /// # Errors
    ///
    /// Where `.gitattributes` or the configuration cannot be written; what was done until then can be done again.
    pub fn apply(&self) -> Result<(), Error> {
        self.applied().map_err(ErrorKind::Write.of())
    }

    fn applied(&self) -> Result<(), Failure> {
        let mut text = attributes(&self.root)?;
        let before = text.len();
        for step in self.steps.iter().filter(|step| !step.is_done) {
            match &step.what {
                SetupKind::Config(key, value) => {
                    git(&self.root, &["config", "--local", key, value])?;
                }
                SetupKind::Attribute(line) => {
                    if !text.is_empty() && !text.ends_with('\n') {
                        text.push('\n');
                    }
                    text += line;
                    text.push('\n');
                }
            }
        }
        // Last: an attribute without its driver would mean nothing, and git would not say so.
        if text.len() > before { files::write(&self.root.join(ATTRIBUTES), text.as_bytes()) } else { Ok(()) }
    }
}

/// What `.gitattributes` says; nothing where it is not there.
fn attributes(root: &Path) -> Result<String, Failure> {
    let file = root.join(ATTRIBUTES);
    match fs::read_to_string(&file) {
        Ok(text) => Ok(text),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
        Err(error) => Err(Failure::new(format!("cannot read {}: {error}", file.display()))),
    }
}

/// How a shell calls this program: by its name where that is found, else by its path.
fn program() -> Result<String, Failure> {
    const PROGRAM: &str = "lanewright";
    let own = std::env::current_exe().and_then(|path| path.canonicalize());
    let own = own.map_err(|error| Failure::new(format!("the path of this program is unknown: {error}")))?;
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let file = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let is_found = std::env::split_paths(&paths).any(|folder| folder.join(&file).is_file());
    if is_found {
        return Ok(PROGRAM.to_owned());
    }
    // Shells of git for Windows want slashes.
    let own = own.to_string_lossy().replace('\\', "/");
    Ok(format!("'{}'", own.replace('\'', "'\\''")))
}

/// The `lanewright.toml` beside a map in the versions that git is about to merge into ours, where git says which they are.
pub fn settings_of_theirs(map: &Path) -> Vec<String> {
    const HEADS: [&str; 3] = ["MERGE_HEAD", "CHERRY_PICK_HEAD", "REBASE_HEAD"];
    // `git merge` names what it merges in the environment of whom it calls.
    let named = std::env::vars().filter_map(|(name, _)| Some(name.strip_prefix("GITHEAD_")?.to_owned()));
    let own = git(Path::new("."), &["rev-parse", "--verify", "-q", "HEAD"]).unwrap_or_default();
    let commits = named.filter(|commit| *commit != own).chain(HEADS.map(str::to_owned));
    let file = map.with_file_name(NAME).to_string_lossy().replace('\\', "/");
    commits.filter_map(|commit| git(Path::new("."), &["show", &format!("{commit}:{file}")]).ok()).collect()
}

/// Where the page with the conflicts of a map is put that git merges: in git's own directory, where nobody commits it.
pub fn conflict_page(map: &Path) -> Option<PathBuf> {
    let name = map.to_string_lossy().replace(['/', '\\'], "-");
    git(Path::new("."), &["rev-parse", "--git-path", &format!("lanewright/{name}.html")]).ok().map(PathBuf::from)
}

/// What git says to this, without the line end.
pub(super) fn git(dir: &Path, arguments: &[&str]) -> Result<String, Failure> {
    let said = git_bytes(dir, arguments)?;
    Ok(String::from_utf8_lossy(&said).trim_end_matches(['\n', '\r']).to_owned())
}

/// The same, as it is.
pub(super) fn git_bytes(dir: &Path, arguments: &[&str]) -> Result<Vec<u8>, Failure> {
    let mut command = Command::new("git");
    command.arg("-C").arg(dir).args(arguments).stdin(Stdio::null());
    let output = command.output().map_err(|error| {
        Failure::new(format!("git cannot be run: {error}")).help("install git, and see that `git --version` works")
    })?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    let what = arguments.iter().take(2).copied().collect::<Vec<_>>().join(" ");
    Err(Failure::new(format!("git {what} failed in {}: {said}", dir.display()))
        .help("run this inside a git repository: git init"))
}
