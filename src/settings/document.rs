//! One `lanewright.toml`, or one `KEY=VALUE` of the command line, as written; and what is wrong with it, with its place.

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Origin, Settings};
use crate::diagnostic::nearest;

/// What is wrong with a document.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct DocumentError {
    /// What is wrong, in one line.
    pub message: String,
    /// A way out, where one is known.
    pub help: Option<String>,
    /// Byte offset in the document.
    pub offset: usize,
}

/// A document with its settings.
#[derive(Clone, Debug)]
pub struct Document {
    /// Its file, or the option of the command line.
    pub name: String,
    /// As written.
    pub text: String,
    /// As read; suppressions know their lines.
    pub settings: Settings,
}

/// One step into a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<'a> {
    /// To the value of a key.
    Key(&'a str),
    /// To an element of a list.
    Index(usize),
}

impl Document {
    /// Reads a document.
    ///
    /// # Errors
    ///
    /// If the text is no TOML, or has an unknown key or a value that cannot be.
    pub fn parse(name: &str, text: &str) -> Result<Self, DocumentError> {
        let settings = toml::from_str(text).map_err(|error| explained(&error))?;
        let mut document = Self { name: name.to_owned(), text: text.to_owned(), settings };
        document.note_lines();
        let broken = document
            .without_id()
            .or_else(|| document.without_road())
            .or_else(|| document.without_origin())
            .or_else(|| document.without_place())
            .or_else(|| document.without_meaning())
            .or_else(|| document.without_sense())
            .or_else(|| document.without_length())
            .or_else(|| document.without_road_or_tags())
            .or_else(|| document.beyond_measure());
        match broken {
            Some(error) => Err(error),
            None => Ok(document),
        }
    }

    /// A merge, or the lack of one, is of some roads.
    fn without_road(&self) -> Option<DocumentError> {
        let lists = [("merge", &self.settings.merge), ("keep_apart", &self.settings.keep_apart)];
        lists.into_iter().find_map(|(key, list)| {
            let (at, fault) = list.iter().enumerate().find_map(|(at, merge)| Some((at, merge.fault()?)))?;
            Some(DocumentError {
                message: format!("[[{key}]]: {fault}"),
                help: Some("name it by `nodes = [1, 2]`, `way = 3`, or `at = [latitude, longitude]`".to_owned()),
                offset: self.offset(&[Step::Key(key), Step::Index(at)]),
            })
        })
    }

    /// Storeys have a height, and ramps lead up.
    fn without_sense(&self) -> Option<DocumentError> {
        let heights = self.settings.heights?;
        let metres = |value: f64| value > 0.0 && value <= 100.0;
        let grade = |value: f64| value > 0.0 && value <= 1.0;
        let faults = [
            ("ground", heights.ground.is_some_and(|v| !v.is_finite()), "a height is a number of metres"),
            ("layer", heights.layer.is_some_and(|v| !metres(v)), "a storey is above 0 and at most 100 metres high"),
            ("grade", heights.grade.is_some_and(|v| !grade(v)), "a grade is above 0 and at most 1"),
            ("steepest", heights.steepest.is_some_and(|v| !grade(v)), "a grade is above 0 and at most 1"),
        ];
        let (key, _, fault) = faults.into_iter().find(|(_, wrong, _)| *wrong)?;
        Some(DocumentError {
            message: format!("[heights] {key}: {fault}"),
            help: Some("metres, and metres per metre: `layer = 6.0`, `grade = 0.06`".to_owned()),
            offset: self.offset(&[Step::Key("heights"), Step::Key(key)]),
        })
    }

    /// Lines are painted over some distance.
    fn without_length(&self) -> Option<DocumentError> {
        let wrong = |metres: f64| !(0.0..=1000.0).contains(&metres);
        self.settings.markings?.before_stop.filter(|metres| wrong(*metres)).map(|_| DocumentError {
            message: "[markings] before_stop: a length is from 0 to 1000 metres".to_owned(),
            help: Some("write `before_stop = 30.0`, or 0 for none".to_owned()),
            offset: self.offset(&[Step::Key("markings"), Step::Key("before_stop")]),
        })
    }

