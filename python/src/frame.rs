//! Frames as Python objects.

use canvass_traces::{Channels, Direction, Record};
use pyo3::prelude::*;

/// A frame of a capture or a bus.
#[pyclass(frozen, get_all, module = "canvass")]
pub struct Frame {
    /// The time in nanoseconds, exactly.
    time_ns: u64,
    /// The channel's name, such as `can0`.
    channel: String,
    /// The CAN-ID, 11 or 29 bits.
    can_id: u32,
    /// Whether the CAN-ID has 29 bits.
    is_extended: bool,
    /// Whether it is a remote frame.
    is_remote: bool,
    /// Whether it is an error frame.
    is_error: bool,
    /// Whether it is a CAN FD frame.
    is_fd: bool,
    /// `rx`, `tx`, or `None` if the capture does not say it.
    direction: Option<&'static str>,
    /// The number of bytes; of a remote frame the number that it asks for.
    length: usize,
    /// The payload.
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

    fn __repr__(&self) -> String {
        let width = if self.is_extended { 8 } else { 3 };
        let data = canvass_traces::hex::compact(&self.data);
        format!("<Frame {:.6} {} {:0width$X}#{data}>", self.time(), self.channel, self.can_id)
    }
}
