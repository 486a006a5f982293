//! The provenance of a result: the facts that a reader needs to trust the result and to repeat the run.
//!
//! All reports of `test`, `fuzz`, `diagnose` and `compare` share this type, and each format shows all of it.

mod json;

pub use json::json;

use crate::document::{Block, Depth, Fact, Section};
use crate::page_text::packed;
use canvass_analyzer::findings::Results;
use canvass_analyzer::statistics::IdentityText;
use canvass_suite::runner::DeviceIdentity;
use canvass_traces::Channels;

/// The version of canvass.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The provenance of a result. Texts come from the user, files and devices, and may contain any characters.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Provenance {
    /// The date of the run; none for a simulated bus if the user gave no date.
    pub date: Option<Date>,
    /// The computer on which canvass ran; none if only a simulated bus was used.
    pub host: Option<Host>,
    /// The bus that was used; none if canvass read files.
    pub bus: Option<BusUsed>,
    /// The identities of the devices as the devices report them, each with the name of the device: `node 63`.
    pub devices: Vec<(String, DeviceIdentity)>,
    /// The seed of all random choices.
    pub seed: Option<u64>,
    /// The files that were read, and the recording.
    pub files: Vec<FileUsed>,
    /// All options that affect the result.
    pub options: Vec<Choice>,
    /// Notes of the user.
    pub notes: Vec<(String, String)>,
}

/// A date and time with its zone.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Date {
    /// The date and time in the notation of RFC 3339: `2026-11-22T14:00:00+01:00`.
    pub rfc3339: String,
    /// The name of the zone: `Europe/Berlin`, or `UTC`.
    pub zone: String,
}

/// The computer on which canvass ran.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Host {
    pub name: String,
    /// The operating system, with its version if it is known.
    pub system: String,
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BusUsed {
    /// The address of the bus, as the user gave it.
    pub address: String,
    /// The adapter that connects this computer to the bus.
    pub adapter: String,
    /// The bit rate in bit/s, if it is known.
    pub bit_rate: Option<u32>,
}

/// A file that the result depends on, or that belongs to it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FileUsed {
    /// The role of the file: `description`, `waivers`, `recording`, `capture`.
    pub role: &'static str,
    /// The path of the file, as the user gave it.
    pub path: String,
    /// The length in bytes and the SHA-256 in hexadecimal. `None` if the file can be read only once, such as a pipe.
    pub content: Option<(u64, String)>,
}

/// An option and its value.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Choice {
    /// The name of the option, without hyphens.
    pub name: String,
    /// The values in effect. Empty if none was given and there is no default.
    pub value: Vec<String>,
    /// The default values.
    pub default: Vec<String>,
    /// The source of the value.
    pub by: ChosenBy,
}

/// The source of an option's value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ChosenBy {
    /// The default of the option.
    Default,
    /// The user on the command line.
    CommandLine,
    /// An environment variable.
    Environment,
    /// A settings file.
    Settings,
}

impl ChosenBy {
    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::CommandLine => "command-line",
            Self::Environment => "environment",
            Self::Settings => "settings",
        }
    }
}

impl Provenance {
    /// Adds the identities that nodes reported in captures, if a master asked for them.
    pub fn add_nodes_of(&mut self, results: &Results, channels: &Channels) {
        for (channel, bus) in &results.buses {
            for (node, figures) in &bus.nodes {
                let identity = identity_of(&figures.identity);
                if identity != DeviceIdentity::default() {
                    self.devices.push((format!("node {node} on {}", channels.name(*channel)), identity));
                }
            }
        }
    }

    /// The provenance as a section. Unless `are_all_options`, only the options that were chosen are included.
    pub(crate) fn section(&self, depth: Depth, are_all_options: bool) -> Section {
        let (mut facts, mut settings) = (self.facts(), self.settings());
        if !are_all_options {
            settings.truncate(self.options.iter().filter(|choice| choice.by != ChosenBy::Default).count());
        }
        let mut blocks = Vec::new();
        match depth {
            Depth::Screen => facts.extend(lines(&settings)),
            Depth::Paper | Depth::Print => {
                facts.extend(settings.into_iter().map(|(name, value)| (format!("option {name}"), value)));
            }
            Depth::Page if settings.is_empty() => {}
            Depth::Page => blocks.push(Block::fold("Options", vec![Block::Facts(settings)])),
        }
        blocks.insert(0, Block::Facts(facts));
        Section { id: "about", title: "About this report".to_owned(), blocks }
    }