    /// Other tags are those of some way.
    fn without_road_or_tags(&self) -> Option<DocumentError> {
        let (at, fault) = self.settings.road.iter().enumerate().find_map(|(at, road)| Some((at, road.fault()?)))?;
        Some(DocumentError {
            message: format!("[[road]]: {fault}"),
            help: Some("write `ways = [123]` and `tags = { lanes = \"2\" }`".to_owned()),
            offset: self.offset(&[Step::Key("road"), Step::Index(at)]),
        })
    }

    /// What is assumed of roads can be true.
    fn beyond_measure(&self) -> Option<DocumentError> {
        let all = self.settings.assume.iter().enumerate();
        let (at, (key, fault)) = all.into_iter().find_map(|(at, assume)| Some((at, assume.fault()?)))?;
        Some(DocumentError {
            message: format!("[[assume]] {key}: {fault}"),
            help: Some("widths are metres, speeds km/h, `country = \"DE\"`".to_owned()),
            offset: self.offset(&[Step::Key("assume"), Step::Index(at), Step::Key(key)]),
        })
    }

    /// A suppression of no primitive in particular would hide everything or nothing.
    fn without_id(&self) -> Option<DocumentError> {
        let at = self.settings.suppress.iter().position(|suppression| suppression.is_without_id())?;
        Some(DocumentError {
            message: "a suppression needs the id of its primitive".to_owned(),
            help: Some("add `id = 123`, or `id = [123, 124]` for several".to_owned()),
            offset: self.offset(&[Step::Key("suppress"), Step::Index(at)]),
        })
    }

    /// Most projectors mean nothing without an origin.
    fn without_origin(&self) -> Option<DocumentError> {
        let Settings { projector, origin, .. } = &self.settings;
        let error = |key, message: &str, help: &str| DocumentError {
            message: message.to_owned(),
            help: Some(help.to_owned()),
            offset: self.offset(&[Step::Key(key)]),
        };
        if let Some([lat, lon]) = origin
            && !is_place(*lat, *lon)
        {
            return Some(error("origin", "origin is not a latitude and a longitude", "write `origin = [35.2, 138.8]`"));
        }
        match (projector.is_some_and(super::ProjectorType::needs_origin), origin) {
            (true, None) => {
                Some(error("projector", "this projector needs an origin", "add `origin = [latitude, longitude]`"))
            }
            (false, Some(_)) => {
                Some(error("origin", "no projector here has an origin", "say which with `projector = \"...\"`"))
            }
            _ => None,
        }
    }

    /// What is known of an intersection that nobody can find would be lost in silence.
    fn without_place(&self) -> Option<DocumentError> {
        let nowhere = |one: &super::IntersectionSettings| match (one.ia, one.at) {
            (None, None) => Some("an intersection needs the id of its area or a place inside it"),
            (_, Some([lat, lon])) if !is_place(lat, lon) => Some("`at` is not a latitude and a longitude"),
            _ => None,
        };
        let (at, message) =
            self.settings.intersection.iter().enumerate().find_map(|(at, one)| Some((at, nowhere(one)?)))?;
        Some(DocumentError {
            message: message.to_owned(),
            help: Some("add `ia = 123` or `at = [latitude, longitude]`".to_owned()),
            offset: self.offset(&[Step::Key("intersection"), Step::Index(at)]),
        })
    }

    /// What is to be drawn inside an intersection can be drawn.
    fn without_meaning(&self) -> Option<DocumentError> {
        let all = self.settings.intersection.iter().enumerate();
        let (at, (key, index, fault)) = all.into_iter().find_map(|(at, one)| Some((at, one.fault()?)))?;
        let help = match key {
            "virtual_lights" => {
                "write `virtual_lights = [{ approach = \"S\", start = 30.0, tags = { section = \"7\" } }]`"
            }
            "stop_lines" => "write `stop_lines = [[[35.68101, 139.76701], [35.68103, 139.76703]]]`",
            _ => "write `guide_lines = [[[35.68101, 139.76701], [35.68103, 139.76703]]]`, or the id of a way",
        };
        Some(DocumentError {
            message: format!("{key}: {fault}"),
            help: Some(help.to_owned()),
            offset: self.offset(&[Step::Key("intersection"), Step::Index(at), Step::Key(key), Step::Index(index)]),
        })
    }

