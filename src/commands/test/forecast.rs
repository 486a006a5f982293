//! `--dry-run`: which cases would run, and for how long.
//!
//! The dry run refuses whatever the run would refuse. It does not touch a live bus: a simulated device of the same
//! model, or made from the description, takes the place of the device. A simulated bus is used as in the run.

use super::{Args, named};
use crate::commands::test::reports::ReportFormat;
use crate::destination::{Destination, refuse_existing};
use crate::output::{diagnostic, print};
use crate::status::{Failure, Status};
use crate::whole_file::WholeFile;
use anyhow::anyhow;
use canvass_bus::SimulatedBus;
use canvass_device::address::{BusAddress, DeviceName, Opened, SimulatedDevice};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Firmware};
use canvass_reports::escape::Printable;
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::case::Case;
use canvass_suite::order::Timed;
use canvass_suite::runner::{Plan, RunError, RunEvent, run};
use canvass_suite::verdict::{Deviation, End, Reason};
use canvass_traces::{Duration, Record};
use serde_json::{Value, json};
use std::fmt::Write;
use std::sync::atomic::AtomicBool;

/// The name and version of the contract.
const SCHEMA: &str = "canvass/dry-run/1";

/// The forecast for a case.
struct ForecastRow {
    case: &'static Case,
    /// Why the case would not run.
    skipped: Option<String>,
    takes: Duration,
}

/// The forecast for all cases.
struct Forecast {
    rows: Vec<ForecastRow>,
    /// The model that stands in for the device.
    like: String,
    /// Number of writes to the non-volatile memory.
    stores: u32,
}

