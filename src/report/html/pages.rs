//! Documents of `rules/` as HTML. HTML inside them is shown, never run.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd, html};

use crate::requirement::Requirement;

/// One requirement as an `<article>`, hidden until asked for; with its pictures where they are wanted.
pub fn page(requirement: &Requirement, with_pictures: bool) -> String {
    let Requirement { id, title, subtitle, category, check, source, edition, .. } = requirement;
    let mut out = format!(
        "<article class=\"rule-page\" id=\"rule-{0}\" hidden><header><p class=\"rule-id\">{0}</p><h2>{1}</h2>{2}\
         <p class=\"meta\">{3} · check: {check}</p></header>",
        escape(id),
        escape(title),
        subtitle.as_ref().map(|subtitle| format!("<p>{}</p>", escape(subtitle))).unwrap_or_default(),
        escape(category),
    );
    if let Some(why) = &requirement.why {
        out += &format!("<p class=\"note\">{}</p>", escape(why));
    }
    out += &markdown(&requirement.prose, if with_pictures { &requirement.pictures } else { &[] });
    faults(&mut out, requirement);
    parameters(&mut out, requirement);
    let link = if source.starts_with("https://") || source.starts_with("http://") {
        format!("<a href=\"{0}\" rel=\"noreferrer noopener\" target=\"_blank\">{0}</a>", escape(source))
    } else {
        escape(source)
    };
    out += &format!("<footer>Source: {link} (edition {})</footer></article>\n", escape(edition));
    out
}

fn faults(out: &mut String, requirement: &Requirement) {
    if requirement.faults.is_empty() {
        return;
    }
    *out += "<h3>What is reported</h3><dl class=\"faults\">";
    for (slug, fault) in &requirement.faults {
        let severity = fault.severity;
        *out += &format!(
            "<dt><span class=\"dot {severity}\"></span><code>{}</code></dt><dd>{} <em>{}</em></dd>",
            escape(slug),
            escape(&fault.meaning),
            escape(&fault.help),
        );
    }
    *out += "</dl>";
}

fn parameters(out: &mut String, requirement: &Requirement) {
    if requirement.parameters.is_empty() {
        return;
    }
    *out += "<h3>Parameters</h3><dl class=\"parameters\">";
    for (name, parameter) in &requirement.parameters {
        let unit = if parameter.unit == "1" { "" } else { &parameter.unit };
        *out += &format!(
            "<dt><code>{} = {} {}</code></dt><dd>{}</dd>",
            escape(name),
            escape(&parameter.default.to_string()),
            escape(unit),
            escape(&parameter.meaning),
        );
    }
    *out += "</dl>";
}

/// Markdown as HTML. The document's own title is left out, headings go one level down, HTML becomes text. Pictures that
/// are at hand are put in, of others their words.
fn markdown(text: &str, pictures: &[(String, &str)]) -> String {
    let options = Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH;
    let mut in_title = false;
    let mut picture = None;
    let events = Parser::new_ext(text, options).filter_map(|event| match event {
        Event::Start(Tag::Heading { level: pulldown_cmark::HeadingLevel::H1, .. }) => {
            in_title = true;
            None
        }
        Event::End(TagEnd::Heading(pulldown_cmark::HeadingLevel::H1)) => {
            in_title = false;
            None
        }
        _ if in_title => None,
        Event::Start(Tag::Heading { level, id, classes, attrs }) => {
            Some(Event::Start(Tag::Heading { level: lower(level), id, classes, attrs }))
        }
        Event::End(TagEnd::Heading(level)) => Some(Event::End(TagEnd::Heading(lower(level)))),
        // An alignment would become a style attribute, which the page's policy forbids.
        Event::Start(Tag::Table(_)) => Some(Event::Start(Tag::Table(Vec::new()))),
        Event::Html(html) | Event::InlineHtml(html) => Some(Event::Text(html)),
        Event::Start(Tag::Image { dest_url, .. }) => {
            let named = |(name, _): &&(String, &str)| *dest_url == *format!("pictures/{name}.svg");
            picture = pictures.iter().find(named).map(|(_, svg)| *svg);
            None
        }
        // The words come first; the picture is below them.
        Event::End(TagEnd::Image) => picture.take().map(|svg| {
            let data = STANDARD.encode(svg);
            Event::InlineHtml(format!("<img alt=\"\" src=\"data:image/svg+xml;base64,{data}\">").into())
        }),
        other => Some(other),
    });
    let mut out = String::new();
    html::push_html(&mut out, events);
    out
}

fn lower(level: pulldown_cmark::HeadingLevel) -> pulldown_cmark::HeadingLevel {
    use pulldown_cmark::HeadingLevel::{H2, H3, H4};
    if level <= H2 { H3 } else { H4 }
}

/// Text made safe for an element's content and for attributes in double quotes.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn html_in_a_document_is_text() {
        let out = markdown("# Title\n\n## Why\n\n<script>alert(1)</script>\n\na <b onclick=x>b</b>", &[]);
        assert!(!out.contains("<script") && !out.contains("<b ") && !out.contains("Title"), "{out}");
        assert!(out.contains("<h3>Why</h3>") && out.contains("&lt;script&gt;"), "{out}");
    }

    #[test]
    fn pictures_are_put_in_where_they_are_at_hand() {
        let text = "![Good: so](pictures/x-good.svg)\n";
        let out = markdown(text, &[("x-good".to_owned(), "<svg/>")]);
        assert!(out.contains("Good: so<img alt=\"\" src=\"data:image/svg+xml;base64,PHN2Zy8+\">"), "{out}");
        assert!(!markdown(text, &[]).contains("<img"));
    }

    #[test]
    fn tables_have_no_style_attribute() {
        let out = markdown("|a|b|\n|:-:|-:|\n|1|2|\n", &[]);
        assert!(out.contains("<table>") && !out.contains("style"), "{out}");
    }
}
