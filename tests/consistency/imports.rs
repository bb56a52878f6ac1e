//! Reads which file of the crate imports which, in whatever way: `crate::`, `super::`, a module's name, nested braces, re-exports,
//! `#[path]`. Tests may import what they like and are left out.

use std::collections::{BTreeMap, BTreeSet};

/// A module by its names from the root of the crate on, which itself has none.
pub type Module = Vec<String>;

/// Something that a file names.
#[derive(Clone, Debug)]
struct Named {
    line: usize,
    path: Module,
    /// `pub use`.
    exported: bool,
}

/// What one file says.
#[derive(Default)]
struct Read {
    file: String,
    named: Vec<Named>,
    /// What a name stands for that the file imports.
    names: BTreeMap<String, Module>,
}

/// That one file imports another.
#[derive(Clone, Debug)]
pub struct Import {
    /// The importing module.
    pub from: Module,
    /// The module whose file defines what is imported.
    pub to: Module,
    /// How it is named there: what is handed on by a module may be taken from it.
    pub named: Module,
    /// Where.
    pub file: String,
    /// Which line there, from 1 on.
    pub line: usize,
}

impl Import {
    /// For a message.
    pub fn told(&self) -> String {
        format!("{}:{} imports {}", self.file, self.line, self.to.join("::"))
    }
}

/// The text without comments, strings and characters, which become blanks.
fn code(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut i = 0;
    let blank = |out: &mut String, range: &[char]| out.extend(range.iter().map(|&c| if c == '\n' { c } else { ' ' }));
    while i < chars.len() {
        let rest = &chars[i..];
        let begins = |word: &str| rest.iter().copied().take(word.len()).eq(word.chars());
        let hashes = rest.iter().skip(1).take_while(|c| **c == '#').count();
        let raw = rest[0] == 'r' && rest.get(1 + hashes) == Some(&'"') && !out.ends_with(|c: char| c.is_alphanumeric());
        let length = if begins("//") {
            rest.iter().position(|c| *c == '\n').unwrap_or(rest.len())
        } else if raw {
            let end: Vec<char> = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
            let body = &rest[2 + hashes..];
            body.windows(end.len()).position(|w| w == end).map_or(rest.len(), |at| 2 + hashes + at + end.len())
        } else if rest[0] == '"' {
            let mut at = 1;
            while at < rest.len() && rest[at] != '"' {
                at += if rest[at] == '\\' { 2 } else { 1 };
            }
            at + 1
        } else if rest[0] == '\'' && rest.get(1) == Some(&'\\') {
            3 + rest.iter().skip(3).position(|c| *c == '\'').unwrap_or_default()
        } else if rest[0] == '\'' && rest.get(2) == Some(&'\'') {
            3
        } else {
            out.push(rest[0]);
            i += 1;
            continue;
        };
        let end = (i + length).min(chars.len());
        blank(&mut out, &chars[i..end]);
        i = end;
    }
    out
}

/// Words and signs, each with its line; `::` is one sign.
fn tokens(code: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    for (line, text) in code.lines().enumerate() {
        let mut rest = text.trim_start();
        while let Some(first) = rest.chars().next() {
            let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            let length = if word > 0 {
                word
            } else if rest.starts_with("::") {
                2
            } else {
                first.len_utf8()
            };
            found.push((line + 1, rest[..length].to_owned()));
            rest = rest[length..].trim_start();
        }
    }
    found
}

/// The leaves of the tree behind `use`, up to its end: line, path, the name by which it goes.
fn leaves(tokens: &[(usize, String)], at: &mut usize, prefix: &[String], out: &mut Vec<(usize, Module, String)>) {
    let (mut path, mut line, mut name) = (prefix.to_vec(), 0, None);
    while let Some((here, token)) = tokens.get(*at) {
        match token.as_str() {
            "," | "}" | ";" => break,
            "{" => {
                *at += 1;
                while tokens.get(*at).is_some_and(|t| !matches!(t.1.as_str(), "}" | ";")) {
                    leaves(tokens, at, &path, out);
                    *at += usize::from(tokens.get(*at).is_some_and(|t| t.1 == ","));
                }
                *at += 1;
                return;
            }
            "as" => {
                name = tokens.get(*at + 1).map(|t| t.1.clone());
                *at += 1;
            }
            "::" => {}
            word => {
                line = *here;
                path.push(word.to_owned());
            }
        }
        *at += 1;
    }
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    if let Some(name) = name.or_else(|| path.last().cloned()) {
        out.push((line, path, name));
    }
}