/// Prints the ids, each with the reason why it would not run, and a forecast.
pub fn dry_run(
    args: &Args,
    cases: &[&'static Case],
    options: &Options,
    waived: Vec<Deviation>,
) -> Result<Status, Failure> {
    refuse_outputs(args)?;
    let (mut opened, like) = stand_in(args)?;
    let target = args.target(&opened, waived)?;
    let forecast = simulate(&mut opened, &target, cases, options, like)?;
    match args.shown.of_stdout()? {
        ReportFormat::Json => print(&Printable::pretty_json(&forecast.json()))?,
        _ => {
            print(&forecast.text())?;
            diagnostic(&format!("canvass: {}", forecast.summary()));
        }
    }
    Ok(Status::Good)
}

/// The time that each case takes on the stand-in; without the cases that would not run.
pub fn timed(args: &Args, cases: &[&'static Case], options: &Options) -> Result<Vec<Timed>, Failure> {
    let (mut opened, like) = stand_in(args)?;
    let target = args.target(&opened, Vec::new())?;
    // The stand-in needs no protection, and its time costs nothing.
    let options = Options { limit: None, repeat: 1, journal: None, power_cycle: None, ..options.clone() };
    let forecast = simulate(&mut opened, &target, cases, &options, like)?;
    Ok(forecast.run().map(|row| Timed { case: row.case, takes: row.takes }).collect())
}

/// Refuses outputs that could not be written.
fn refuse_outputs(args: &Args) -> Result<(), Failure> {
    for report in args.shown.in_files() {
        // Dropping an incomplete file removes it.
        drop(WholeFile::create(report.file())?);
    }
    if let Some(path) = &args.record {
        let destination = Destination::new(path, None, args.force)?;
        if !args.force && !destination.is_stdout() {
            refuse_existing(path)?;
        }
    }
    Ok(())
}

/// The simulated device that stands in for the device under test, and its name.
fn stand_in(args: &Args) -> Result<(Opened, String), Failure> {
    if let BusAddress::Simulated(_) = args.bus.parse()? {
        let opened = args.open()?;
        let like = opened.model.map_or("none", Model::id).to_owned();
        return Ok((opened, like));
    }
    let model = match args.device.as_deref().map(named) {
        None => Fault::ALL.first().and_then(|fault| Model::by_id(fault.model())).unwrap_or(&Model::all()[0]),
        Some(device) => match Model::by_id(device) {
            Some(model) => model,
            None => of_file(device)?,
        },
    };
    let usual = || args.device.as_ref().and(model.default_node());
    let node = args.node.or_else(usual).ok_or_else(|| super::which_node(&args.bus, None))?;
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(Box::new(Device::new(model, Some(node), Firmware::PLAIN, args.seed)));
    Ok((Opened { bus: Box::new(bus), model: None, devices: Vec::new() }, model.id().to_owned()))
}

/// A device made from its description.
fn of_file(path: &str) -> Result<&'static Model, Failure> {
    let described = SimulatedDevice {
        device: DeviceName::File(path.to_owned()),
        node: None,
        bit_rate: None,
        motion: None,
        firmware: Firmware::PLAIN,
    };
    Ok(described.model()?)
}

/// Runs the cases against the stand-in.
fn simulate(
    opened: &mut Opened,
    target: &Target,
    cases: &[&'static Case],
    options: &Options,
    like: String,
) -> Result<Forecast, Failure> {
    let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
    let plan = Plan { cases, bus: "", bit_rate: opened.bus.bit_rate(), seed: 0, shuffle: None };
    let mut bench = Bench::new(opened.bus.as_mut(), target, options, &mut annotate, &cancel);
    let mut rows = Vec::new();
    let summary = run(&mut bench, &plan, &mut |event| {
        if let RunEvent::CaseFinished(report) = event {
            let skipped = match report.verdict.end() {
                Some(End::NotApplicable(reason)) => Some(why(report.case, options, reason)),
                _ => None,
            };
            rows.push(ForecastRow { case: report.case, skipped, takes: report.duration });
        }
    });
    match summary {
        Ok(summary) => Ok(Forecast { rows, like, stores: summary.stores }),
        Err(RunError::NothingToRun { .. }) if opened.devices.is_empty() && !rows.is_empty() => {
            let why = rows.first().and_then(|row| row.skipped.clone()).unwrap_or_default();
            Err(Failure::unreachable(anyhow!(
                "no case would be executed: {} selected, none would run ({why})",
                rows.len()
            )))
        }
        Err(error) => Err(Failure::unreachable(error)),
    }
}

/// Why a case would not run: a missing capability of the device, or a missing permission.
fn why(case: &Case, options: &Options, reason: &Reason) -> String {
    let forbidden = case.touches.iter().find(|touch| !options.allow.contains(touch));
    let needs = || format!("needs {}: {}", reason.expected, reason.actual);
    forbidden.map_or_else(needs, |touch| format!("only with --allow {touch}"))
}

impl Forecast {
    fn run(&self) -> impl Iterator<Item = &ForecastRow> {
        self.rows.iter().filter(|row| row.skipped.is_none())
    }

    fn takes(&self) -> Duration {
        let nanos: u64 = self.rows.iter().map(|row| row.takes.nanos()).sum();
        Duration::from_nanos(nanos / 1_000_000 * 1_000_000)
    }

    fn text(&self) -> Printable {
        let mut text = String::new();
        for ForecastRow { case, skipped, .. } in &self.rows {
            let why = skipped.as_ref().map(|why| format!("  ({why})")).unwrap_or_default();
            // Writing to a string can't fail.
            let _ = writeln!(text, "{}{why}", case.id);
        }
        Printable::document(&text)
    }

    fn summary(&self) -> String {
        let (all, run, takes, like, stores) =
            (self.rows.len(), self.run().count(), self.takes(), &self.like, self.stores);
        format!(
            "on a device like {like} {run} of {all} cases would run, in about {takes}, with {stores} writes of its \
             non-volatile memory"
        )
    }

    fn json(&self) -> Value {
        let row = |row: &ForecastRow| {
            json!({
                "id": row.case.id,
                "runs": row.skipped.is_none(),
                "reason": row.skipped,
                "duration_ns": row.takes.nanos(),
            })
        };
        json!({
            "schema": SCHEMA,
            "like": self.like,
            "cases": self.rows.iter().map(row).collect::<Vec<_>>(),
            "would_run": self.run().count(),
            "duration_ns": self.takes().nanos(),
            "stores": self.stores,
        })
    }
}
