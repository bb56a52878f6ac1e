//! What callers say, as the library wants it.

use std::path::PathBuf;

use lanewright::Input;
use lanewright::api::{ConfigSource, Configuration, LayoutOptions};
use lanewright::builder::tags::road_class::DrivingSide;
use lanewright::settings::{Profile, ProjectorType};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyFloat, PyInt, PyList, PyMapping, PyMemoryView, PyString, PyTuple};

/// Any argument whose type is looked at here.
pub type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// Most threads that can be asked for: more is a mistake.
const MOST_THREADS: i64 = 1024;

fn wrong_type(argument: &str, expected: &str, given: Any<'_, '_>) -> PyErr {
    let given = given.get_type().name().map_or_else(|_| "something else".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("{argument}: expected {expected}, not {given}"))
}

/// The bytes of an argument, if it is some.
fn bytes(given: Any<'_, '_>) -> PyResult<Option<Vec<u8>>> {
    if let Ok(bytes) = given.cast::<PyBytes>() {
        return Ok(Some(bytes.as_bytes().to_vec()));
    }
    if given.is_instance_of::<PyByteArray>() || given.is_instance_of::<PyMemoryView>() {
        let copied = given.py().get_type::<PyBytes>().call1((given,))?;
        return Ok(Some(copied.cast::<PyBytes>()?.as_bytes().to_vec()));
    }
    Ok(None)
}

/// A path or bytes; `name` is what messages call bytes.
pub fn input(argument: &str, given: Any<'_, '_>, name: Option<String>) -> PyResult<Input> {
    if let Some(bytes) = bytes(given)? {
        return Ok(Input::bytes(name.unwrap_or_else(|| argument.to_owned()), bytes));
    }
    let path = path(argument, "a path (str or os.PathLike) or bytes", given)?;
    if name.is_some() {
        return Err(PyValueError::new_err("name: is what messages call bytes; a path has a name"));
    }
    Ok(Input::Path(path))
}

fn path(argument: &str, expected: &str, given: Any<'_, '_>) -> PyResult<PathBuf> {
    let path: PathBuf = given.extract().map_err(|_| wrong_type(argument, expected, given))?;
    if path.as_os_str().is_empty() {
        return Err(PyValueError::new_err(format!("{argument}: expected {expected}, not an empty name")));
    }
    Ok(path)
}

/// A path to write to.
pub fn output(given: Option<Any<'_, '_>>) -> PyResult<Option<PathBuf>> {
    given.map(|given| directory("output", given)).transpose()
}

/// How many threads share the work.
pub fn threads(given: Option<Any<'_, '_>>) -> PyResult<Option<usize>> {
    let Some(given) = given else { return Ok(None) };
    if !given.is_instance_of::<PyInt>() || given.is_instance_of::<PyBool>() {
        return Err(wrong_type("threads", "a number of threads (int), or None for one for each processor", given));
    }
    let wrong = || PyValueError::new_err(format!("threads: expected 1 to {MOST_THREADS}, not {given}"));
    let count: i64 = given.extract().map_err(|_| wrong())?;
    usize::try_from(count).ok().filter(|_| (1..=MOST_THREADS).contains(&count)).map(Some).ok_or_else(wrong)
}

/// One of some words.
fn choice<T: Copy>(argument: &str, given: Any<'_, '_>, words: &[(&str, T)]) -> PyResult<T> {
    let named: Vec<String> = words.iter().map(|(word, _)| format!("'{word}'")).collect();
    let expected = format!("one of {}", named.join(", "));
    let word = given.cast::<PyString>().map_err(|_| wrong_type(argument, &expected, given))?.to_cow()?.into_owned();
    let found = words.iter().find(|(one, _)| *one == word);
    found
        .map(|(_, value)| *value)
        .ok_or_else(|| PyValueError::new_err(format!("{argument}: expected {expected}, not '{word}'")))
}

/// The side of the road on which people drive.
pub fn driving_side(given: Option<Any<'_, '_>>) -> PyResult<Option<DrivingSide>> {
    let Some(given) = given else { return Ok(None) };
    let sides = [("left", Some(DrivingSide::Left)), ("right", Some(DrivingSide::Right)), ("auto", None)];
    choice("driving_side", given, &sides)
}

/// The projection of a map.
pub fn projector(given: Option<Any<'_, '_>>) -> PyResult<Option<ProjectorType>> {
    let Some(given) = given else { return Ok(None) };
    let projectors = [
        ("MGRS", ProjectorType::Mgrs),
        ("TransverseMercator", ProjectorType::TransverseMercator),
        ("LocalCartesianUTM", ProjectorType::LocalCartesianUtm),
        ("LocalCartesian", ProjectorType::LocalCartesian),
    ];
    choice("projector", given, &projectors).map(Some)
}

/// Whose reading of the requirements counts.
pub fn profile(given: Option<Any<'_, '_>>) -> PyResult<Option<Profile>> {
    let Some(given) = given else { return Ok(None) };
    choice("profile", given, &[("ours", Profile::Ours), ("tier4", Profile::Tier4)]).map(Some)
}

