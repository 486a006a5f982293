//! `canvass dcf diff`: a configuration beside a device or another configuration.

use super::device::{BusOptions, Session};
use super::file::ConfigurationFile;
use crate::devices::{describe, named, parse_node};
use crate::output::{Color, TextJsonOrMarkdown, terminal_width};
use crate::status::{Failure, Status};
use anyhow::{Result, anyhow};
use canvass_analyzer::dictionary::configuration::{DeviceSettings, Download};
use canvass_analyzer::dictionary::survey::{Answer, Survey};
use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_reports::descriptions::configuration::{ComparedConfigurations, DifferingSetting, SideOfSetting};
use canvass_reports::document::Style;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Compare a configuration with a device, or with another configuration; nothing is written
///
/// Every setting that the first file has is compared; of two files also the settings that only the second one has.
/// Entries that act when they are written are no settings. Exit status 1 if a setting differs.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass dcf diff encoder-5.dcf can0
  canvass dcf diff monday.dcf friday.dcf")]
pub struct Args {
    /// A DCF, XDC or concise DCF
    file: PathBuf,
    /// A bus with the device, or another file
    #[arg(value_name = "BUS|FILE")]
    other: String,
    /// The device's node-ID (default: the node of the file)
    #[arg(long, value_parser = parse_node)]
    node: Option<NodeId>,
    /// The device of a concise DCF: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    /// How to print the differences
    #[arg(long, value_enum, default_value_t)]
    format: TextJsonOrMarkdown,
    #[command(flatten)]
    options: BusOptions,
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let compared = self.compare()?;
        let style = Style { color: color.on_stdout(), width: terminal_width() };
        self.format.print(&compared, style)?;
        Ok(if compared.differences.is_empty() { Status::Good } else { Status::Findings })
    }

    fn compare(&self) -> Result<ComparedConfigurations, Failure> {
        let file = ConfigurationFile::read(&self.file)?;
        let given = self.device.as_deref().map(named);
        let given = given.map(describe).transpose()?;
        let known = file.known(given.as_ref());
        let (path, name) = (Path::new(&self.other), self.file.display().to_string());
        if path.is_file() {
            return Ok(self.with_file(&file, &known, &ConfigurationFile::read(path)?)?);
        }
        let given: Vec<NodeId> = self.node.or(file.node()).into_iter().collect();
        let mut session = Session::open(&self.other, &given, &self.options)?;
        let node = given.first().copied().or(session.simulated_node());
        let node = node.ok_or_else(|| anyhow!("{name} names no node-ID: use --node N"))?;
        let manual = session.models(node)?.first().map(|model| model.device().manual.clone());
        let known = KnownDevice { manual: manual.unwrap_or_default(), ..known };
        let wanted = settings(file.values(node)?, &known, node);
        let mut survey = Survey::default();
        for download in &wanted {
            if let Some(value) = session.value(node, download.at)? {
                survey.insert(download.at, Answer::Value(value));
            }
        }
        session.report_health();
        Ok(compared((name, &wanted), (format!("node {node} on {}", self.other), &survey), &known.description))
    }

    fn with_file(
        &self,
        file: &ConfigurationFile,
        known: &KnownDevice,
        other: &ConfigurationFile,
    ) -> Result<ComparedConfigurations> {
        let node = |file: &ConfigurationFile| self.node.or(file.node()).unwrap_or(NodeId::MIN);
        let one = settings(file.values(node(file))?, known, node(file));
        let second = settings(other.values(node(other))?, &other.known(Some(known)), node(other));
        let values: BTreeMap<Multiplexer, Vec<u8>> =
            second.iter().map(|download| (download.at, download.value.clone())).collect();
        let survey: Survey = values.iter().map(|(at, value)| (*at, Answer::Value(value.clone()))).collect();
        let name = |file: &ConfigurationFile| file.path.display().to_string();
        let mut compared = compared((name(file), &one), (name(other), &survey), &known.description);
        let only = values.into_iter().filter(|(at, _)| !one.iter().any(|download| download.at == *at));
        for (at, value) in only {
            compared.settings += 1;
            compared.differences.push(DifferingSetting {
                one: None,
                ..differing(at, &known.description, Vec::new(), SideOfSetting::Value(value))
            });
        }
        compared.differences.sort_by_key(|differing| differing.at);
        Ok(compared)
    }
}

/// The values without those of entries that act.
fn settings(values: Vec<Download>, known: &KnownDevice, node: NodeId) -> Vec<Download> {
    let of_device = DeviceSettings::described(known, node);
    values.into_iter().filter(|download| !of_device.acts(download.at)).collect()
}

/// Compares wanted values with what was read.
pub fn compared(
    (one, wanted): (String, &[Download]),
    (other, survey): (String, &Survey),
    description: &DeviceDescription,
) -> ComparedConfigurations {
    let differences = wanted.iter().filter_map(|Download { at, value }| {
        let found = match survey.get(*at) {
            Some(Answer::Value(found)) if found == value => return None,
            Some(Answer::Value(found)) => SideOfSetting::Value(found.clone()),
            Some(answer) => SideOfSetting::Answer(answer.to_string()),
            None => SideOfSetting::Nothing,
        };
        Some(differing(*at, description, value.clone(), found))
    });
    let differences = differences.collect();
    ComparedConfigurations { one, other, settings: wanted.len(), differences }
}

fn differing(
    at: Multiplexer,
    description: &DeviceDescription,
    value: Vec<u8>,
    other: SideOfSetting,
) -> DifferingSetting {
    let object = description.dictionary.object(at.index);
    let entry = description.dictionary.entry(at).ok();
    let name = match (object, entry) {
        (Some(object), Some(entry)) if object.code.is_single() || entry.name == object.name => object.name.clone(),
        (Some(object), Some(entry)) => format!("{}, {}", object.name, entry.name),
        _ => String::new(),
    };
    let data_type = entry.map(|entry| entry.data_type);
    DifferingSetting { at, name, data_type, one: Some(value), other }
}
