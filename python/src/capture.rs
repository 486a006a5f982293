//! Captures: opened again for each use, so that one capture can be read as often as it is needed.

use crate::frame::Frame;
use crate::message::Message;
use crate::stream::{Kind, Table};
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::network::Network;
use canvass_analyzer::{NodeId, NodeRange};
use canvass_device::models::Model;
use canvass_traces::small_file::{self, OF_HAND};
use canvass_traces::{
    CanId, ChannelId, Channels, Damage, Format, Merge, Naming, ReadOptions, Record, SkipSet, Timestamp,
};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Everything that opens a capture.
#[derive(Clone)]
pub struct Origin {
    paths: Vec<PathBuf>,
    options: ReadOptions,
    devices: Vec<(NodeId, Arc<KnownDevice>)>,
    /// The damages of the latest reading, up to [`MOST_DAMAGES`], and their number.
    damages: Arc<Mutex<(Vec<String>, u64)>>,
}

/// Number of damages that are kept as text.
const MOST_DAMAGES: usize = 1000;

/// A capture while it is read.
pub struct Reading {
    merge: Merge,
    skip: SkipSet,
    pub record: Record,
    pub network: Network,
    damages: Arc<Mutex<(Vec<String>, u64)>>,
}

impl Origin {
    /// Opens the files from their beginning.
    pub fn open(&self) -> PyResult<Reading> {
        let open = |path: &PathBuf| {
            canvass_traces::Capture::open(path, &self.options)
                .map_err(|error| PyOSError::new_err(format!("{}: {error}", path.display())))
        };
        let captures = self.paths.iter().map(open).collect::<PyResult<Vec<_>>>()?;
        let mut network = Network::new();
        for (node, device) in &self.devices {
            network.describe(*node, Arc::clone(device));
        }
        network.offer(Model::candidates());
        *self.damages.lock().unwrap_or_else(PoisonError::into_inner) = (Vec::new(), 0);
        Ok(Reading {
            merge: Merge::new(captures, Naming::BySource),
            skip: SkipSet::default(),
            record: Record::new(
                Timestamp(0),
                ChannelId(0),
                canvass_traces::Frame::full(CanId::standard_masked(0), [0; 8]),
            ),
            network,
            damages: Arc::clone(&self.damages),
        })
    }

    /// The name of the capture in tables.
    pub fn name(&self) -> String {
        self.paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
    }
}

impl Reading {
    /// Reads the next frame into `record`; `false` at the end. Damages are noted, and reading goes on.
    pub fn advance(&mut self) -> bool {
        loop {
            match self.merge.next_kept(&mut self.skip, &mut self.record) {
                None => return false,
                Some((_, Ok(()))) => return true,
                Some((source, Err(damage))) => self.note(source, &damage),
            }
        }
    }

    fn note(&self, source: usize, damage: &Damage) {
        let mut damages = self.damages.lock().unwrap_or_else(PoisonError::into_inner);
        damages.1 += 1;
        if damages.0.len() < MOST_DAMAGES {
            damages.0.push(format!("{}:{}: {damage}", self.merge.name(source), damage.place.number));
        }
    }

    pub fn channels(&self) -> &Channels {
        self.merge.channels()
    }
}

/// A capture of any format that canvass reads, or several captures merged by time.
#[pyclass(frozen, module = "canvass")]
pub struct Capture {
    origin: Origin,
}

#[pymethods]
impl Capture {
    /// `paths`: files. `devices`: pairs of nodes (`5`, or `5-8`) and a built-in model or the path of a description.
    /// `format`: the id of the format, if the content does not show it.
    #[new]
    #[pyo3(signature = (paths, devices, format=None))]
    fn new(paths: Vec<PathBuf>, devices: Vec<(String, String)>, format: Option<&str>) -> PyResult<Self> {
        let mut described = Vec::new();
        for (nodes, device) in devices {
            let known = Arc::new(describe(&device)?);
            let nodes = NodeRange::list(&nodes).map_err(|error| PyValueError::new_err(error.to_string()))?;
            described.extend(nodes.into_iter().map(|node| (node, Arc::clone(&known))));
        }
        let format = format.map(by_id).transpose()?;
        let options = ReadOptions { format, ..ReadOptions::default() };
        let origin = Origin { paths, options, devices: described, damages: Arc::default() };
        // A file that is no capture is an error here, not at the first use.
        origin.open()?;
        Ok(Self { origin })
    }

