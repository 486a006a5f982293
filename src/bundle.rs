//! Bundles: all that there is of a run in one file, from which it can be judged again.
//!
//! ```text
//! manifest.json       the names, lengths and hashes of the others
//! result.json         as `canvass test --format json`
//! report.html         the same for people
//! recording.pcapng    every frame that the tester saw
//! transcript.txt      what else it saw of the bus: see `canvass_bus::transcript`
//! run.json            what the run was made with
//! description.eds     the description of the device, and waivers.toml, where there were any
//! ```

pub mod manifest;
pub mod setup;
pub mod zip;

use anyhow::{Context, Result};
use canvass_bus::transcript::Transcript;
use canvass_traces::small_file::{self, OF_HAND};
use canvass_traces::{Channels, Compression, Format, Record, Recording, WriteOptions, Writer};
use setup::Setup;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;
use zip::Entry;

/// The names in a bundle.
pub const RESULT: &str = "result.json";
pub const PAGE: &str = "report.html";
pub const RECORDING: &str = "recording.pcapng";
pub const TRANSCRIPT: &str = "transcript.txt";
pub const WAIVERS: &str = "waivers.toml";

/// The frames of a run, on their way into a bundle.
pub struct Frames {
    file: File,
    recording: Recording,
    channels: Channels,
    written: Result<()>,
}

impl Frames {
    /// Begins in a file that nobody else sees.
    pub fn begin() -> Result<Self> {
        let file = tempfile::tempfile().context("can't write a temporary file")?;
        let sink = Box::new(file.try_clone()?);
        let format = Format::by_id("pcapng").context("there is no pcapng")?;
        let recording = Recording::create(sink, format, Compression::None, &WriteOptions::default())?;
        let mut channels = Channels::default();
        channels.intern("can0");
        Ok(Self { file, recording, channels, written: Ok(()) })
    }

    /// Takes a frame. What can't be written is reported at the end.
    pub fn take(&mut self, record: &Record) {
        if self.written.is_ok() {
            self.written = self.recording.write(record, &self.channels).map_err(Into::into);
        }
    }

    fn finish(mut self) -> Result<Vec<u8>> {
        self.written?;
        self.recording.finish()?;
        let mut content = Vec::new();
        self.file.rewind()?;
        self.file.read_to_end(&mut content)?;
        Ok(content)
    }
}

/// What goes into a bundle.
pub struct Contents<'a> {
    pub frames: Frames,
    pub transcript: &'a Transcript,
    pub setup: Setup,
    pub result: Vec<u8>,
    pub page: Vec<u8>,
    /// The file that describes the device, and the waivers.
    pub description: Option<&'a Path>,
    pub waivers: Option<&'a Path>,
}

impl Contents<'_> {
    /// The bundle.
    pub fn pack(self) -> Result<Vec<u8>> {
        let read =
            |path: &Path| small_file::read(path, OF_HAND).with_context(|| format!("can't read {}", path.display()));
        let entry = |name: &str, content: Vec<u8>| Entry { name: name.to_owned(), content };
        let mut setup = self.setup;
        let mut entries = vec![
            entry(RESULT, self.result),
            entry(PAGE, self.page),
            entry(RECORDING, self.frames.finish().context("can't record for the bundle")?),
            entry(TRANSCRIPT, self.transcript.to_string().into_bytes()),
        ];
        if let Some(path) = self.description {
            let extension =
                path.extension().map_or_else(|| "eds".to_owned(), |ext| ext.to_string_lossy().to_lowercase());
            let name = format!("description.{extension}");
            entries.push(entry(&name, read(path)?));
            setup.description = Some(name);
        }
        if let Some(path) = self.waivers {
            entries.push(entry(WAIVERS, read(path)?));
            setup.waivers = true;
        }
        entries.push(entry(setup::NAME, setup.text()?.into_bytes()));
        let manifest = manifest::of(&entries)?;
        entries.insert(0, manifest);
        zip::write(&entries)
    }
}
