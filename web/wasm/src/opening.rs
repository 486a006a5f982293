//! Captures as they are opened: read once, for the diagnosis and the trace.

use crate::descriptions::Described;
use crate::file::ChosenFile;
use crate::input::{Input, InputOptions, Next};
use crate::provenance;
use crate::trace::overview::Overview;
use crate::trace::store::Store;
use canvass_analyzer::findings::{Diagnosis, Results, SourceQuality, Thresholds};
use canvass_analyzer::network::Network;
use canvass_device::models::Model;
use canvass_reports::diagnosis::html::{self, Collector};
use canvass_reports::diagnosis::{self, Diagnosed, Reading, Style};
use canvass_reports::provenance::Provenance;
use canvass_traces::{ChannelId, OpenError, Record};
use std::io;

/// Captures that are being read.
pub struct Opening {
    input: Input,
    reading: Reading,
    network: Network,
    store: Store,
    overview: Overview,
    damages: u64,
}

/// What has come of them.
pub struct Opened {
    /// The captures, read to their end.
    pub input: Input,
    /// All frames.
    pub store: Store,
    /// How many there were over time.
    pub overview: Overview,
    results: Results,
    collector: Option<Collector>,
    provenance: Provenance,
}

impl Opening {
    /// Begins to read them.
    ///
    /// # Errors
    /// [`OpenError`] of the first that can't be opened.
    pub fn begin(files: &[ChosenFile], options: &InputOptions, described: &[Described]) -> Result<Self, OpenError> {
        let input = Input::open(files, options, true)?;
        let mut diagnosis = Diagnosis::new(Thresholds::default());
        diagnosis.offer(Model::candidates());
        for device in described {
            device.nodes.iter().for_each(|node| diagnosis.describe(*node, device.known.clone()));
        }
        let reading = Reading::new(diagnosis, Some(Collector::default()));
        let (store, overview) = Default::default();
        Ok(Self { input, reading, network: network(described), store, overview, damages: 0 })
    }

    /// Reads on: so many records; `false` at the end.
    ///
    /// # Errors
    /// None that happens: nothing is written.
    pub fn step(&mut self, records: usize) -> io::Result<bool> {
        for _ in 0..records {
            match self.input.advance() {
                Some(Next::Record(record)) => self.take(record, true)?,
                Some(Next::Salvaged(record)) => self.take(record, false)?,
                Some(Next::Damage) => {}
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    /// A frame that contradicts itself proves nothing, but is shown.
    #[inline]
    fn take(&mut self, mut record: Record, proves: bool) -> io::Result<()> {
        self.store.push(&record, &self.network, self.input.merge().channels().len());
        let decoded = self.network.handle(&record);
        self.overview.take(record.timestamp, &decoded);
        let captures = self.input.merge();
        if self.damages != self.input.damages() {
            self.damages = self.input.damages();
            self.reading.interrupted(captures)?;
        }
        self.reading.see_channel(record.channel, captures);
        if proves {
            self.reading.record(&mut record, captures)?;
        }
        Ok(())
    }

    /// The captures so far.
    pub const fn input(&self) -> &Input {
        &self.input
    }

    /// How many frames there were so far.
    pub const fn frames(&self) -> u64 {
        self.store.len() as u64 + self.store.left_out()
    }

    /// What was found.
    ///
    /// # Errors
    /// As [`Opening::step`].
    pub fn finish(self, mut provenance: Provenance) -> io::Result<Opened> {
        let Self { input, reading, store, overview, .. } = self;
        let captures = input.captures();
        let sources: Vec<_> =
            captures.iter().map(|capture| SourceQuality { name: capture.name, quality: capture.quality }).collect();
        let (results, collector) = reading.finish(input.merge(), &sources)?;
        provenance.files.extend(input.files().iter().map(|(file, seen)| file.used("capture", seen)));
        provenance.devices = provenance::devices(&results, input.merge().channels());
        drop(captures);
        Ok(Opened { input, store, overview, results, collector, provenance })
    }
}

/// A network that knows the devices described.
pub fn network(described: &[Described]) -> Network {
    let mut network = Network::new();
    network.offer(Model::candidates());
    for device in described {
        device.nodes.iter().for_each(|node| network.describe(*node, device.known.clone()));
    }
    network
}

impl Opened {
    /// The diagnosis in that form: `html` (once), `table`, `json`, `markdown` or `junit`.
    ///
    /// # Errors
    /// If there is no such form.
    pub fn report(&mut self, form: &str) -> io::Result<Vec<u8>> {
        let captures = self.input.captures();
        let diagnosed = Diagnosed {
            results: &self.results,
            channels: self.input.merge().channels(),
            captures: &captures,
            provenance: &self.provenance,
        };
        let mut out = Vec::new();
        match form {
            "html" => html::render(&diagnosed, self.collector.take().unwrap_or_default(), &mut out)?,
            "json" => diagnosis::json(&diagnosed, &mut out)?,
            "markdown" => diagnosis::markdown(&diagnosed, &mut out)?,
            "junit" => {
                diagnosis::junit(&diagnosed, Some(canvass_analyzer::findings::Severity::Error), &mut out)?;
            }
            "table" => diagnosis::table(&diagnosed, Style { color: false, width: None, verbose: false }, &mut out)?,
            other => return Err(io::Error::other(format!("no form of a diagnosis: {other}"))),
        }
        Ok(out)
    }

    /// A channel's name.
    pub fn channel(&self, channel: ChannelId) -> &str {
        self.input.merge().channels().name(channel)
    }

    /// How many errors, warnings and notes were found.
    pub fn counts(&self) -> [usize; 3] {
        use canvass_analyzer::findings::Severity::{Error, Info, Warning};
        let count = |wanted| self.results.findings.iter().filter(|finding| finding.severity == wanted).count();
        [Error, Warning, Info].map(count)
    }
}