/// A path from the root of the crate on; `None` if it leads out of the crate.
fn absolute(module: &[String], path: &[String], children: &BTreeSet<String>) -> Option<Module> {
    let mut from = module.to_vec();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => (from, rest) = (Module::new(), &path[1..]),
        "self" => rest = &path[1..],
        "super" => {}
        child if children.contains(child) => {}
        _ => return None,
    }
    while rest.first().is_some_and(|word| word == "super") {
        from.pop()?;
        rest = &rest[1..];
    }
    from.extend_from_slice(rest);
    Some(from)
}

/// The token behind the brace that closes one which is open at a token.
fn behind_braces(tokens: &[(usize, String)], mut at: usize) -> usize {
    let mut open = 1;
    while open > 0 && at < tokens.len() {
        let word = tokens[at].1.as_str();
        open = if word == "{" { open + 1 } else { open - usize::from(word == "}") };
        at += 1;
    }
    at
}

/// What a file says that is a module.
fn read(file: &str, module: &Module, text: &str) -> Read {
    let tokens = tokens(&code(text));
    let word = |i: usize| tokens.get(i).map_or("", |t| t.1.as_str());
    let children: BTreeSet<String> =
        (0..tokens.len()).filter(|&i| word(i) == "mod" && word(i + 2) == ";").map(|i| word(i + 1).to_owned()).collect();
    let mut read = Read { file: file.to_owned(), ..Read::default() };
    // Modules within the file, each with the depth of braces around it; whether a test follows.
    let (mut inner, mut depth, mut test): (Vec<(String, usize)>, usize, bool) = (Vec::new(), 0, false);
    let mut i = 0;
    while i < tokens.len() {
        let here = || -> Module { module.iter().chain(inner.iter().map(|it| &it.0)).cloned().collect() };
        let own = if inner.is_empty() { children.clone() } else { BTreeSet::new() };
        match word(i) {
            "#" if word(i + 2) == "cfg" && word(i + 4) == "test" && word(i + 5) == ")" => {
                test = true;
                i += 6;
            }
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                inner.retain(|it| it.1 < depth);
            }
            "mod" if word(i + 2) == "{" => {
                if test {
                    i = behind_braces(&tokens, i + 3);
                    test = false;
                    continue;
                }
                inner.push((word(i + 1).to_owned(), depth));
                i += 1;
            }
            // `use<'a>` in a type names lifetimes.
            "use" if word(i + 1) != "<" => {
                let exported = i > 0 && matches!(word(i - 1), "pub" | ")");
                let mut found = Vec::new();
                i += 1;
                leaves(&tokens, &mut i, &[], &mut found);
                for (line, path, name) in found.into_iter().filter(|_| !test) {
                    let Some(path) = absolute(&here(), &path, &own) else { continue };
                    if inner.is_empty() {
                        read.names.insert(name, path.clone());
                    }
                    read.named.push(Named { line, path, exported });
                }
                test = false;
            }
            first if word(i + 1) == "::" && (i == 0 || !matches!(word(i - 1), "::" | ".")) => {
                let (line, mut path) = (tokens[i].0, vec![first.to_owned()]);
                while word(i + 1) == "::" && word(i + 2).starts_with(|c: char| c.is_alphabetic() || c == '_') {
                    path.push(word(i + 2).to_owned());
                    i += 2;
                }
                if let Some(path) = absolute(&here(), &path, &own).filter(|_| !test) {
                    read.named.push(Named { line, path, exported: false });
                }
            }
            ";" => test = false,
            _ => {}
        }
        i += 1;
    }
    read
}

