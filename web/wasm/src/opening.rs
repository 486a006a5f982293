//! Opening of captures: reads them once, for the diagnosis and the trace.

use crate::descriptions::Described;
use crate::file::ChosenFile;
use crate::input::{Input, InputOptions, Next};
use crate::trace::store::{Indexing, Store};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::findings::{Diagnosis, Results, SourceQuality, Thresholds};
use canvass_analyzer::network::Network;
use canvass_device::models::Model;
use canvass_reports::diagnosis::html::{self, Collector};
use canvass_reports::diagnosis::{Advice, Diagnosed, DiagnosisReport, Reading};
use canvass_reports::document::{Form, Report as _, Style};
use canvass_reports::provenance::Provenance;
use canvass_traces::{ChannelId, OpenError, Record};
use std::io;
use std::sync::Arc;

/// The options that the table names. They are the options of the program, so that both tables have the same bytes.
const ADVICE: Advice = Advice {
    findings: ": --verbose shows all, and the page (--format html)",
    rows: ": --verbose shows all",
    bit_rate: " (see --bit-rate)",
};

/// Captures being opened.
pub struct Opening {
    input: Input,
    reading: Reading,
    store: Store,
    damages: u64,
}

/// The opened captures.
pub struct Opened {
    /// The captures, read to their end.
    pub input: Input,
    /// All frames.
    pub store: Store,
    /// The index, which is made after the diagnosis.
    pub indexing: Indexing,
    results: Results,
    collector: Option<Collector>,
    provenance: Provenance,
}

impl Opening {
    /// Begins to read the captures; with `hashes`, computes the hashes of the files.
    ///
    /// # Errors
    /// [`OpenError`] of the first capture that can't be opened.
    pub fn begin(
        files: &[ChosenFile],
        options: &InputOptions,
        described: &[Described],
        hashed: bool,
    ) -> Result<Self, OpenError> {
        let length: u64 = files.iter().map(|file| file.length).sum();
        make_room(Store::room(length));
        let input = Input::open(files, options, hashed)?;
        let mut diagnosis = Diagnosis::new(Thresholds::default());
        diagnosis.offer(Model::candidates());
        each(described, |node, known| diagnosis.describe(node, known));
        let reading = Reading::new(diagnosis, Some(Collector::default()));
        Ok(Self { input, reading, store: Store::new(network(described)), damages: 0 })
    }

    /// Reads the next `records` records; `false` at the end of the captures.
    ///
    /// # Errors
    /// None in practice: the output goes to memory.
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

    /// Adds a record. A frame that contradicts itself is shown, but is no evidence.
    #[inline]
    fn take(&mut self, mut record: Record, proves: bool) -> io::Result<()> {
        self.store.push(&record);
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

    /// Number of frames so far.
    pub const fn frames(&self) -> u64 {
        self.store.len() as u64 + self.store.left_out()
    }

    /// Ends the opening: makes the diagnosis.
    ///
    /// # Errors
    /// As [`Opening::step`].
    pub fn finish(self, mut provenance: Provenance) -> io::Result<Opened> {
        let Self { input, reading, store, .. } = self;
        let captures = input.captures();
        let sources: Vec<_> =
            captures.iter().map(|capture| SourceQuality { name: capture.name, quality: capture.quality }).collect();
        let (results, collector) = reading.finish(input.merge(), &sources)?;
        provenance.files.extend(input.files().iter().map(|(file, seen)| file.used("capture", seen)));
        provenance.add_nodes_of(&results, input.merge().channels());
        drop(captures);
        let indexing = Indexing::new(&store, input.merge().channels().len());
        Ok(Opened { input, store, indexing, results, collector, provenance })
    }
}

/// Requests the needed memory at once. Memory of a page grows in steps of 64 KiB, each of which takes as long as one
/// large step. The memory is not touched, so that the page uses no more than is written.
fn make_room(bytes: u64) {
    let mut room: Vec<u8> = Vec::new();
    // If the memory is not available at once, it is allocated step by step as far as possible.
    let _ = room.try_reserve_exact(usize::try_from(bytes).unwrap_or(0));
    std::hint::black_box(&mut room);
}

/// A network with the described devices.
pub fn network(described: &[Described]) -> Network {
    let mut network = Network::new();
    network.offer(Model::candidates());
    each(described, |node, known| network.describe(node, known));
    network
}

/// Tells which device each node is. A description of fewer nodes is told later, so that it counts.
fn each(described: &[Described], mut describe: impl FnMut(NodeId, Arc<KnownDevice>)) {
    let mut described: Vec<&Described> = described.iter().collect();
    described.sort_by_key(|device| std::cmp::Reverse(device.nodes.len()));
    for device in described {
        device.nodes.iter().for_each(|node| describe(*node, Arc::clone(&device.known)));
    }
}

impl Opened {
    /// The diagnosis in this form: `html` (once), `table`, `json`, `markdown` or `junit`.
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
        let fail_on = Some(canvass_analyzer::findings::Severity::Error);
        let report = DiagnosisReport { diagnosed: &diagnosed, is_verbose: false, advice: ADVICE, fail_on };
        match form {
            "html" => html::render(&diagnosed, self.collector.take().unwrap_or_default(), &mut out)?,
            "json" => report.write(Form::Json, &mut out)?,
            "markdown" => report.write(Form::Markdown, &mut out)?,
            "junit" => report.write(Form::Junit, &mut out)?,
            "table" => report.write(Form::Text(Style::default()), &mut out)?,
            other => return Err(io::Error::other(format!("no form of a diagnosis: {other}"))),
        }
        Ok(out)
    }

    /// Sets the hashes of the captures, which another worker has computed; `None` for an unreadable capture.
    pub fn hashed(&mut self, hashes: &[Option<String>]) {
        let captures = self.provenance.files.iter_mut().filter(|file| file.role == "capture");
        for ((used, (file, _)), hash) in captures.zip(self.input.files()).zip(hashes) {
            used.content = hash.as_ref().map(|hash| (file.length, hash.clone()));
        }
    }

    /// The name of a channel.
    pub fn channel(&self, channel: ChannelId) -> &str {
        self.input.merge().channels().name(channel)
    }

    /// Number of errors, warnings and notes.
    pub fn counts(&self) -> [usize; 3] {
        use canvass_analyzer::findings::Severity::{Error, Info, Warning};
        let count = |wanted| self.results.findings.iter().filter(|finding| finding.severity == wanted).count();
        [Error, Warning, Info].map(count)
    }
}
