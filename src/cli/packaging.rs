//! `completions` and `man`: what packagers and shells want, made from the arguments themselves.

use std::path::Path;

use crate::report::failure::Failure;
use clap::Command;
use clap_complete::Shell;

use super::args::CLEAN;
use super::output;
use crate::api::files;

/// Prints the completions of one shell.
pub fn completions(shell: Shell, mut command: Command) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, "lanewright", &mut script);
    output::print_with(|out| out.write_all(&script))?;
    Ok(CLEAN)
}

/// Writes one page for the program and one for each verb into a directory.
pub fn man(dir: &Path, command: Command) -> Result<u8, Failure> {
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let verbs = command.get_subcommands().map(|verb| (format!("lanewright-{}", verb.get_name()), verb.clone()));
    let mut pages: Vec<(String, Vec<u8>)> = Vec::new();
    for (name, page) in std::iter::once(("lanewright".to_owned(), command.clone())).chain(verbs) {
        let mut text = Vec::new();
        let failed = |error| Failure::new(format!("cannot make the page {name}: {error}"));
        clap_mangen::Man::new(page).title(name.to_uppercase()).render(&mut text).map_err(failed)?;
        pages.push((format!("{name}.1"), text));
    }
    let drafts: Vec<(&str, &[u8])> = pages.iter().map(|(name, text)| (name.as_str(), text.as_slice())).collect();
    files::publish(dir, &drafts)?;
    output::print(&format!("{}: {} pages\n", output::shown(dir), pages.len()))?;
    Ok(CLEAN)
}
