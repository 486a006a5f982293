//! Fuzzes a live device and reports speed and coverage: `live BUS NODE MODEL|FILE SECONDS [SEED] [TARGET]`.

use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_device::models::Model;
use canvass_fuzzer::campaign::{Plan, campaign};
use canvass_fuzzer::coverage::SdoReach;
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Knowledge, Targets, reproducer};
use std::collections::BTreeSet;
use std::io::{Write, stdout};
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [bus, node, device, seconds, rest @ ..] = &args[..] else {
        return Err("usage: live BUS NODE MODEL|FILE SECONDS [SEED] [TARGET]".into());
    };
    let node = NodeId::new(node.parse()?).ok_or("the node-ID is not one from 1 to 127")?;
    let knowledge = match Model::by_id(device) {
        Some(model) => Knowledge::new(node, Some(model.description()), Some(model.sheet())),
        None => Knowledge::new(node, Some(&DeviceDescription::read(&std::fs::read(device)?)?), None),
    };
    let seconds: f64 = seconds.parse()?;
    let mut plan = Plan {
        targets: rest.get(1).map_or(Ok(Targets::default()), |names| names.parse())?,
        seed: rest.first().map_or(Ok(1), |seed| seed.parse())?,
        allow: BTreeSet::new(),
        shrink_budget: 100,
        time: TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    };
    let reach = SdoReach::of(&knowledge);
    let mut opened = canvass_device::address::open(bus)?;
    // A program that uses this end as its adapter may connect later.
    opened.bus.wait_for_client(canvass_traces::Duration::from_secs(10))?;
    let begun = Instant::now();
    plan.time.ends = Some(begun + Duration::from_secs_f64(seconds));
    let mut told = 0.0;
    let mut out = stdout().lock();
    let outcome = campaign(&mut *opened.bus, knowledge, &plan, &mut |progress| {
        let now = begun.elapsed().as_secs_f64();
        if now >= told + 10.0 {
            told = now;
            let (reached, all) = progress.coverage.sdo_share(reach);
            // An error while printing must not end the run.
            let _ = writeln!(out, "{now:.0} s: {} exchanges, SDO {reached} of {all}", progress.executions);
        }
        true
    })?;
    let rate = outcome.executions as f64 / begun.elapsed().as_secs_f64();
    let (reached, all) = outcome.coverage.sdo_share(reach);
    writeln!(
        out,
        "{} exchanges, {} frames, {} sequences, {rate:.0}/s, SDO {reached} of {all}, {} not judged{}",
        outcome.executions,
        outcome.frames,
        outcome.sequences,
        outcome.unjudged,
        if outcome.dead { ", dead" } else { "" }
    )?;
    writeln!(out, "all: {}", outcome.spent)?;
    writeln!(out, "violations repeated and shortened: {}", outcome.spent_on_violations)?;
    for found in &outcome.violations {
        let violation = &found.violation;
        writeln!(
            out,
            "{} {} (confirmed {}): expected {}, got {}\n{}",
            violation.property,
            violation.rule,
            found.confirmed,
            violation.expected,
            violation.actual,
            reproducer::candump(&found.sequence)
        )?;
        for record in found.evidence.iter().rev().take(12).rev() {
            writeln!(out, "    {} {:?} {}", record.timestamp, record.direction, record.frame)?;
        }
    }
    Ok(())
}
