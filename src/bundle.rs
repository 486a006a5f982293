//! Bundles: one file with everything about a run, from which the run can be judged again.
//!
//! ```text
//! manifest.json       names, lengths and hashes of the other files
//! result.json         as `canvass test --format json`
//! report.html         the result as a page
//! recording.pcapng    every frame that the tester saw
//! transcript.txt      what the tester saw of the bus besides frames: see `canvass_bus::transcript`
//! run.json            the options and inputs of the run
//! description.eds     the description of the device, if a file describes it
//! waivers.toml        the waivers, if there are any
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

/// Names of the files in a bundle.
pub const RESULT: &str = "result.json";
pub const PAGE: &str = "report.html";
pub const RECORDING: &str = "recording.pcapng";
pub const TRANSCRIPT: &str = "transcript.txt";
pub const WAIVERS: &str = "waivers.toml";

/// A recording that is still being written, for a bundle.
pub struct Frames {
    file: File,
    recording: Recording,
    channels: Channels,
    written: Result<()>,
}

impl Frames {
    /// Begins the recording in a temporary file without a name, which no other program can change.
    pub fn begin() -> Result<Self> {
        let file = tempfile::tempfile().context("can't write a temporary file")?;
        let sink = Box::new(file.try_clone()?);
        let format = Format::by_id("pcapng").context("expected the writer of pcapng among the formats, found none")?;
        let recording = Recording::create(sink, format, Compression::None, &WriteOptions::default())?;
        let mut channels = Channels::default();
        channels.intern("can0");
        Ok(Self { file, recording, channels, written: Ok(()) })
    }

    /// Writes a frame. An error is kept for the end of the recording: the run must not stop for it.
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

/// Everything that goes into a bundle.
pub struct Contents<'a> {
    pub frames: Frames,
    pub transcript: &'a Transcript,
    pub setup: Setup,
    pub result: Vec<u8>,
    pub page: Vec<u8>,
    /// Paths of the device's description and of the waivers.
    pub description: Option<&'a Path>,
    pub waivers: Option<&'a Path>,
}

impl Contents<'_> {
    /// Makes the bytes of the bundle.
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