    /// The provenance for JUnit files: names that programs can look for, and values.
    pub(crate) fn properties(&self) -> Vec<(String, String)> {
        let facts =
            self.facts().into_iter().map(|(name, value)| (format!("canvass.{}", name.replace(' ', ".")), value));
        let settings = self.settings().into_iter().map(|(name, value)| (format!("canvass.option.{name}"), value));
        facts.chain(settings).collect()
    }

    /// The provenance without options, as names and values for people.
    fn facts(&self) -> Vec<Fact> {
        let mut facts = vec![("canvass".to_owned(), VERSION.to_owned())];
        let mut add = |name: &str, value: String| facts.push((name.to_owned(), value));
        match &self.date {
            Some(Date { rfc3339, zone }) => add("date", format!("{rfc3339} ({zone})")),
            None => add("date", "not given, as the bus is simulated".to_owned()),
        }
        if let Some(Host { name, system }) = &self.host {
            add("host", format!("{name}, {system}"));
        }
        if let Some(BusUsed { address, adapter, bit_rate }) = &self.bus {
            let rate = bit_rate.map(|rate| format!(", {} kbit/s", f64::from(rate) / 1_000.0)).unwrap_or_default();
            add("bus", format!("{address} ({adapter}){rate}"));
        }
        for (name, identity) in &self.devices {
            add(name, identity_text(identity));
        }
        if let Some(seed) = self.seed {
            add("seed", seed.to_string());
        }
        for FileUsed { role, path, content } in &self.files {
            match content {
                Some((bytes, sha256)) => add(role, format!("{path}, {bytes} bytes, SHA-256 {sha256}")),
                None => add(role, format!("{path}, which can't be read twice: no hash")),
            }
        }
        for (key, value) in &self.notes {
            add(&format!("note {key}"), value.clone());
        }
        facts
    }

    /// The options with their values. The chosen options come first.
    fn settings(&self) -> Vec<Fact> {
        let shown = |choice: &Choice| {
            let or_none = |values: &[String]| if values.is_empty() { "-".to_owned() } else { values.join(", ") };
            let value = or_none(&choice.value);
            let told = match choice.by {
                ChosenBy::Default => value,
                _ => format!("{value} (default {})", or_none(&choice.default)),
            };
            (choice.name.clone(), told)
        };
        let (usual, chosen): (Vec<&Choice>, _) = self.options.iter().partition(|choice| choice.by == ChosenBy::Default);
        chosen.into_iter().chain(usual).map(shown).collect()
    }
}

/// The options in lines, each with as many options as fit. Only the first line has a name.
fn lines(settings: &[Fact]) -> impl Iterator<Item = Fact> {
    /// Maximum width of a line in columns.
    const WIDTH: usize = 110;
    let settings: Vec<String> = settings.iter().map(|(name, value)| format!("{name}: {value}")).collect();
    let lines = packed(&settings, ";", WIDTH).into_iter().enumerate();
    lines.map(|(at, line)| (if at == 0 { "options" } else { "" }.to_owned(), line))
}

/// The identity that a node reported in a capture.
pub(crate) fn identity_of(text: &IdentityText) -> DeviceIdentity {
    DeviceIdentity { device_type: text.device_type, identity: text.numbers, names: text.names.clone() }
}

/// The parts of a device's identity, each with its name.
pub(crate) fn identity_facts(identity: &DeviceIdentity) -> [(&'static str, Option<String>); 8] {
    let hex = |number: Option<u32>| number.map(|number| format!("{number:08X}h"));
    let [name, hardware, software] = identity.names.clone();
    let [vendor, product, revision, serial] = identity.identity.map(hex);
    [
        ("name", name),
        ("hardware", hardware),
        ("software", software),
        ("device type", hex(identity.device_type)),
        ("vendor-ID", vendor),
        ("product code", product),
        ("revision", revision),
        ("serial number", serial),
    ]
}

/// The identity in one line, beginning with the device name.
fn identity_text(identity: &DeviceIdentity) -> String {
    let told = identity_facts(identity).map(|(name, value)| format!("{name} {}", value.as_deref().unwrap_or("-")));
    told.join(", ").replacen("name ", "", 1)
}

#[cfg(test)]
mod tests;