/// Latitude and longitude of a place on Earth, degrees.
pub fn place((lat, lon): (f64, f64)) -> PyResult<[f64; 2]> {
    if !(-90.0..=90.0).contains(&lat) || !(-180.0..=180.0).contains(&lon) {
        let message = format!("({lat}, {lon}) is not on Earth: latitude -90 to 90 first, then longitude -180 to 180");
        return Err(PyValueError::new_err(message));
    }
    Ok([lat, lon])
}

/// How streets are laid out.
pub fn layout(
    driving_side: Option<Any<'_, '_>>,
    projector: Option<Any<'_, '_>>,
    dem: Option<Any<'_, '_>>,
    profile: Option<Any<'_, '_>>,
    config: Option<Any<'_, '_>>,
    isolated: bool,
) -> PyResult<LayoutOptions> {
    Ok(LayoutOptions {
        driving_side: self::driving_side(driving_side)?,
        projector: self::projector(projector)?,
        dem: dem.map(|given| input("dem", given, None)).transpose()?,
        configuration: Configuration { profile: self::profile(profile)?, ..configuration(config, isolated)? },
        ..LayoutOptions::default()
    })
}

/// A number of metres.
pub fn metres(argument: &str, given: Any<'_, '_>, most: u32) -> PyResult<u32> {
    if !given.is_instance_of::<PyInt>() || given.is_instance_of::<PyBool>() {
        return Err(wrong_type(argument, "whole metres (int)", given));
    }
    let metres: Option<u32> = given.extract().ok();
    metres
        .filter(|metres| (1..=most).contains(metres))
        .ok_or_else(|| PyValueError::new_err(format!("{argument}: expected 1 to {most} m, not {given}")))
}

/// A path that must be given.
pub fn directory(argument: &str, given: Any<'_, '_>) -> PyResult<PathBuf> {
    path(argument, "a path (str or os.PathLike)", given)
}

/// A word, or several in a list or parted by commas.
pub fn words(argument: &str, given: Option<Any<'_, '_>>) -> PyResult<Vec<String>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    if let Ok(text) = given.cast::<PyString>() {
        return Ok(text
            .to_cow()?
            .split(',')
            .map(|word| word.trim().to_owned())
            .filter(|word| !word.is_empty())
            .collect());
    }
    given.extract().map_err(|_| wrong_type(argument, "a str or a list of str", given))
}

/// Files of settings, single settings, or a mapping of them; one, or several in a list, of which the last counts most.
pub fn configuration(config: Option<Any<'_, '_>>, isolated: bool) -> PyResult<Configuration> {
    let sources = match config {
        None => Vec::new(),
        Some(given) if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() => {
            given.try_iter()?.map(|one| source(&one?)).collect::<PyResult<_>>()?
        }
        Some(given) => vec![source(given)?],
    };
    Ok(Configuration { sources, isolated, ..Configuration::default() })
}

fn source(given: Any<'_, '_>) -> PyResult<ConfigSource> {
    if let Ok(text) = given.cast::<PyString>() {
        return Ok(ConfigSource::guess("config", &text.to_cow()?));
    }
    if given.cast::<PyMapping>().is_ok() {
        let text = toml::to_string(&value("config", given)?)
            .map_err(|error| PyValueError::new_err(format!("config: TOML cannot say this: {error}")))?;
        return Ok(ConfigSource::Document { name: "config".to_owned(), text });
    }
    let expected = "a file (str or os.PathLike), 'KEY=VALUE', a mapping, or a list of these";
    Ok(ConfigSource::File(path("config", expected, given)?))
}

/// A value of the settings; `key` is where it stands.
fn value(key: &str, given: Any<'_, '_>) -> PyResult<toml::Value> {
    if given.is_instance_of::<PyBool>() {
        return Ok(toml::Value::Boolean(given.extract()?));
    }
    if given.is_instance_of::<PyInt>() {
        return Ok(toml::Value::Integer(given.extract()?));
    }
    if given.is_instance_of::<PyFloat>() {
        return Ok(toml::Value::Float(given.extract()?));
    }
    if let Ok(text) = given.cast::<PyString>() {
        return Ok(toml::Value::String(text.to_cow()?.into_owned()));
    }
    if let Ok(mapping) = given.cast::<PyMapping>() {
        let mut table = toml::Table::new();
        for item in mapping.items()?.iter() {
            let (name, inner): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let name: String = name.extract().map_err(|_| wrong_type(key, "keys that are str", &name))?;
            let inner = value(&format!("{key}.{name}"), &inner)?;
            table.insert(name, inner);
        }
        return Ok(toml::Value::Table(table));
    }
    if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() {
        let values = given.try_iter()?.map(|one| value(key, &one?)).collect::<PyResult<_>>()?;
        return Ok(toml::Value::Array(values));
    }
    Err(wrong_type(key, "bool, int, float, str, list or mapping", given))
}
