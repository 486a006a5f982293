//! `canvass list`: cases, models, rules and so on, with their ids.

use crate::output::print;
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::Rule;
use canvass_analyzer::findings::{self, Metadata, Threshold};
use canvass_device::models::Model;
use canvass_device::{Fault, Liberty};
use canvass_fuzzer::Property;
use canvass_reports::answers;
use canvass_reports::catalogue_page;
use canvass_reports::descriptions;
use canvass_reports::diagnosis;
use canvass_reports::escape::Printable;
use canvass_reports::fuzz::faults_page;
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::situation::Situation;
use canvass_traces::Format;
use serde_json::{Value, json};
use std::fmt::Write;

/// List cases, situations, models, faults, liberties, rules, properties or formats
#[derive(clap::Args)]
pub struct Args {
    /// The kind of items to list
    #[arg(value_enum)]
    what: What,
    /// How to print the items
    #[arg(long, value_enum, default_value_t)]
    format: ListFormat,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum What {
    /// Conformance cases
    Cases,
    /// Situations, with the answers that CiA 301 allows
    Situations,
    /// Built-in device models
    Models,
    /// Faults of the firmware of simulated devices
    Faults,
    /// Liberties: unusual behaviour that the standard allows, as simulated devices show it
    Liberties,
    /// Rules of `canvass diagnose`
    Rules,
    /// Rules of `canvass eds check`
    EdsRules,
    /// Properties of `canvass fuzz`
    Properties,
    /// Capture formats
    Formats,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum ListFormat {
    /// Aligned text
    #[default]
    Text,
    /// An array of objects with `id` and `summary`
    Json,
    /// A page with all cases, rules, eds-rules, or faults
    Markdown,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        if matches!(self.format, ListFormat::Markdown) {
            let page = match self.what {
                What::Cases => catalogue_page::markdown(&catalogue::cases()),
                What::Faults => faults_page::page(),
                What::Rules => diagnosis::handbook(),
                What::EdsRules => descriptions::rules::handbook(),
                _ => {
                    let advice = "--format markdown is for cases, faults, rules and eds-rules: choose text or json";
                    return Err(anyhow!(advice).into());
                }
            };
            print(&Printable::document(&page))?;
            return Ok(Status::Good);
        }
        let rows = match self.what {
            What::Cases => cases(),
            What::Situations => situations(),
            What::Models => models(),
            What::Faults => faults(),
            What::Liberties => liberties(),
            What::Rules => rules(),
            What::EdsRules => eds_rules(),
            What::Properties => properties(),
            What::Formats => formats(),
        };
        match self.format {
            ListFormat::Text | ListFormat::Markdown => print(&Printable::document(&text(&rows)))?,
            ListFormat::Json => print(&Printable::pretty_json(&Value::Array(rows)))?,
        }
        Ok(Status::Good)
    }
}

fn cases() -> Vec<Value> {
    let row = |case: &&Case| {
        json!({
            "id": case.id,
            "summary": case.summary(),
            "clause": case.clause.bare(),
            "clause_confidence": case.clause.confidence.name(),
            "level": case.level.name(),
        })
    };
    catalogue::cases().iter().map(row).collect()
}

fn situations() -> Vec<Value> {
    let row = |situation: &Situation| {
        let answers = situation.answers();
        json!({
            "id": situation.id(),
            "summary": situation.requirement(),
            "clause": answers.clause.bare(),
            "clause_confidence": answers.clause.confidence.name(),
            "level": answers.level.name(),
            "allowed": answers::allowed(*situation),
            "tolerated": answers::tolerated(*situation),
        })
    };
    Situation::ALL.iter().map(row).collect()
}

fn models() -> Vec<Value> {
    let row = |model: &Model| {
        json!({
            "id": model.id(),
            "summary": model.summary(),
            "node": model.default_node().map(NodeId::raw),
            "bit_rate": model.default_bit_rate(),
        })
    };
    Model::all().iter().map(row).collect()
}

fn liberties() -> Vec<Value> {
    let row = |liberty: &Liberty| {
        json!({
            "id": liberty.id(),
            "summary": liberty.summary(),
            "clause": liberty.clause(),
            "model": liberty.model(),
            "devices": liberty.devices(),
        })
    };
    Liberty::ALL.iter().map(row).collect()
}

fn faults() -> Vec<Value> {
    let row = |fault: &Fault| {
        json!({
            "id": fault.id(),
            "summary": fault.summary(),
            "model": fault.model(),
            "fuzz": fault.is_fuzzed(),
            "fuzz_needs": fault.fuzz_needs(),
            "unfuzzed": fault.unfuzzed(),
        })
    };
    Fault::ALL.iter().map(row).collect()
}

fn rules() -> Vec<Value> {
    let row = |rule: &Metadata| {
        let threshold = |threshold: &Threshold| {
            json!({
                "name": threshold.name,
                "default": threshold.default,
                "unit": threshold.unit.to_string(),
                "summary": threshold.meaning,
            })
        };
        json!({
            "id": rule.id,
            "summary": rule.title,
            "severity": rule.severity.name(),
            "thresholds": rule.thresholds.iter().map(threshold).collect::<Vec<_>>(),
        })
    };
    findings::all().map(|definition| row(definition.metadata)).collect()
}

fn eds_rules() -> Vec<Value> {
    let row = |rule: &Rule| {
        json!({
            "id": rule.id,
            "summary": rule.title(),
            "severity": rule.severity.name(),
            "clause": rule.clause.bare(),
            "clause_confidence": rule.clause.confidence.name(),
        })
    };
    canvass_analyzer::dictionary::rules::all().map(row).collect()
}

fn properties() -> Vec<Value> {
    Property::all().map(|property| json!({ "id": property.id(), "summary": property.title() })).collect()
}

fn formats() -> Vec<Value> {
    let row = |format: Format| {
        json!({
            "id": format.id(),
            "summary": format.summary(),
            "extensions": format.extensions(),
            "written": format.is_written(),
        })
    };
    Format::all().map(row).collect()
}

/// Ids and summaries in two columns.
fn text(rows: &[Value]) -> String {
    let of = |row: &Value, key: &str| row[key].as_str().unwrap_or_default().to_owned();
    let width = rows.iter().map(|row| of(row, "id").len()).max().unwrap_or(0);
    rows.iter().fold(String::new(), |mut text, row| {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{:width$}  {}", of(row, "id"), of(row, "summary"));
        text
    })
}