    /// Notes the position of each suppression, road, merge and intersection.
    fn note_lines(&mut self) {
        #[derive(Default, Deserialize)]
        #[serde(default)]
        struct Places {
            suppress: Vec<Spanned<toml::Value>>,
            merge: Vec<Spanned<toml::Value>>,
            keep_apart: Vec<Spanned<toml::Value>>,
            intersection: Vec<Spanned<toml::Value>>,
            road: Vec<Spanned<toml::Value>>,
        }
        let Ok(places) = toml::from_str::<Places>(&self.text) else { return };
        let ends: Vec<usize> = self.text.match_indices('\n').map(|(at, _)| at).collect();
        let origin = |place: &Spanned<toml::Value>| {
            let line = ends.partition_point(|end| *end < place.span().start) + 1;
            Some(Origin { file: self.name.clone(), line })
        };
        for (suppression, place) in self.settings.suppress.iter_mut().zip(&places.suppress) {
            suppression.origin = origin(place);
        }
        for (intersection, place) in self.settings.intersection.iter_mut().zip(&places.intersection) {
            intersection.origin = origin(place);
        }
        for (road, place) in self.settings.road.iter_mut().zip(&places.road) {
            road.origin = origin(place);
        }
        let merges = self.settings.merge.iter_mut().zip(&places.merge);
        for (merge, place) in merges.chain(self.settings.keep_apart.iter_mut().zip(&places.keep_apart)) {
            merge.origin = origin(place);
        }
    }

    /// Byte offset of what a path leads to; 0 if it leads nowhere.
    pub fn offset(&self, path: &[Step<'_>]) -> usize {
        DeTable::parse(&self.text).ok().and_then(|table| offset_in(table.get_ref(), path)).unwrap_or_default()
    }
}

fn is_place(lat: f64, lon: f64) -> bool {
    lat.abs() <= 90.0 && lon.abs() <= 180.0
}

fn offset_in(table: &DeTable<'_>, path: &[Step<'_>]) -> Option<usize> {
    let (&Step::Key(first), rest) = path.split_first()? else { return None };
    let (key, value) = table.iter().find(|(key, _)| key.get_ref() == first)?;
    match (value.get_ref(), rest) {
        (_, []) => Some(key.span().start),
        (DeValue::Table(inner), _) => offset_in(inner, rest),
        (DeValue::Array(list), [Step::Index(at), rest @ ..]) => {
            let element = list.get(*at)?;
            match element.get_ref() {
                DeValue::Table(inner) if !rest.is_empty() => offset_in(inner, rest),
                _ => Some(element.span().start),
            }
        }
        _ => None,
    }
}