    /// The frames, one after the other.
    fn __iter__(&self) -> PyResult<Frames> {
        Ok(Frames { reading: Mutex::new(self.origin.open()?) })
    }

    /// The decoded frames, one after the other.
    fn decode(&self) -> PyResult<Messages> {
        Ok(Messages { reading: Mutex::new(self.origin.open()?) })
    }

    /// A table for data frames: `frames`, `messages`, `events` or `signals`.
    fn table(&self, name: &str) -> PyResult<Table> {
        let kind = Kind::by_name(name).ok_or_else(|| {
            PyValueError::new_err(format!("expected frames, messages, events or signals, found \"{name}\""))
        })?;
        Ok(Table { kind, origin: self.origin.clone() })
    }

    /// The unreadable parts that the latest reading has met, each with its place: the first 1000.
    #[getter]
    fn damages(&self) -> Vec<String> {
        self.origin.damages.lock().unwrap_or_else(PoisonError::into_inner).0.clone()
    }

    /// The number of unreadable parts that the latest reading has met.
    #[getter]
    fn damage_count(&self) -> u64 {
        self.origin.damages.lock().unwrap_or_else(PoisonError::into_inner).1
    }

    fn __repr__(&self) -> String {
        format!("<Capture {}>", self.origin.name())
    }
}

fn by_id(id: &str) -> PyResult<Format> {
    let known = || Format::all().map(Format::id).collect::<Vec<_>>().join(", ");
    Format::by_id(id).ok_or_else(|| PyValueError::new_err(format!("{id:?} is no format: expected one of {}", known())))
}

/// Reads a built-in model, or the description in a file.
pub fn describe(device: &str) -> PyResult<KnownDevice> {
    if let Some(model) = Model::by_id(device) {
        return Ok(KnownDevice::clone(model.device()));
    }
    read(device).map(KnownDevice::described)
}

/// Reads the description in a file.
pub fn read(path: &str) -> PyResult<DeviceDescription> {
    let bytes = small_file::read(path.as_ref(), OF_HAND).map_err(|error| {
        let models = canvass_analyzer::meant(path, Model::all().iter().map(Model::id));
        PyOSError::new_err(format!("{path} is neither a built-in model nor a readable file{models}: {error}"))
    })?;
    let unusable = |error: String| PyValueError::new_err(format!("{path} is no device description: {error}"));
    let description = DeviceDescription::read(&bytes).map_err(|error| unusable(error.to_string()))?;
    description.usable().map_err(|error| unusable(error.to_string()))?;
    Ok(description)
}

/// The frames of a capture.
#[pyclass(frozen, module = "canvass")]
pub struct Frames {
    reading: Mutex<Reading>,
}

#[pymethods]
impl Frames {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&self) -> Option<Frame> {
        let mut reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let is_there = reading.advance();
        is_there.then(|| Frame::of(&reading.record, reading.channels()))
    }
}

/// The decoded frames of a capture.
#[pyclass(frozen, module = "canvass")]
pub struct Messages {
    reading: Mutex<Reading>,
}

#[pymethods]
impl Messages {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Message>> {
        let mut reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let reading = &mut *reading;
        while reading.advance() {
            let decoded = reading.network.handle(&reading.record);
            let Some(bus) = reading.network.bus(reading.record.channel) else { continue };
            return Message::of(py, &reading.record, reading.merge.channels(), &decoded, bus).map(Some);
        }
        Ok(None)
    }
}
