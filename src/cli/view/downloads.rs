//! The edits as files to download: the input with them, and the lines of `lanewright.toml`.

use crate::diagnostic::{Edit, Fix, Subject};
use crate::fix;
use crate::osm::{MetaInfo, OsmData, OsmText, moved, read_bytes};
use crate::projection::LonLat;
use crate::settings::Settings;

use super::edits::Question;
use super::server::Answer;

/// The input with the edits of nodes and tags; nothing else in its text changes.
pub fn osm(data: &OsmData, title: &str, question: &Question) -> Result<Answer, String> {
    let text = match data.sources.as_slice() {
        [source] if !source.text.is_empty() => {
            edited(data, question).ok_or("the edits do not fit the text of the input; was it changed?")?
        }
        _ => {
            let mut data = data.clone();
            question.apply(&mut data).map_err(|failure| failure.to_string())?;
            written(&data)
        }
    };
    let stem = [".osm.pbf", ".osm.gz", ".osm", ".pbf"].iter().find_map(|end| title.strip_suffix(end)).unwrap_or(title);
    Ok(Answer { bytes: text.into_bytes(), name: Some(format!("{stem}_edited.osm")) })
}

/// The lines of `lanewright.toml` that decide about roads as the edits do.
pub fn toml(question: &Question) -> Result<Answer, String> {
    let mut settings = Settings::default();
    for (said, merge) in question.merges() {
        if merge { settings.merge.push(said) } else { settings.keep_apart.push(said) }
    }
    let text = toml::to_string(&settings).map_err(|error| error.to_string())?;
    Ok(Answer { bytes: text.into_bytes(), name: Some("lanewright.toml".to_owned()) })
}

fn edited(data: &OsmData, question: &Question) -> Option<String> {
    let edits = question.tags().into_iter().filter_map(|((way, key), value)| {
        let on = Subject::Way(way);
        match value {
            Some(value) => Some(Edit::SetTag { on, key: key.into(), value: value.into() }),
            None => data.way(way)?.tags.has(key).then(|| Edit::RemoveTag { on, key: key.into() }),
        }
    });
    let edits: Vec<Edit> = edits.collect();
    let moves: Vec<(i64, LonLat)> = question.moves().into_iter().collect();
    if edits.is_empty() {
        return moved(data, &moves);
    }
    let text = fix::edited(data, &Fix { title: String::new(), safe: false, edits })?.into_iter().next()?;
    let mut tagged = OsmData::default();
    read_bytes(&mut tagged, "edited", text.into_bytes()).ok()?;
    moved(&tagged, &moves)
}

/// The whole as OpenStreetMap XML, for an input that is no text.
fn written(data: &OsmData) -> String {
    let mut text = OsmText::default();
    for node in &data.nodes {
        text.node(node.id, node.position, node.tags.iter());
    }
    for way in &data.ways {
        text.way(way.id, way.nodes.iter().copied(), way.tags.iter());
    }
    for relation in &data.relations {
        let members = relation.members.iter().map(|member| (member.kind, member.id, member.role.as_str()));
        text.relation(relation.id, members, relation.tags.iter());
    }
    let parts = [OsmText::head(&MetaInfo::default()), text, OsmText::tail()];
    parts.iter().map(|part| String::from_utf8_lossy(part.as_bytes()).into_owned()).collect()
}