/// The parser's message in our words, where it is about a word that it does not know.
fn explained(error: &toml::de::Error) -> DocumentError {
    let message = error.message();
    let offset = error.span().map_or(0, |span| span.start);
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((&said, known)) = quoted.split_first() else {
        return DocumentError { message: message.to_owned(), help: None, offset };
    };
    let what = if message.starts_with("unknown field") {
        "key"
    } else if message.starts_with("unknown variant") {
        "word"
    } else {
        return DocumentError { message: message.to_owned(), help: None, offset };
    };
    let help = match nearest(said, known.iter().copied()) {
        Some(word) => format!("did you mean `{word}`?"),
        None => format!("known are {}", known.join(", ")),
    };
    DocumentError { message: format!("unknown {what} `{said}`"), help: Some(help), offset }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> DocumentError {
        Document::parse("a.toml", text).unwrap_err()
    }

    #[test]
    fn an_unknown_key_is_named_with_its_place_and_the_nearest_known() {
        let found = error("ignore = []\nselct = [\"vm-03\"]\n");
        assert_eq!(found.message, "unknown key `selct`");
        assert_eq!(found.help.as_deref(), Some("did you mean `select`?"));
        assert_eq!(found.offset, 12);
        assert_eq!(
            error("[[suppress]]\ncode = \"a/b\"\nprimitiv = \"map\"\n").help.as_deref(),
            Some("did you mean `primitive`?")
        );
        assert_eq!(error("[severity]\n\"vm-03\" = \"eror\"\n").help.as_deref(), Some("did you mean `error`?"));
        assert!(error("zzzzzz = 1\n").help.unwrap().contains("driving_side"));
        assert!(error("select = \"vm-03\"\n").message.contains("expected a sequence"));
    }

    #[test]
    fn what_is_known_of_an_intersection_has_keys_and_a_place() {
        let text = "[[intersection]]\nia = 1\n[[intersection]]\nia = 2\nphase = [[\"N\"]]\n";
        let found = error(text);
        assert_eq!((found.message.as_str(), found.offset), ("unknown key `phase`", text.find("phase").unwrap()));
        assert_eq!(found.help.as_deref(), Some("did you mean `phases`?"));
        let text = "[[intersection]]\nia = 1\n[[intersection]]\nphases = []\n";
        let found = error(text);
        assert!(found.message.contains("needs the id of its area"), "{found}");
        assert_eq!(found.offset, text.rfind("[[intersection]]").unwrap());
        assert!(error("[[intersection]]\nat = [135.0, 35.0]\n").message.contains("latitude"));
    }

    #[test]
    fn a_projector_has_its_origin() {
        let text = "driving_side = \"left\"\nprojector = \"TransverseMercator\"\n";
        let found = error(text);
        assert_eq!(
            (found.message.as_str(), found.offset),
            ("this projector needs an origin", text.find("projector").unwrap())
        );
        assert!(error("projector = \"MGRS\"\norigin = [35.0, 139.0]\n").message.contains("no projector here"));
        assert!(error("projector = \"LocalCartesian\"\norigin = [135.0, 39.0]\n").message.contains("latitude"));
        assert_eq!(error("projector = \"mgrs\"\n").help.as_deref(), Some("did you mean `MGRS`?"));
        let good = Document::parse("a.toml", "projector = \"LocalCartesian\"\norigin = [35.0, 139.0]\n").unwrap();
        assert_eq!(good.settings.origin, Some([35.0, 139.0]));
    }

    #[test]
    fn a_marking_has_a_length() {
        let text = "driving_side = \"left\"\n[markings]\nbefore_stop = -1\n";
        let found = error(text);
        assert!(found.message.contains("0 to 1000 metres"), "{found}");
        assert_eq!(found.offset, text.find("before_stop").unwrap());
    }

    #[test]
    fn roads_are_named_and_what_is_assumed_can_be_true() {
        assert!(error("[[road]]\ntags = { lanes = \"2\" }\n").message.contains("names no way"));
        assert!(error("[[road]]\nways = [1]\n").message.contains("has no tags"));
        assert!(error("[[road]]\nways = [1]\nshared_paths = true\n").message.contains("not both"));
        assert!(Document::parse("a.toml", "[[road]]\nshared_paths = true\n").is_ok());
        for (text, said) in [
            ("lane_width = 30", "2 to 6 metres"),
            ("sidewalk_width = 0", "0.3 to 8 metres"),
            ("lanes = 0", "1 to 24 lanes"),
            ("speed = inf", "1 to 300 km/h"),
            ("country = \"Germany\"", "two letters"),
        ] {
            let text = format!("[[assume]]\nlanes = 1\n[[assume]]\n{text}\n");
            let found = error(&text);
            assert!(found.message.contains(said), "{found}");
            let key = text.lines().last().and_then(|line| line.split(' ').next()).unwrap();
            assert!(text[found.offset..].starts_with(key) && found.offset > 20, "{found}");
        }
        assert_eq!(error("[[assume]]\nhighway = [\"primry\"]\n").help.as_deref(), Some("did you mean `primary`?"));
    }

    #[test]
    fn a_suppression_knows_its_line() {
        let text = "\n[[suppress]]\ncode = \"a/b\"\nprimitive = \"map\"\n\n[[suppress]]\ncode = \"a/c\"\nprimitive = \"lanelet\"\nid = [1, 2]\n";
        let document = Document::parse("a.toml", text).unwrap();
        let lines: Vec<usize> =
            document.settings.suppress.iter().filter_map(|one| Some(one.origin.as_ref()?.line)).collect();
        assert_eq!(lines, [2, 6]);
    }

    #[test]
    fn a_path_leads_to_its_place() {
        let text = "select = [\"a\", \"b\"]\n[parameters.vm-03-08]\nspike = 2\n";
        let document = Document::parse("a.toml", text).unwrap();
        assert_eq!(document.offset(&[Step::Key("select"), Step::Index(1)]), text.find("\"b\"").unwrap());
        let spike = [Step::Key("parameters"), Step::Key("vm-03-08"), Step::Key("spike")];
        assert_eq!(document.offset(&spike), text.find("spike").unwrap());
        assert_eq!(document.offset(&[Step::Key("nowhere")]), 0);
    }
}
