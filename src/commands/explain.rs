//! `canvass explain`: one case, situation, fault, liberty, rule, property, model, format, error code or abort code in full.

use crate::output::print;
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_analyzer::dictionary::rules;
use canvass_analyzer::findings;
use canvass_analyzer::meant;
use canvass_device::models::Model;
use canvass_device::{Fault, Liberty};
use canvass_reports::answers;
use canvass_reports::codes;
use canvass_reports::descriptions;
use canvass_reports::diagnosis;
use canvass_reports::escape::Printable;
use canvass_reports::fuzz::properties;
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::situation::Situation;
use canvass_traces::Format;
use std::fmt::Write;

/// Explain a case, a situation, a fault, a liberty, a rule, a property, a model, a capture format or a code in full
#[derive(clap::Args)]
pub struct Args {
    /// The id, as `canvass list` shows it; an error code of EMCY (8140h); or an SDO abort code (0604 0041h)
    #[arg(required = true)]
    id: Vec<String>,
    /// Device profile of the node with the error code, such as 402
    #[arg(long, value_name = "NUMBER")]
    profile: Option<u16>,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        // An abort code is usually written as two words.
        let id = &*self.id.join(" ");
        let text = catalogue::find(id)
            .map(case)
            .or_else(|| id.parse().ok().map(fault))
            .or_else(|| Situation::by_id(id).map(situation))
            .or_else(|| id.parse().ok().map(liberty))
            .or_else(|| findings::find(id).map(|rule| rule_of_captures(rule.metadata)))
            .or_else(|| rules::find(id).map(descriptions::rules::explain))
            .or_else(|| id.parse().ok().map(properties::explain))
            .or_else(|| Model::by_id(id).map(model))
            .or_else(|| Format::by_id(id).map(format))
            .or_else(|| codes::explain(id, self.profile))
            .ok_or_else(|| {
                let meant = meant(id, ids());
                anyhow!(
                    "nothing has the id \"{id}\"{meant}: `canvass list \
                     cases|situations|models|faults|liberties|rules|eds-rules|properties|formats` lists all; codes have \
                     four or eight hexadecimal digits (8140h, \"0604 0041h\")"
                )
            })?;
        print(&Printable::document(&text))?;
        Ok(Status::Good)
    }
}

/// The ids of everything but codes.
fn ids() -> impl Iterator<Item = &'static str> {
    let cases = catalogue::cases().into_iter().map(|case| case.id);
    let behaviour = Fault::ALL.iter().map(|fault| fault.id()).chain(Liberty::ALL.iter().map(|liberty| liberty.id()));
    let situations = Situation::ALL.iter().map(|situation| situation.id());
    let others = Model::all().iter().map(Model::id).chain(Format::all().map(Format::id));
    cases.chain(behaviour).chain(situations).chain(rules::all().map(|rule| rule.id)).chain(others)
}

/// The non-empty rows in two columns.
fn rows(head: &str, text: &str, rows: &[(&str, String)]) -> String {
    let mut shown = format!("{head}\n\n{text}\n\n");
    for (name, value) in rows.iter().filter(|row| !row.1.is_empty()) {
        // Writing to a string can't fail.
        let _ = writeln!(shown, "{name:10} {value}");
    }
    shown.trim_end().to_owned() + "\n"
}

/// A diagnosis rule, and how to set its thresholds.
fn rule_of_captures(rule: &findings::Metadata) -> String {
    let text = diagnosis::explain(rule);
    if rule.thresholds.is_empty() {
        text
    } else {
        text + "canvass diagnose --threshold RULE.NAME=VALUE sets a threshold.\n"
    }
}

fn list<T>(items: &[T], name: impl Fn(&T) -> String) -> String {
    items.iter().map(name).collect::<Vec<_>>().join(", ")
}

fn case(case: &Case) -> String {
    let table = [
        ("clause", case.clause.to_string()),
        ("level", case.level.name().to_owned()),
        ("allows", list(case.answers, |row| format!("{} ({})", answers::allowed(*row), row.id()))),
        ("needs", list(case.needs, |need| need.text().to_owned())),
        ("touches", list(case.touches, |touch| format!("{} (--allow {touch})", touch.text()))),
        ("catches", list(case.catches, ToString::to_string)),
        ("CiA tool", case.cct.map(|number| format!("comparable with case {number}")).unwrap_or_default()),
    ];
    rows(case.id, case.requirement, &table)
}

fn situation(situation: Situation) -> String {
    let asked = catalogue::cases().into_iter().filter(|case| case.answers.contains(&situation));
    let asked: Vec<&str> = asked.map(|case| case.id).collect();
    let answers = situation.answers();
    let table = [
        ("clause", answers.clause.to_string()),
        ("level", answers.level.name().to_owned()),
        ("allowed", answers::allowed(situation)),
        ("tolerated", answers::tolerated(situation)),
        ("asked by", list(&asked, ToString::to_string)),
    ];
    rows(situation.id(), situation.requirement(), &table)
}

fn fault(fault: Fault) -> String {
    let caught = catalogue::cases().into_iter().filter(|case| case.catches.contains(&fault));
    let caught: Vec<&str> = caught.map(|case| case.id).collect();
    rows(fault.id(), fault.summary(), &[("caught by", list(&caught, ToString::to_string)), ("fuzzer", fuzzer(fault))])
}

fn liberty(liberty: Liberty) -> String {
    let table = [
        ("clause", liberty.clause().to_owned()),
        ("devices", list(liberty.devices(), ToString::to_string)),
        ("shows on", format!("sim:{}~~{}", liberty.model(), liberty.id())),
    ];
    rows(liberty.id(), liberty.summary(), &table)
}

fn fuzzer(fault: Fault) -> String {
    match (fault.unfuzzed(), fault.fuzz_needs()) {
        (Some(why), _) => format!("not among the fuzzer's claims: {why}"),
        (None, Some(touch)) => format!("found with --allow {touch}"),
        (None, None) => "finds it".to_owned(),
    }
}

fn model(model: &Model) -> String {
    let table = [
        ("node-ID", model.default_node().map(|node| node.to_string()).unwrap_or_default()),
        ("bit rate", format!("{} kbit/s", model.default_bit_rate() / 1000)),
        ("objects", model.description().dictionary.objects().len().to_string()),
    ];
    rows(model.id(), model.summary(), &table)
}

fn format(format: Format) -> String {
    let written = if format.is_written() { "yes" } else { "no" };
    let table = [("endings", list(format.extensions(), ToString::to_string)), ("written", written.to_owned())];
    rows(format.id(), format.summary(), &table)
}
