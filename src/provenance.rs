//! The provenance of a result, gathered here for all commands with reports.

mod adapter;
mod date;
mod files;
mod options;

pub use date::of_file as date_of_file;
pub use files::{Hashes, hash};
pub use options::Typed;

use crate::status::Failure;
use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::NodeId;
use canvass_analyzer::findings::Results;
use canvass_reports::provenance::{BusUsed, Date, FileUsed, Host, Provenance};
use canvass_suite::runner::DeviceIdentity;
use canvass_traces::Channels;
use date::GivenDate;
use std::path::Path;
use std::str::FromStr;

/// The user's additions to a report.
#[derive(clap::Args, Clone, Debug)]
pub struct Remarks {
    /// A note for the reports, such as tester=Ann or firmware=1.4.2; can be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    note: Vec<Note>,
    /// The date for the reports, such as 2026-11-22T14:00:00+01:00, where no live bus is used (default:
    /// `SOURCE_DATE_EPOCH`)
    #[arg(long, value_name = "DATE")]
    date: Option<GivenDate>,
}

/// A value of `--note`: `KEY=VALUE`.
#[derive(Clone, Debug)]
struct Note(String, String);

impl FromStr for Note {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (key, value) = text.split_once('=').context("expected KEY=VALUE, such as tester=Ann")?;
        let is_key = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
        if key.is_empty() || !key.chars().all(is_key) {
            bail!("expected a key of letters, digits, -, _ and ., found \"{key}\"");
        }
        Ok(Self(key.to_owned(), value.to_owned()))
    }
}

/// The subject of a result.
#[derive(Clone, Copy)]
pub enum Subject<'a> {
    /// A device on a live bus; the report has the clock's date.
    LiveBus(&'a str),
    /// A device on a simulated bus; a run gives the same result at any time on any machine.
    SimulatedBus(&'a str),
    Files,
}

impl<'a> Subject<'a> {
    /// A device on the bus with this address.
    pub fn bus(address: &'a str) -> Self {
        if address.starts_with("sim:") { Self::SimulatedBus(address) } else { Self::LiveBus(address) }
    }
}

/// The provenance of a result while the command still collects its parts.
#[derive(Clone, Debug)]
pub struct Collected(pub Provenance);

impl Collected {
    /// Begins the provenance.
    ///
    /// # Errors
    /// If a note is given twice, a date is given for a live bus, or the date is invalid.
    pub fn begin(remarks: &Remarks, typed: &Typed, subject: Subject<'_>) -> Result<Self, Failure> {
        let mut notes: Vec<(String, String)> = Vec::new();
        for Note(key, value) in &remarks.note {
            if notes.iter().any(|(known, _)| known == key) {
                return Err(anyhow!("--note {key} is given twice").into());
            }
            notes.push((key.clone(), value.clone()));
        }
        let bus =
            |address: &str| BusUsed { address: address.to_owned(), adapter: adapter::of(address), bit_rate: None };
        let (bus, host) = match subject {
            Subject::LiveBus(address) => (Some(bus(address)), Some(host())),
            Subject::SimulatedBus(address) => (Some(bus(address)), None),
            Subject::Files => (None, Some(host())),
        };
        let date = date::of(remarks.date.as_ref(), subject)?;
        let options = typed.options.clone();
        let mut collected = Self(Provenance { date, host, bus, options, notes, ..Provenance::default() });
        typed.settings.iter().for_each(|path| collected.file("settings", path));
        Ok(collected)
    }

    /// The day by which waivers and quarantines expire: the report's date, else today.
    pub fn day(&self) -> String {
        let given = self.0.date.as_ref().and_then(|Date { rfc3339, .. }| rfc3339.get(..10));
        given.map_or_else(|| jiff::Zoned::now().date().to_string(), str::to_owned)
    }

    /// Sets the bit rate in bit/s, if it is known.
    pub fn bit_rate(&mut self, bit_rate: Option<u32>) {
        if let Some(bus) = &mut self.0.bus {
            bus.bit_rate = bit_rate;
        }
    }

    /// Adds the identity of a node.
    pub fn node(&mut self, node: NodeId, identity: DeviceIdentity) {
        self.0.devices.push((format!("node {node}"), identity));
    }

    /// Adds the identities of nodes that the captures contain.
    pub fn nodes_of(&mut self, results: &Results, channels: &Channels) {
        self.0.add_nodes_of(results, channels);
    }

    /// Adds the identity of a device under another name than its node-ID.
    pub fn device(&mut self, name: &str, identity: DeviceIdentity) {
        self.0.devices.push((name.to_owned(), identity));
    }

    pub fn seed(&mut self, seed: u64) {
        self.0.seed = Some(seed);
    }

    /// Adds an input file, with its current hash.
    pub fn file(&mut self, role: &'static str, path: &Path) {
        self.0.files.push(files::used(role, path));
    }

    /// Adds files whose hashes are known.
    pub fn files(&mut self, files: Vec<FileUsed>) {
        self.0.files.extend(files);
    }

    /// Adds the files that describe devices (`MODEL`, `FILE` or `NODE=FILE`), and the files of a simulated bus.
    pub fn descriptions<'a>(&mut self, bus: Option<&str>, devices: impl IntoIterator<Item = &'a str>) {
        let files = bus.map(files::of_bus).unwrap_or_default();
        files.iter().for_each(|(role, path)| self.file(role, Path::new(path)));
        let files = devices.into_iter().filter_map(files::of_device);
        files.for_each(|path| self.file("description", Path::new(path)));
    }

    /// Sets the value in force of an option that was absent or incomplete.
    pub fn resolve(&mut self, name: &str, value: Vec<String>) {
        options::resolve(&mut self.0.options, name, value);
    }
}

/// The file that describes the device under test; `None` for a built-in model.
pub fn described_by(bus: &str, device: Option<&str>) -> Option<String> {
    let of_bus = || files::of_bus(bus).into_iter().find(|(role, _)| *role == "description").map(|(_, path)| path);
    match device {
        Some(device) => files::of_device(device).map(str::to_owned),
        None => of_bus(),
    }
}

/// This computer.
fn host() -> Host {
    let read = |path: &str| std::fs::read_to_string(path).ok().map(|text| text.trim().to_owned());
    let named = |variable: &str| std::env::var(variable).ok().filter(|name| !name.is_empty());
    let name = read("/proc/sys/kernel/hostname").or_else(|| named("COMPUTERNAME")).or_else(|| named("HOSTNAME"));
    let release = read("/proc/sys/kernel/osrelease").map(|release| format!(" {release}")).unwrap_or_default();
    Host {
        name: name.unwrap_or_else(|| "this computer has no name".to_owned()),
        system: format!("{}{release} {}", std::env::consts::OS, std::env::consts::ARCH),
    }
}
