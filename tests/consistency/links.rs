//! Every link in our own pages leads somewhere: to a file that exists, and to a heading that it has.

use std::fs;
use std::path::{Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// What a page holds that matters to links.
struct Page {
    links: Vec<String>,
    anchors: Vec<String>,
}

fn read(path: &Path) -> Page {
    let text = fs::read_to_string(path).unwrap();
    let mut page = Page { links: Vec::new(), anchors: Vec::new() };
    let mut heading: Option<String> = None;
    for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => page.anchors.extend(heading.take().map(|title| anchor(&title))),
            Event::Text(text) | Event::Code(text) => {
                if let Some(title) = &mut heading {
                    title.push_str(&text);
                }
            }
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                page.links.push(dest_url.into_string());
            }
            _ => {}
        }
    }
    page
}

/// As GitHub and mdBook make it.
fn anchor(title: &str) -> String {
    let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

fn pages() -> Vec<PathBuf> {
    let root = super::root();
    let mut pages = Vec::new();
    for dir in [root.join("docs"), root.join("rules"), root] {
        let files = fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path());
        pages.extend(files.filter(|path| path.extension().is_some_and(|extension| extension == "md")));
    }
    pages.sort();
    pages
}

#[test]
fn every_link_leads_somewhere() {
    let mut broken = Vec::new();
    let mut checked = 0;
    for path in pages() {
        let page = read(&path);
        for link in page.links.iter().filter(|link| !link.contains("://") && !link.starts_with("mailto:")) {
            checked += 1;
            let (file, fragment) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let whole = target.exists()
                && (fragment.is_empty() || read(&target).anchors.iter().any(|anchor| anchor == fragment));
            if !whole {
                broken.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "links that lead nowhere:\n{}", broken.join("\n"));
    assert!(checked > 10, "only {checked} links were found: does this test still see them?");
}

/// Links to the world that were seen to lead somewhere, with the day.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownLinks {
    checked: toml::value::Datetime,
    /// Pages that a copy of their repository holds.
    files: Vec<String>,
    /// Pull requests and repositories that are known.
    threads: Vec<String>,
    /// Pages of others, of which no copy was at hand.
    others: Vec<String>,
    /// Names that look like links.
    names: Vec<String>,
}

/// The addresses in a text.
fn addresses(text: &str) -> impl Iterator<Item = &str> {
    let starts = text.match_indices("http").map(|(at, _)| at);
    let each = starts.map(|at| {
        let rest = &text[at..];
        let end = rest.find(|c: char| c.is_whitespace() || "\"')>`|\\,{}$".contains(c)).unwrap_or(rest.len());
        rest[..end].trim_end_matches(['.', ';', ':'])
    });
    each.filter(|address| {
        ["http://", "https://"].iter().any(|scheme| address.starts_with(scheme) && address.len() > scheme.len())
    })
}

#[test]
fn links_to_the_world_are_known_to_lead_somewhere() {
    let root = super::root();
    let known: KnownLinks = toml::from_str(&fs::read_to_string(root.join("tests/data/links.toml")).unwrap()).unwrap();
    assert!(known.checked.date.is_some());
    let all: Vec<&String> = [&known.files, &known.threads, &known.others, &known.names].into_iter().flatten().collect();
    let mut files = pages();
    files.push(root.join("src/lanelet/vocabulary/words.toml"));
    let (mut unknown, mut used) = (Vec::new(), std::collections::BTreeSet::new());
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        for address in addresses(&text).filter(|address| !address.starts_with("http://127.0.0.1")) {
            let plain = address.split('#').next().unwrap_or(address);
            match all.iter().find(|known| **known == plain) {
                Some(known) => _ = used.insert((*known).clone()),
                None => unknown.push(format!("{}: {address}", path.display())),
            }
        }
    }
    assert!(
        unknown.is_empty(),
        "links that tests/data/links.toml does not know; follow them, then add them:\n{}",
        unknown.join("\n")
    );
    let idle: Vec<&&String> = all.iter().filter(|known| !used.contains(**known)).collect();
    assert!(idle.is_empty(), "tests/data/links.toml has links that nothing uses: {idle:?}");
}
