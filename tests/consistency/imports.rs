//! Reads which file of the crate imports which, in whatever way: `crate::`, `super::`, a module's name, nested braces, re-exports,
//! `#[path]`. Tests may import what they like and are left out.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Ident, TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, Macro, MetaList, Path, UsePath, UseTree, Visibility};

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

/// Whether something is compiled for unit tests alone.
fn is_of_tests(attributes: &[Attribute]) -> bool {
    let is_test = |one: &Attribute| {
        one.path().is_ident("cfg") && one.parse_args::<Path>().is_ok_and(|condition| condition.is_ident("test"))
    };
    attributes.iter().any(is_test)
}

/// Walks through a file and notes what it names.
struct Reader<'a> {
    module: &'a Module,
    /// Modules that the file declares and other files define.
    children: BTreeSet<String>,
    /// Modules within the file, from the outermost to the one that is read.
    inner: Vec<String>,
    read: Read,
}

impl Reader<'_> {
    /// A path as the file writes it, from the root of the crate on.
    fn absolute(&self, path: &[String]) -> Option<Module> {
        let here = [&self.module[..], &self.inner[..]].concat();
        let none = BTreeSet::new();
        absolute(&here, path, if self.inner.is_empty() { &self.children } else { &none })
    }

    fn note(&mut self, line: usize, path: &[String], exported: bool) {
        if let Some(path) = self.absolute(path) {
            self.read.named.push(Named { line, path, exported });
        }
    }

    /// The leaves of the tree behind `use`.
    fn leaves(&mut self, tree: &UseTree, prefix: &[String], exported: bool) {
        let with = |name: &Ident| [prefix, &[name.to_string()]].concat();
        let (mut path, name, line) = match tree {
            UseTree::Path(UsePath { ident, tree, .. }) => return self.leaves(tree, &with(ident), exported),
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.leaves(tree, prefix, exported));
            }
            UseTree::Name(name) => (with(&name.ident), None, name.ident.span().start().line),
            UseTree::Rename(rename) => {
                (with(&rename.ident), Some(rename.rename.to_string()), rename.ident.span().start().line)
            }
            UseTree::Glob(glob) => ([prefix, &["*".to_owned()]].concat(), None, glob.star_token.span.start().line),
        };
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let name = name.or_else(|| path.last().cloned());
        let Some((path, name)) = self.absolute(&path).zip(name) else { return };
        if self.inner.is_empty() {
            self.read.names.insert(name, path.clone());
        }
        self.read.named.push(Named { line, path, exported });
    }

    /// Paths among the tokens of a macro or an attribute, which nobody but the macro can parse.
    fn tokens(&mut self, tokens: TokenStream) {
        let (mut path, mut line, mut colons) = (Vec::new(), 0, 0);
        for token in tokens {
            match token {
                TokenTree::Punct(sign) if sign.as_char() == ':' => {
                    colons += 1;
                    continue;
                }
                TokenTree::Ident(word) if colons == 2 && !path.is_empty() => path.push(word.to_string()),
                TokenTree::Ident(word) => {
                    self.noted(&mut path, line);
                    // What begins with `::` is of another crate.
                    if colons != 2 {
                        path.push(word.to_string());
                    }
                    line = word.span().start().line;
                }
                TokenTree::Group(group) => {
                    self.noted(&mut path, line);
                    self.tokens(group.stream());
                }
                _ => self.noted(&mut path, line),
            }
            colons = 0;
        }
        self.noted(&mut path, line);
    }

    /// Notes a path of two names or more, and begins another.
    fn noted(&mut self, path: &mut Vec<String>, line: usize) {
        let path = std::mem::take(path);
        if path.len() > 1 {
            self.note(line, &path, false);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if let Some((_, items)) = item.content.as_ref().filter(|_| !is_of_tests(&item.attrs)) {
            self.inner.push(item.ident.to_string());
            items.iter().for_each(|item| self.visit_item(item));
            self.inner.pop();
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if !is_of_tests(&item.attrs) {
            self.leaves(&item.tree, &[], !matches!(item.vis, Visibility::Inherited));
        }
    }

    fn visit_path(&mut self, path: &'ast Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if let Some(first) = path.segments.first().filter(|_| path.leading_colon.is_none() && names.len() > 1) {
            self.note(first.ident.span().start().line, &names, false);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &'ast Macro) {
        self.visit_path(&called.path);
        self.tokens(called.tokens.clone());
    }

    fn visit_meta_list(&mut self, list: &'ast MetaList) {
        self.visit_path(&list.path);
        self.tokens(list.tokens.clone());
    }
}

/// What a file says that is a module.
fn read(file: &str, module: &Module, text: &str) -> Read {
    let parsed = syn::parse_file(text).unwrap();
    let declared = parsed.items.iter().filter_map(|item| match item {
        Item::Mod(item) if item.content.is_none() => Some(item.ident.to_string()),
        _ => None,
    });
    let read = Read { file: file.to_owned(), ..Read::default() };
    let mut reader = Reader { module, children: declared.collect(), inner: Vec::new(), read };
    reader.visit_file(&parsed);
    reader.read
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
