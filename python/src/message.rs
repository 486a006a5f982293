//! Decoded frames as Python objects.

use crate::frame::Frame;
use canvass_analyzer::network::{Bus, Decoded};
use canvass_analyzer::{Meaning, NodeId};
use canvass_tables::messages::pdo;
use canvass_traces::{Channels, Record};
use pyo3::prelude::*;

/// A frame with its meaning.
#[pyclass(frozen, module = "canvass")]
pub struct Message {
    frame: Py<Frame>,
    service: &'static str,
    node: Option<u8>,
    index: Option<u16>,
    sub: Option<u8>,
    object: Option<String>,
    pdo: Option<String>,
    violation: Option<&'static str>,
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
    /// The frame.
    #[getter]
    fn frame(&self, py: Python<'_>) -> Py<Frame> {
        self.frame.clone_ref(py)
    }

    /// The time in seconds, as the capture counts it.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.frame.getattr(py, "time")
    }

    /// The service, such as `sdo`, `pdo`, `nmt` or `heartbeat`.
    #[getter]
    const fn service(&self) -> &'static str {
        self.service
    }

    /// The node that it concerns: the sender of its own messages, the server of SDOs, the node that a command names.
    #[getter]
    const fn node(&self) -> Option<u8> {
        self.node
    }

    /// The index of the object that it is about.
    #[getter]
    const fn index(&self) -> Option<u16> {
        self.index
    }

    /// The sub-index.
    #[getter]
    const fn sub(&self) -> Option<u8> {
        self.sub
    }

    /// The object's name.
    #[getter]
    fn object(&self) -> Option<&str> {
        self.object.as_deref()
    }

    /// The PDO, such as `TPDO 1`.
    #[getter]
    fn pdo(&self) -> Option<&str> {
        self.pdo.as_deref()
    }

    /// The rule of the SDO protocol that the frame breaks.
    #[getter]
    const fn violation(&self) -> Option<&'static str> {
        self.violation
    }

    /// The frame in words.
    #[getter]
    fn meaning(&self) -> &str {
        &self.meaning
    }

    fn __repr__(&self) -> String {
        format!("<Message {} {}>", self.service, self.meaning)
    }
}
