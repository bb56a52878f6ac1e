//! JSON as Python's own dictionaries and lists.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::{Map, Value};

/// A value as Python's own.
pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Null => Ok(py.None().into_bound(py)),
        Value::Bool(value) => value.into_bound_py_any(py),
        Value::Number(value) => match (value.as_i64(), value.as_u64()) {
            (Some(value), _) => value.into_bound_py_any(py),
            (None, Some(value)) => value.into_bound_py_any(py),
            (None, None) => value.as_f64().into_bound_py_any(py),
        },
        Value::String(value) => value.into_bound_py_any(py),
        Value::Array(values) => list(py, values).map(Bound::into_any),
        Value::Object(members) => dict(py, members).map(Bound::into_any),
    }
}

/// A list.
pub fn list<'py>(py: Python<'py>, values: &[Value]) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for value in values {
        list.append(to_python(py, value)?)?;
    }
    Ok(list)
}

/// A dictionary, its keys in the order of the value's.
pub fn dict<'py>(py: Python<'py>, members: &Map<String, Value>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in members {
        dict.set_item(key, to_python(py, value)?)?;
    }
    Ok(dict)
}

/// A `FeatureCollection` of these features.
pub fn collection<'py, 'a>(
    py: Python<'py>,
    features: impl IntoIterator<Item = &'a Value>,
) -> PyResult<Bound<'py, PyDict>> {
    let list = PyList::empty(py);
    for feature in features {
        list.append(to_python(py, feature)?)?;
    }
    let all = PyDict::new(py);
    all.set_item("type", "FeatureCollection")?;
    all.set_item("features", list)?;
    Ok(all)
}
