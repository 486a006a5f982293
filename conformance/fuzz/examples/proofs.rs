//! Whether findings are proofs: fuzzes each simulated firmware with a fault, and plays the log of each confirmed
//! violation ten times on a fresh device. `proofs EXCHANGES [SEED] [live] [FAULT...]`; `live`: the fuzzer resets one
//! device instead of making a new one for each sequence.

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Faults, Firmware};
use canvass_fuzzer::campaign::{self, Found, Plan};
use canvass_fuzzer::reproducer::{self, Check};
use canvass_fuzzer::stand::simulated;
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Live, Start, Target};
use canvass_suite::touch::Touch;
use canvass_traces::Timestamp;
use std::collections::BTreeSet;
use std::error::Error;
use std::io::{Write, stdout};

/// Number of times that each log is played.
const TIMES: u64 = 10;

/// Longest time of a simulated device from power-on to its boot-up message.
const BOOT: Timestamp = Timestamp(10_000_000_000);

#[derive(Default)]
struct Sums {
    firmwares: u64,
    /// Firmwares in which a violation was confirmed.
    found: u64,
    confirmed: u64,
    unconfirmed: u64,
    /// Confirmed violations whose log showed them each time.
    back: u64,
    /// Violations that a check without the reference models can't tell from right behaviour.
    unclear: u64,
    /// Violations that `--replay` showed.
    replayed: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let exchanges = args.first().map_or(Ok(4_000), |text| text.parse())?;
    let seed = args.get(1).map_or(Ok(1), |text| text.parse())?;
    let is_live = args.get(2).is_some_and(|word| word == "live");
    let named = args.get(2 + usize::from(is_live)..).unwrap_or_default();
    let mut sums = Sums::default();
    for &fault in Fault::ALL.iter().filter(|fault| fault.unfuzzed().is_none()) {
        if named.is_empty() || named.iter().any(|name| name == fault.id()) {
            trial(fault, exchanges, seed, is_live, &mut sums)?;
        }
    }
    let Sums { firmwares, found, confirmed, unconfirmed, back, unclear, replayed } = sums;
    writeln!(
        stdout(),
        "{firmwares} firmwares, {found} with a confirmed violation; {confirmed} confirmed, {unconfirmed} not confirmed\n\
         {back} of {confirmed} came back {TIMES} of {TIMES} times on a fresh device ({:.1} %), {replayed} by --replay\n\
         {unclear} show no difference to a device without the fault but in the reference models",
        back as f64 * 100.0 / confirmed.max(1) as f64
    )?;
    Ok(())
}

/// The model of a fault, with the fault or without.
struct Bench {
    model: &'static Model,
    node: NodeId,
    firmware: Firmware,
}

impl Bench {
    fn bus(&self, start: Start, seed: u64) -> Result<SimulatedBus, Box<dyn Error>> {
        let mut bus = SimulatedBus::new(self.model.default_bit_rate());
        let node = Some(self.node).filter(|_| start == Start::Configured);
        bus.attach(Box::new(Device::new(self.model, node, self.firmware, seed)));
        let boot_up = 0x700 + u16::from(self.node.raw());
        while start == Start::Configured
            && let Some(record) = bus.receive(BOOT)?
            && record.frame.cob_id() != Some(boot_up)
        {}
        Ok(bus)
    }

    /// Plays the log of a violation. Returns whether the check holds.
    fn holds(&self, found: &Found, seed: u64) -> Result<Option<bool>, Box<dyn Error>> {
        let check = Check::of(found);
        let mut bus = self.bus(found.sequence.start, seed)?;
        let played = reproducer::play(&mut bus, &reproducer::log(found), check.patience(found))?;
        Ok(check.holds(played.since(found.prelude.len()), played.last))
    }
}

fn trial(fault: Fault, exchanges: u64, seed: u64, is_live: bool, sums: &mut Sums) -> Result<(), Box<dyn Error>> {
    let Some(model) = Model::by_id(fault.model()) else { return Ok(()) };
    let node = model.default_node().unwrap_or(NodeId::MIN);
    let allow: BTreeSet<Touch> = fault.fuzz_needs().and_then(|name| name.parse().ok()).into_iter().collect();
    let plan = Plan {
        targets: Target::All.into(),
        seed,
        allow,
        shrink_budget: if is_live { 100 } else { 2_000 },
        time: TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    };
    let bench = Bench { model, node, firmware: fault.into() };
    let healthy = Bench { firmware: Faults::NONE.into(), ..bench };
    let (mut stand, knowledge) = simulated(model, node, fault, model.default_bit_rate(), seed);
    let outcome = match is_live {
        false => campaign::run(&mut stand, knowledge, &plan, &mut |state| state.executions < exchanges)?,
        true => {
            let mut bus = bench.bus(Start::Configured, seed)?;
            let mut live = Live::new(&mut bus, &knowledge);
            campaign::run(&mut live, knowledge, &plan, &mut |state| state.executions < exchanges)?
        }
    };
    sums.firmwares += 1;
    sums.found += u64::from(outcome.violations.iter().any(|found| found.confirmed));
    for found in outcome.violations {
        if !found.confirmed {
            sums.unconfirmed += 1;
            tell(fault, "not confirmed", &found)?;
            continue;
        }
        sums.confirmed += 1;
        let shows = (0..TIMES).map(|n| bench.holds(&found, seed + n)).collect::<Result<Vec<_>, _>>()?;
        let times = shows.iter().filter(|holds| **holds == Some(false)).count() as u64;
        let is_unclear = healthy.holds(&found, seed)? != Some(true);
        let address = format!("sim:{}+{fault}", model.id());
        let again = reproducer::replay(&address, Some(node), None, reproducer::log(&found).as_bytes())?;
        let is_replayed = again.is_some_and(|again| again.defect() == found.violation.defect());
        sums.replayed += u64::from(is_replayed);
        sums.unclear += u64::from(is_unclear);
        sums.back += u64::from(times == TIMES);
        if times < TIMES || is_unclear || !is_replayed {
            tell(fault, &format!("{times} of {TIMES}, unclear: {is_unclear}, replayed: {is_replayed}"), &found)?;
        }
    }
    Ok(())
}

fn tell(fault: Fault, what: &str, found: &Found) -> Result<(), Box<dyn Error>> {
    let violation = &found.violation;
    writeln!(
        stdout(),
        "{fault}: {what}: {} {}: expected {}, found {} ({})",
        violation.property,
        violation.rule,
        violation.expected,
        violation.actual,
        found
            .repetitions
            .iter()
            .map(|one| format!("{} {}", one.replay.name(), one.came))
            .collect::<Vec<_>>()
            .join(", ")
    )?;
    write!(stdout(), "{:?}\n{}", Check::of(found), reproducer::log(found))?;
    Ok(())
}
