//! The page of all tags and roles that Lanelet2 and Autoware know, `docs/tags.md`.

use std::fmt::Write;

use crate::lanelet::vocabulary::{Form, Key, On, Words, words};

/// The page, as the table behind the rule `tag` has it.
pub fn known_words() -> String {
    let Some(words) = words() else { return String::new() };
    let mut text = String::from(
        "# Tags that are known\n\n\
         What Lanelet2 and Autoware read in a map, and where that stands; the rule [tag](../rules/tag.md) tells of what is nearly one of\n\
         these words, or means the same, and is none. Other tags may stand in a map. This page is written from `src/lanelet/vocabulary/words.toml` by\n\
         `make rules`.\n\n\
         ## Keys\n\n\
         `…` stands for a participant: ",
    );
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}.\n`LAMP` stands for {}. `ID` stands for the id of a lanelet.\n\n| key | of | value | meaning | source |\n|---|---|---|---|---|",
        quoted(&words.participants.words),
        quoted(&words.lamps.words)
    );
    for key in &words.key {
        let of: Vec<&str> = key.on.iter().map(|on| name(*on)).collect();
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} |",
            key.name,
            of.join(", "),
            value(key),
            key.meaning,
            link(words, &key.source)
        );
    }
    text += "\n## Types and subtypes\n\n| of | type | subtype | source |\n|---|---|---|---|\n";
    for list in &words.types {
        let of: Vec<&str> = list.on.iter().map(|on| name(*on)).collect();
        let subtypes = list.subtypes.as_ref().unwrap_or(&words.paint.words);
        let subtypes = if subtypes.is_empty() { "any".to_owned() } else { quoted(subtypes) };
        let _ = writeln!(
            text,
            "| {} | {} | {subtypes} | {} |",
            of.join(", "),
            quoted(&list.names),
            link(words, &list.source)
        );
    }
    text += "\n## Roles of members\n\n| of | role | source |\n|---|---|---|\n";
    for roles in &words.roles {
        let _ = writeln!(text, "| `{}` | {} | {} |", roles.of, quoted(&roles.words), link(words, &roles.source));
    }
    text += "\n## Words of earlier versions\n\n| of | word | today | source |\n|---|---|---|---|\n";
    for old in &words.renamed {
        let of: Vec<&str> = old.on.iter().map(|on| name(*on)).collect();
        let word = old.value.as_ref().map_or_else(|| old.key.clone(), |value| format!("{}={value}", old.key));
        let _ = writeln!(text, "| {} | `{word}` | `{}` | {} |", of.join(", "), old.now, link(words, &old.source));
    }
    other_words(&mut text, words);
    text += "\n## Sources\n\n";
    for source in words.sources.values() {
        let _ = writeln!(text, "* [{}]({})", source.title, source.url);
    }
    text
}

/// Adds what people write in place of known words.
fn other_words(text: &mut String, words: &Words) {
    *text += "\n## Other words\n\nWhat people write in place of a known word. Of a part of a word, any of a group stands for the others:\n\n";
    for group in &words.alike.words {
        let _ = writeln!(text, "* {}", quoted(group));
    }
    *text += "\n| known | others |\n|---|---|\n";
    for one in &words.meant {
        let _ = writeln!(text, "| `{}` | {} |", one.word, quoted(&one.said));
    }
}

fn quoted(words: &[String]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

fn name(on: On) -> &'static str {
    match on {
        On::Point => "node",
        On::LineString => "way",
        On::Polygon => "way with `area=yes`",
        On::Lanelet => "lanelet",
        On::Element => "regulatory element",
        On::Area => "area",
    }
}

fn value(key: &Key) -> String {
    let quoted = key.values.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ");
    match key.form {
        Some(Form::YesNo) => "`yes`, `no`".to_owned(),
        Some(Form::YesNoAlone) => "`yes`, `no`, no other".to_owned(),
        Some(form) => form.as_str().to_owned(),
        None if key.values.is_empty() => "text".to_owned(),
        None if key.closed => format!("{quoted}, no other"),
        None => quoted,
    }
}

fn link(words: &Words, source: &str) -> String {
    words.sources.get(source).map_or_else(String::new, |source| format!("[{}]({})", source.title, source.url))
}
