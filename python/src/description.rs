//! The objects of a device description.

use crate::capture::describe;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// The entries of a built-in model or of a description file: one dictionary each, in the order of index and sub-index.
#[pyfunction]
pub fn objects<'py>(py: Python<'py>, device: &str) -> PyResult<Bound<'py, PyList>> {
    let known = describe(device)?;
    let all = PyList::empty(py);
    for object in known.description.dictionary.objects() {
        for entry in object.entries() {
            let row = PyDict::new(py);
            row.set_item("index", object.index.0)?;
            row.set_item("sub", entry.sub.0)?;
            row.set_item("object", &object.name)?;
            row.set_item("name", &entry.name)?;
            row.set_item("type", entry.data_type.to_string())?;
            row.set_item("access", entry.access.to_string())?;
            row.set_item("pdo", entry.pdo_mappable)?;
            let text = |setting: &Option<canvass_analyzer::dictionary::Setting>| {
                setting.as_ref().map(|setting| setting.to_string())
            };
            row.set_item("default", text(&entry.default))?;
            row.set_item("low", text(&entry.low_limit))?;
            row.set_item("high", text(&entry.high_limit))?;
            row.set_item("value", text(&entry.configured))?;
            all.append(row)?;
        }
    }
    Ok(all)
}
