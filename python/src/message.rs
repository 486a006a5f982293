//! Decoded frames as Python objects.

use crate::frame::Frame;
use canvass_analyzer::network::{Bus, Decoded};
use canvass_analyzer::{Meaning, NodeId};
use canvass_tables::messages::pdo;
use canvass_traces::{Channels, Record};
use pyo3::prelude::*;

/// A frame with its meaning.
#[pyclass(frozen, get_all, module = "canvass")]
pub struct Message {
    /// The frame.
    frame: Py<Frame>,
    /// The service, such as `sdo`, `pdo`, `nmt` or `heartbeat`.
    service: &'static str,
    /// The sender; of an SDO request the server, of a command the node that it names.
    node: Option<u8>,
    /// The index of the object that is read or written, or that the message names.
    index: Option<u16>,
    /// The object's sub-index.
    sub: Option<u8>,
    /// The object's name.
    object: Option<String>,
    /// The PDO, such as `TPDO 1`.
    pdo: Option<String>,
    /// The violated rule of the SDO protocol, if the frame violates one.
    violation: Option<&'static str>,
    /// The frame in words.
    meaning: String,
}

impl Message {
    pub fn of(py: Python<'_>, record: &Record, channels: &Channels, decoded: &Decoded, bus: &Bus) -> PyResult<Self> {
        let meaning = Meaning::new(record, decoded, bus);
        Ok(Self {
            frame: Py::new(py, Frame::of(record, channels))?,
            service: decoded.service.name(),
            node: decoded.node.map(NodeId::raw),
            index: decoded.object.map(|object| object.index.0),
            sub: decoded.object.map(|object| object.sub.0),
            object: meaning.object_name().map(|name| name.to_string()),
            pdo: pdo(&decoded.message).map(|pdo| pdo.to_string()),
            violation: decoded.violation.map(|broken| broken.name()),
            meaning: meaning.to_string(),
        })
    }
}

#[pymethods]
impl Message {
    /// The time in seconds, as the capture counts it.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.frame.getattr(py, "time")
    }

    fn __repr__(&self) -> String {
        format!("<Message {} {}>", self.service, self.meaning)
    }
}
