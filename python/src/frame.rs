//! Frames as Python objects.

use canvass_traces::{Channels, Direction, Record};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// A frame of a capture or a bus.
#[pyclass(frozen, module = "canvass")]
pub struct Frame {
    time_ns: u64,
    channel: String,
    can_id: u32,
    is_extended: bool,
    is_remote: bool,
    is_error: bool,
    is_fd: bool,
    direction: Option<&'static str>,
    length: usize,
    data: Vec<u8>,
}

impl Frame {
    pub fn of(record: &Record, channels: &Channels) -> Self {
        let frame = &record.frame;
        Self {
            time_ns: record.timestamp.nanos(),
            channel: channels.name(record.channel).to_owned(),
            can_id: frame.id().raw(),
            is_extended: frame.id().is_extended() && !frame.is_error(),
            is_remote: frame.is_remote(),
            is_error: frame.is_error(),
            is_fd: frame.is_fd(),
            direction: match record.direction {
                Direction::Unknown => None,
                Direction::Rx => Some("rx"),
                Direction::Tx => Some("tx"),
            },
            length: frame.len(),
            data: record.data().to_vec(),
        }
    }
}

#[pymethods]
impl Frame {
    /// The time in seconds, as the capture counts it.
    #[getter]
    fn time(&self) -> f64 {
        self.time_ns as f64 / 1e9
    }

    /// The time in nanoseconds, exactly.
    #[getter]
    const fn time_ns(&self) -> u64 {
        self.time_ns
    }

    /// The channel's name, such as `can0`.
    #[getter]
    fn channel(&self) -> &str {
        &self.channel
    }

    /// The CAN-ID, 11 or 29 bits.
    #[getter]
    const fn can_id(&self) -> u32 {
        self.can_id
    }

    /// Whether the CAN-ID has 29 bits.
    #[getter]
    const fn is_extended(&self) -> bool {
        self.is_extended
    }

    /// Whether it is a remote frame.
    #[getter]
    const fn is_remote(&self) -> bool {
        self.is_remote
    }

    /// Whether it is an error frame.
    #[getter]
    const fn is_error(&self) -> bool {
        self.is_error
    }

    /// Whether it is a CAN FD frame.
    #[getter]
    const fn is_fd(&self) -> bool {
        self.is_fd
    }

    /// `rx`, `tx`, or `None` if the capture does not say it.
    #[getter]
    const fn direction(&self) -> Option<&'static str> {
        self.direction
    }

    /// The number of bytes; of a remote frame the number that it asks for.
    #[getter]
    const fn length(&self) -> usize {
        self.length
    }

    /// The payload.
    #[getter]
    fn data<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.data)
    }

    fn __repr__(&self) -> String {
        let width = if self.is_extended { 8 } else { 3 };
        let data = canvass_traces::hex::compact(&self.data);
        format!("<Frame {:.6} {} {:0width$X}#{data}>", self.time(), self.channel, self.can_id)
    }
}
