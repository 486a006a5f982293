//! Where a result of the page comes from, as the program would say it of the same files.

use canvass_analyzer::findings::Results;
use canvass_reports::provenance::{Choice, ChosenBy, Date, Host, Provenance};
use canvass_suite::runner::DeviceIdentity;
use canvass_traces::Channels;

/// What the page knows of its surroundings.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(default)]
pub struct Surroundings {
    host: String,
    system: String,
    date: String,
    zone: String,
}

impl Surroundings {
    /// The provenance of a diagnosis, where files of these names describe devices, as `NODES=FILE`.
    pub fn of_diagnosis(&self, devices: Vec<String>, format: Option<&str>, same_bus: bool) -> Provenance {
        let given = |name: &str, value: Vec<String>| {
            let by = if value.is_empty() { ChosenBy::Default } else { ChosenBy::CommandLine };
            Choice { name: name.to_owned(), value, default: Vec::new(), by }
        };
        let usual = |name: &str, value: &str| {
            let value = vec![value.to_owned()];
            Choice { name: name.to_owned(), value: value.clone(), default: value, by: ChosenBy::Default }
        };
        let flag = |name: &str, set: bool| match set {
            true => Choice { value: vec!["yes".to_owned()], by: ChosenBy::CommandLine, ..usual(name, "no") },
            false => usual(name, "no"),
        };
        let options = vec![
            usual("fail-on", "error"),
            given("threshold", Vec::new()),
            given("bit-rate", Vec::new()),
            given("device", devices),
            given("from", Vec::new()),
            given("to", Vec::new()),
            given("format-in", format.map(str::to_owned).into_iter().collect()),
            given("topic", Vec::new()),
            flag("same-bus", same_bus),
            flag("strict", false),
        ];
        Provenance { options, ..self.provenance() }
    }

    /// When and where.
    pub fn provenance(&self) -> Provenance {
        let date = Date { rfc3339: self.date.clone(), zone: self.zone.clone() };
        let host = Host { name: self.host.clone(), system: self.system.clone() };
        Provenance { date: Some(date), host: Some(host), ..Provenance::default() }
    }
}

/// What the nodes of captures said of themselves, where somebody asked them.
pub fn devices(results: &Results, channels: &Channels) -> Vec<(String, DeviceIdentity)> {
    let mut devices = Vec::new();
    for (channel, bus) in &results.buses {
        for (node, figures) in &bus.nodes {
            let of = &figures.identity;
            let identity =
                DeviceIdentity { device_type: of.device_type, identity: of.numbers, names: of.names.clone() };
            if identity != DeviceIdentity::default() {
                devices.push((format!("node {node} on {}", channels.name(*channel)), identity));
            }
        }
    }
    devices
}
