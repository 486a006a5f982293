//! Judges a simulated device by all cases and by the fuzzer, for `cargo xtask mutants`: `mutant suite|fuzz SEED
//! EXCHANGES`. For each model it prints a finding, or else a number that stands for the whole traffic. It ends with the
//! first finding. `mutant verdicts` lists the verdict of each case on each model, which helps to find out why a mutant
//! (`CANVASS_MUTANT`) survives.

use canvass_bus::{Bus, BusError};
use canvass_device::Firmware;
use canvass_device::models::Model;
use canvass_fuzzer::campaign::{self, Plan};
use canvass_fuzzer::stand::{Readiness, Simulated, TestStand, simulated};
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Start, Target};
use canvass_suite::catalogue;
use canvass_suite::selftest::{self, Tried};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::Kind;
use canvass_traces::{Frame, Record, Timestamp};
use std::error::Error;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{Write, stdout};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Models that together have all services. The models of the standards come first.
const MODELS: [&str; 5] = ["reference-301", "reference-406", "kuebler-sendix-m58", "tr-c65", "tr-lmp30"];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |n: usize| args.get(n).map_or(Ok(0), |text| text.parse::<u64>());
    if args.first().is_some_and(|word| word == "verdicts") {
        return verdicts();
    }
    // A panic of the device is reported in one line, without its location.
    std::panic::set_hook(Box::new(|_| ()));
    for id in MODELS {
        let model = Model::by_id(id).ok_or("no such model")?;
        let judged = catch_unwind(AssertUnwindSafe(|| match args.first().map(String::as_str) {
            Some("suite") => Ok(suite(model)),
            _ => fuzz(model, number(1)?, number(2)?),
        }));
        let judged = judged.unwrap_or_else(|_| Ok(Judged::Found("the device crashes".to_owned())))?;
        let mut out = stdout().lock();
        match &judged {
            Judged::Found(what) => writeln!(out, "{id} found {what}")?,
            Judged::Recorded(case) => writeln!(out, "{id} recorded {case}")?,
            Judged::Traffic(hash) => writeln!(out, "{id} traffic {hash:016x}")?,
        }
        out.flush()?;
        if matches!(judged, Judged::Found(_)) {
            break;
        }
    }
    Ok(())
}

enum Judged {
    Found(String),
    /// No case failed, but a case that records what the standard leaves open recorded a difference.
    Recorded(&'static str),
    /// Nothing was found. The number is a hash of all frames with their times.
    Traffic(u64),
}

/// Runs every case on a device of its own.
fn suite(model: &'static Model) -> Judged {
    let mut traffic = DefaultHasher::new();
    let mut recorded = None;
    let mut tried = Tried::new(model, Firmware::PLAIN);
    for case in catalogue::cases() {
        let report = tried.judge(case, &mut |record| heard(record, &mut traffic));
        let verdict = &report.verdict;
        if matches!(verdict.kind(), Kind::Fail | Kind::Error) {
            return Judged::Found(format!("{}: {:?}", case.id, verdict.reason().unwrap_or_default()));
        }
        if selftest::records(case, verdict) {
            recorded = Some(case.id);
        }
    }
    recorded.map_or_else(|| Judged::Traffic(traffic.finish()), Judged::Recorded)
}

fn verdicts() -> Result<(), Box<dyn Error>> {
    let mut out = stdout().lock();
    for id in MODELS {
        let mut tried = Tried::new(Model::by_id(id).ok_or("no such model")?, Firmware::PLAIN);
        for case in catalogue::cases() {
            let verdict = tried.judge(case, &mut |_| ()).verdict;
            writeln!(out, "{id} {} {} {:?}", case.id, verdict.kind(), verdict.reason())?;
        }
    }
    Ok(())
}

fn fuzz(model: &'static Model, seed: u64, exchanges: u64) -> Result<Judged, Box<dyn Error>> {
    let node = selftest::node_of(model);
    let (stand, knowledge) = simulated(model, node, Firmware::PLAIN, model.default_bit_rate(), seed);
    let mut stand = Heard { stand, now: Timestamp::ZERO, traffic: DefaultHasher::new() };
    let plan = Plan {
        targets: Target::All.into(),
        seed,
        allow: Touch::ALL.into_iter().collect(),
        shrink_budget: 0,
        time: TimeLimit::default(),
        stop_at_first: true,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    };
    let outcome = match campaign::run(&mut stand, knowledge, &plan, &mut |progress| progress.executions < exchanges) {
        Ok(outcome) => outcome,
        Err(error) => return Ok(Judged::Found(error.to_string())),
    };
    Ok(match outcome.violations.first() {
        Some(found) => Judged::Found(format!("{} {}", found.violation.property, found.violation.rule)),
        None => Judged::Traffic(stand.traffic.finish()),
    })
}

fn heard(record: &Record, traffic: &mut DefaultHasher) {
    (record.timestamp, record.frame).hash(traffic);
}

/// A test stand that hashes its frames.
struct Heard {
    stand: Simulated,
    now: Timestamp,
    traffic: DefaultHasher,
}

impl TestStand for Heard {
    fn begin(&mut self, start: Start) -> Result<Readiness, BusError> {
        let readiness = self.stand.begin(start);
        self.now = self.stand.bus().now();
        readiness
    }

    fn bus(&mut self) -> &mut dyn Bus {
        self
    }

    fn has_unconfigured(&self) -> bool {
        self.stand.has_unconfigured()
    }

    fn is_repeatable(&self) -> bool {
        self.stand.is_repeatable()
    }
}

impl Bus for Heard {
    fn now(&self) -> Timestamp {
        self.now
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.stand.bus().send(frame)
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        let record = self.stand.bus().receive(deadline)?;
        self.now = self.stand.bus().now();
        record.iter().for_each(|record| heard(record, &mut self.traffic));
        Ok(record)
    }

    fn bit_rate(&self) -> Option<u32> {
        Some(self.stand.bit_rate())
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.stand.bus().set_bit_rate(bit_rate)
    }
}
