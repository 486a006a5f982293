//! Fuzzes models without fault, and faults, for any length of time: `soak models EXCHANGES [SEED] [TARGET] [ALLOW]
//! [MODEL...]`, `soak faults SECONDS [SEED] [FAULT...]`; firmwares with liberties: `soak liberties EXCHANGES [SEED]
//! [COMBINATIONS]`.

use canvass_analyzer::NodeId;
use canvass_device::Fault;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::coverage::{LssReach, SdoReach};
use canvass_fuzzer::detection::{Limit, detect, fuzz};
use canvass_fuzzer::liberties::Chance;
use canvass_fuzzer::{Knowledge, Targets, reproducer};
use canvass_suite::touch::Touch;
use std::collections::BTreeSet;
use std::io::{Write, stdout};
use std::time::Duration;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |n: usize, usual: u64| args.get(n).map_or(Ok(usual), |text| text.parse::<u64>());
    match args.first().map(String::as_str) {
        Some("models") => models(
            number(1, 100_000)?,
            number(2, 0)?,
            args.get(3).map_or("all", |name| name),
            args.get(4).map_or("", |names| names),
            args.get(5..).unwrap_or(&[]),
        ),
        Some("liberties") => liberties(number(1, 20_000)?, number(2, 1)?, number(3, 100)?),
        Some("faults") => faults(number(1, 10)?, number(2, 0)?, args.get(3..).unwrap_or(&[])),
        _ => Err(
            "usage: soak models EXCHANGES [SEED] [TARGET] [ALLOW] [MODEL...] | soak faults SECONDS [SEED] [FAULT...] | soak liberties EXCHANGES [SEED] [COMBINATIONS]"
                .into(),
        ),
    }
}

/// Fuzzes the models. `allow` holds values of `--allow`, separated by commas; `-` allows nothing.
fn models(
    exchanges: u64,
    seed: u64,
    target: &str,
    allow: &str,
    named: &[String],
) -> Result<(), Box<dyn std::error::Error>> {
    let targets: Targets = target.parse()?;
    let names = allow.split(',').filter(|name| !matches!(*name, "" | "-"));
    let allow: BTreeSet<Touch> = names.map(str::parse).collect::<Result<_, _>>()?;
    let mut out = stdout().lock();
    for model in Model::all().iter().filter(|model| named.is_empty() || named.iter().any(|name| name == model.id())) {
        let begun = processor_time();
        let outcome = fuzz(model, Faults::NONE, targets, &allow, seed, &mut |done| done < exchanges)?;
        let knowledge = Knowledge::new(NodeId::MIN, Some(model.description()), Some(model.sheet()));
        let reach = LssReach::of(&knowledge.services, model.sheet().network.lss, &allow);
        let rate = outcome.executions as f64 / (processor_time() - begun);
        writeln!(
            out,
            "{:24} {:>9} exchanges, {rate:.0}/s, sdo {:?} lss {:?}, {} violations",
            model.id(),
            outcome.executions,
            outcome.coverage.sdo_share(SdoReach::of(&knowledge)),
            outcome.coverage.lss_share(&reach),
            outcome.violations.len()
        )?;
        for found in &outcome.violations {
            show(&mut out, found)?;
        }
    }
    Ok(())
}

fn faults(seconds: u64, seed: u64, named: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let mut out = stdout().lock();
    let limit = Limit { exchanges: u64::MAX, time: Duration::from_secs(seconds) };
    for &fault in Fault::ALL.iter().filter(|fault| named.is_empty() || named.iter().any(|name| name == fault.id())) {
        let trial = detect(fault, seed, limit)?;
        match &trial.found {
            Some(detected) => {
                let violation = &detected.found.violation;
                writeln!(
                    out,
                    "{} {} {:?} {} frames {} {} | {} | {}",
                    if detected.caused { "+" } else { "!" },
                    fault,
                    detected.elapsed,
                    detected.found.sequence.stimuli.len(),
                    violation.property,
                    violation.rule,
                    violation.expected,
                    violation.actual
                )?;
                if !named.is_empty() {
                    show(&mut out, &detected.found)?;
                }
            }
            None => writeln!(out, "- {} after {} exchanges", fault, trial.exchanges)?,
        }
        out.flush()?;
    }
    Ok(())
}

/// Tries each liberty alone, and `combinations` random combinations. Prints a line for each violation, and the number
/// of exchanges.
fn liberties(exchanges: u64, seed: u64, combinations: u64) -> Result<(), Box<dyn std::error::Error>> {
    let mut out = stdout().lock();
    let trial = canvass_fuzzer::liberties::run(Chance { seed, combinations: combinations as usize, exchanges })?;
    for row in trial.rows() {
        for found in &row.violations {
            writeln!(out, "{:?} on {}", row.liberties, row.model)?;
            show(&mut out, found)?;
        }
    }
    let broken = trial.rows().filter(|row| !row.violations.is_empty()).count();
    writeln!(
        out,
        "{} exchanges, {} liberties, {} combinations, {broken} with violations",
        trial.exchanges(),
        trial.alone.len(),
        trial.combined.len()
    )?;
    Ok(())
}

fn show(out: &mut impl Write, found: &Found) -> std::io::Result<()> {
    let violation = &found.violation;
    writeln!(
        out,
        "  {} {} (confirmed {}): expected {}, got {}",
        violation.property, violation.rule, found.confirmed, violation.expected, violation.actual
    )?;
    write!(out, "{:?}\n{}", found.sequence.start, reproducer::candump(&found.sequence))?;
    for record in found.evidence.iter().rev().take(40).rev() {
        writeln!(out, "    {} {:?} {}", record.timestamp, record.direction, record.frame)?;
    }
    Ok(())
}

/// The processor time of this process in seconds, on which other load of the computer has little influence.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let nanos = text.split_whitespace().next().and_then(|nanos| nanos.parse::<f64>().ok());
    nanos.unwrap_or(0.0) / 1e9
}