/// The module that a file is by its place, and those that `#[path]` makes of others.
fn modules(files: &[(String, String)]) -> BTreeMap<Module, Read> {
    let by_place = |file: &str| -> Module {
        let parts: Vec<&str> = file.trim_end_matches(".rs").split('/').collect();
        let parts = parts.strip_suffix(&["mod"]).or_else(|| parts.strip_suffix(&["lib"])).unwrap_or(&parts);
        parts.iter().map(|&part| part.to_owned()).collect()
    };
    let mut moved: BTreeMap<String, Module> = BTreeMap::new();
    for (file, text) in files {
        let folder = file.rsplit_once('/').map_or("", |it| it.0);
        for (i, line) in text.lines().enumerate() {
            let Some(other) = line.trim().strip_prefix("#[path = \"").and_then(|rest| rest.strip_suffix("\"]")) else {
                continue;
            };
            let declared =
                text.lines().skip(i + 1).find_map(|line| line.trim().trim_end_matches(';').rsplit_once("mod "));
            let mut place: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
            for part in other.split('/') {
                if part == ".." { place.truncate(place.len().saturating_sub(1)) } else { place.push(part) }
            }
            if let Some((_, name)) = declared {
                moved.insert(place.join("/"), [by_place(file), vec![name.to_owned()]].concat());
            }
        }
    }
    let module = |file: &str| moved.get(file).cloned().unwrap_or_else(|| by_place(file));
    files.iter().map(|(file, text)| (module(file), read(file, &module(file), text))).collect()
}

/// The module whose file defines what a path names: through all re-exports.
fn definer(modules: &BTreeMap<Module, Read>, path: &[String], steps: usize) -> Module {
    let known = (0..=path.len()).rev().find(|&n| modules.contains_key(&path[..n])).unwrap_or_default();
    let (module, rest) = path.split_at(known);
    let through = rest.first().and_then(|name| modules.get(module)?.names.get(name));
    match through.filter(|other| steps > 0 && other[..] != path[..=known]) {
        Some(other) => definer(modules, &[&other[..], &rest[1..]].concat(), steps - 1),
        None => module.to_vec(),
    }
}

/// All imports between files, by their paths from `src` on and their texts. A module that hands on what its own children define
/// does not import them by that. Unit tests (`tests.rs` and what lies in a directory `tests`) may import what they like.
pub fn imports(files: &[(String, String)]) -> Vec<Import> {
    let of_tests = |file: &str| file.ends_with("tests.rs") || file.split('/').any(|part| part == "tests");
    let files: Vec<(String, String)> =
        files.iter().filter(|(file, _)| !of_tests(file) && file != "main.rs").cloned().collect();
    let modules = modules(&files);
    let mut found = Vec::new();
    for (from, read) in &modules {
        for Named { line, path, exported } in &read.named {
            if *exported && path.starts_with(from) {
                continue;
            }
            let to = definer(&modules, path, 16);
            if to != *from {
                found.push(Import {
                    from: from.clone(),
                    to,
                    named: path.clone(),
                    file: format!("src/{}", read.file),
                    line: *line,
                });
            }
        }
    }
    found
}

/// Imports that close a circle, circle by circle.
pub fn circles(imports: &[Import]) -> Vec<Vec<Import>> {
    let mut next: BTreeMap<&Module, BTreeSet<&Module>> = BTreeMap::new();
    for import in imports {
        next.entry(&import.from).or_default().insert(&import.to);
    }
    let reach = |from: &Module| -> BTreeSet<Module> {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(at) = open.pop() {
            open.extend(next.get(at).into_iter().flatten().copied().filter(|to| seen.insert((*to).clone())));
        }
        seen
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> = next.keys().map(|from| (*from, reach(from))).collect();
    let back = |it: &Import| reached.get(&it.to).is_some_and(|seen| seen.contains(&it.from));
    let mut circles: BTreeMap<&BTreeSet<Module>, Vec<Import>> = BTreeMap::new();
    let closing = imports.iter().filter(|it| back(it));
    // Modules of one circle reach the same others.
    closing.for_each(|it| circles.entry(&reached[&it.from]).or_default().push(it.clone()));
    circles.into_values().collect()
}
