//! `--dry-run`: which cases would run, and how long that would take.

use crate::output::print;
use crate::status::{Failure, Status};
use canvass_analyzer::NodeId;
use canvass_bus::SimulatedBus;
use canvass_device::Device;
use canvass_device::Fault;
use canvass_device::Faults;
use canvass_device::address::BusAddress;
use canvass_device::models::Model;
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::case::Case;
use canvass_suite::runner::{CaseReport, Plan, RunEvent, run};
use canvass_suite::verdict::Kind;
use canvass_traces::{Duration, Record};
use std::fmt::Write;
use std::sync::atomic::AtomicBool;

/// Prints the ids, each with why it would not run if the user has not allowed it, and a forecast. The bus is not touched:
/// the time is that of the same run against a simulated device, of the model where it is a built-in one.
pub fn dry_run(
    address: &str,
    device: Option<&str>,
    cases: &[&'static Case],
    options: &Options,
) -> Result<Status, Failure> {
    let model = model_of(address, device);
    let (mut text, mut reports) = (String::new(), Vec::new());
    let stores = simulate(model, cases, options, &mut |report| {
        reports.push((report.case.id, report.verdict.kind(), report.duration));
    });
    for case in cases {
        let forbidden = case.touches.iter().find(|touch| !options.allow.contains(touch));
        let why = forbidden.map(|touch| format!("  (only with --allow {touch})")).unwrap_or_default();
        // Writing to a string can't fail.
        let _ = writeln!(text, "{}{why}", case.id);
    }
    print(&text)?;
    let total: u64 = reports.iter().map(|(_, _, duration)| duration.nanos()).sum();
    let skipped = reports.iter().filter(|(_, kind, _)| *kind == Kind::NotApplicable).count();
    let (run, like) = (cases.len() - skipped.min(cases.len()), model.id());
    let total = Duration::from_nanos(total / 1_000_000 * 1_000_000);
    crate::output::diagnostic(&format!(
        "canvass: {} cases; on a device like {like} {run} of them would run, in about {total}, with {stores} writes of its \
         non-volatile memory",
        cases.len()
    ));
    Ok(Status::Good)
}

/// The built-in model that the device is, or the one that most faults show on.
fn model_of(address: &str, device: Option<&str>) -> &'static Model {
    let simulated = match address.parse() {
        Ok(BusAddress::Simulated(devices)) => devices.first().and_then(|device| device.model().ok()),
        _ => None,
    };
    let named = device.map(|device| device.split_once('=').map_or(device, |(_, device)| device)).and_then(Model::by_id);
    let usual = Fault::ALL.first().and_then(|fault| Model::by_id(fault.model()));
    named.or(simulated).or(usual).unwrap_or(&Model::all()[0])
}

/// Runs the cases against a simulated device; returns how often its memory was written.
fn simulate(
    model: &'static Model,
    cases: &[&'static Case],
    options: &Options,
    finished: &mut dyn FnMut(&CaseReport),
) -> u32 {
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(Box::new(Device::new(model, model.default_node(), Faults::NONE, 0)));
    let target = Target::of(model, model.default_node().unwrap_or(NodeId::MAX));
    let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
    let plan = Plan { cases, bus: "sim", bit_rate: None, seed: 0 };
    let mut bench = Bench::new(&mut bus, &target, options, &mut annotate, &cancel);
    let summary = run(&mut bench, &plan, &mut |event| {
        if let RunEvent::CaseFinished(report) = event {
            finished(report);
        }
    });
    summary.map_or(0, |summary| summary.stores)
}
