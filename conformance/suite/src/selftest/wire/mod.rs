//! The wire matrix: each field of each message that a device sends, wrong in each way, at each time.
//!
//! The messages and their fields come from the wire types ([`canvass_analyzer::wire::Fields`]), so that the matrix
//! includes new messages and fields automatically. A mutant is a right device behind a filter. It runs the cases in
//! their usual order until one fails, without the cases in which its message does not occur. If no frame differs from
//! the frames of the right device, the mutant proves nothing.

mod filter;
mod mutant;
mod open;
mod primitive;

pub use filter::{Filter, LATE, Tally};
pub use mutant::{Change, FieldChange, FrameChange, Mutant, When};
pub use primitive::Primitive;

use super::{chapter, in_parallel, judge_machine, node_of};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::dice::Dice;
use crate::glob;
use crate::verdict::{Allowed, Breach, Kind, Verdict};
use canvass_analyzer::Service;
use canvass_analyzer::wire::Fields;
use canvass_analyzer::wire::error_control::ErrorControl;
use canvass_analyzer::wire::layer_setting::Protocol;
use canvass_bus::Machine;
use canvass_bus::observation::{Observation, Subject};
use canvass_device::models::Model;
use canvass_device::{Device, Firmware};
use open::Open;
use std::sync::{Arc, PoisonError};

/// The mutants that run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Sample {
    /// Patterns of the ids of the mutants to draw from; no pattern means all mutants.
    pub only: Vec<String>,
    /// The seed of the draw: equal seeds draw equal mutants.
    pub seed: u64,
    /// Number of mutants; `None` means all.
    pub count: Option<usize>,
}

/// The results of the cases on the mutants.
#[derive(Clone, Debug)]
pub struct WireMatrix {
    /// One row for each mutant.
    pub rows: Vec<WireRow>,
    /// Primitives that no model sends in any case.
    pub unsent: Vec<Primitive>,
}

/// The results of the cases on a mutant.
#[derive(Clone, Debug)]
pub struct WireRow {
    /// The mutant.
    pub mutant: Mutant,
    /// The model behind the filter.
    pub model: &'static str,
    /// The outcome.
    pub outcome: Outcome,
}

/// The outcome of a mutant.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// No frame differs from the right device's.
    Unchanged,
    /// A case failed.
    Found {
        /// The first case that failed.
        case: &'static Case,
        /// Whether the breach names the service of the mutant.
        is_named: bool,
        /// The breach.
        breach: String,
    },
    /// No case failed, but some were inconclusive: the first of them, and their number.
    Inconclusive(&'static Case, usize),
    /// Every case passed.
    Passed,
    /// No case failed, and none has to: the standard leaves the change open, for this reason in the reviewed list.
    LeftOpen(String),
}

/// Number of mutants of a primitive, by outcome.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counts {
    /// Number of all mutants.
    pub made: usize,
    /// Number of mutants that changed a frame.
    pub changed: usize,
    /// Number of mutants on which no case has to fail, as the standard leaves the change of the frame open.
    pub open: usize,
    /// Number of mutants on which a case failed.
    pub found: usize,
    /// Number of mutants whose first failure names their service.
    pub named: usize,
    /// Number of mutants on which no case failed but some were inconclusive.
    pub inconclusive: usize,
}

impl WireMatrix {
    /// The counts of the mutants that `chosen` picks.
    pub fn counts(&self, chosen: impl Fn(&WireRow) -> bool) -> Counts {
        self.rows.iter().filter(|row| chosen(row)).fold(Counts::default(), |counts, row| counts.with(&row.outcome))
    }

    /// The mutants that changed the traffic but on which no case failed.
    pub fn survivors(&self) -> impl Iterator<Item = &WireRow> {
        self.rows.iter().filter(|row| matches!(row.outcome, Outcome::Inconclusive(..) | Outcome::Passed))
    }
}

impl Counts {
    fn with(self, outcome: &Outcome) -> Self {
        let is_named = matches!(outcome, Outcome::Found { is_named: true, .. });
        Self {
            made: self.made + 1,
            changed: self.changed + usize::from(!matches!(outcome, Outcome::Unchanged)),
            open: self.open + usize::from(matches!(outcome, Outcome::LeftOpen(_))),
            found: self.found + usize::from(matches!(outcome, Outcome::Found { .. })),
            named: self.named + usize::from(is_named),
            inconclusive: self.inconclusive + usize::from(matches!(outcome, Outcome::Inconclusive(..))),
        }
    }
}

/// Runs a sample of the mutants.
///
/// # Errors
/// The error of the reviewed list if it can't be read.
pub fn run(cases: &[&'static Case], models: &'static [Model], sample: &Sample) -> Result<WireMatrix, toml::de::Error> {
    let open = Open::read()?;
    let primitives: Arc<[Primitive]> = Primitive::all().into();
    let stages: Vec<&'static Model> = models.iter().collect();
    let stages = in_parallel(&stages, |model| Stage::new(model, cases, &primitives));
    let place_of = |mutant: &Mutant| {
        primitives.iter().position(|known| known.is(mutant.primitive.service, mutant.primitive.layout))
    };
    let boot_up = ErrorControl::BOOT_UP.layout();
    let boot_up = primitives.iter().position(|known| known.is(Service::Heartbeat, boot_up));
    let best = |place: usize| {
        let senders = stages.iter().filter(|stage| stage.cases_with(place).next().is_some());
        // Models with a boot-up message are preferred: without it (DS-301 V3.0) it is open what a device has to do
        // after a start. Of equal models the first is chosen.
        let starts = |stage: &Stage| boot_up.is_some_and(|boot_up| stage.cases_with(boot_up).next().is_some());
        senders.rev().max_by_key(|stage| (starts(stage), stage.cases_with(place).count()))
    };
    let chosen = drawn(Mutant::all(&primitives), sample);
    let rows = in_parallel(&chosen, |mutant| {
        let place = place_of(mutant)?;
        let mut row = best(place)?.row(*mutant, place, &primitives);
        if matches!(row.outcome, Outcome::Inconclusive(..) | Outcome::Passed)
            && let Some(reason) = open.reason(mutant)
        {
            row.outcome = Outcome::LeftOpen(reason.to_owned());
        }
        Some(row)
    });
    let unsent = primitives.iter().enumerate().filter(|(place, _)| best(*place).is_none());
    Ok(WireMatrix { rows: rows.into_iter().flatten().collect(), unsent: unsent.map(|(_, known)| *known).collect() })
}

/// A sample of the mutants, in their order.
fn drawn(mut mutants: Vec<Mutant>, sample: &Sample) -> Vec<Mutant> {
    mutants.retain(|mutant| {
        let id = mutant.to_string();
        sample.only.is_empty() || sample.only.iter().any(|pattern| glob::matches(pattern, &id))
    });
    let Some(count) = sample.count else { return mutants };
    let mut dice = Dice::new(sample.seed);
    let mut numbered: Vec<(u64, usize)> = (0..mutants.len()).map(|at| (dice.next(), at)).collect();
    numbered.sort_unstable();
    numbered.truncate(count);
    numbered.sort_unstable_by_key(|(_, at)| *at);
    numbered.into_iter().filter_map(|(_, at)| mutants.get(at).copied()).collect()
}

/// A model, with the primitives that it sends in each case.
struct Stage {
    model: &'static Model,
    target: Target,
    protocol: Protocol,
    sent: Vec<(&'static Case, Vec<bool>)>,
}

impl Stage {
    fn new(model: &'static Model, cases: &[&'static Case], primitives: &Arc<[Primitive]>) -> Self {
        let target = Target::of(model, node_of(model));
        let protocol = if model.sheet().network.lss { Protocol::Lss } else { Protocol::Lmt };
        let mut stage = Self { model, target, protocol, sent: Vec::new() };
        let mut knowledge = Knowledge::default();
        for &case in cases.iter().filter(|case| case.asks_the_device()) {
            let (_, tally) = stage.judge(case, None, primitives, &mut knowledge);
            stage.sent.push((case, tally.sent));
        }
        stage
    }

    /// The cases in which this primitive is sent.
    fn cases_with(&self, place: usize) -> impl Iterator<Item = &'static Case> {
        self.sent.iter().filter(move |(_, sent)| sent.get(place) == Some(&true)).map(|(case, _)| *case)
    }

    fn judge(
        &self,
        case: &'static Case,
        mutant: Option<Mutant>,
        primitives: &Arc<[Primitive]>,
        knowledge: &mut Knowledge,
    ) -> (Verdict, Tally) {
        let mut tally = None;
        let new = |motion| -> Box<dyn Machine> {
            let device = Device::with_motion(self.model, Some(self.target.node), Firmware::PLAIN, 0, &motion);
            let filter = Filter::new(device, self.protocol, mutant, Arc::clone(primitives));
            tally = Some(filter.tally());
            Box::new(filter)
        };
        let report = judge_machine(case, new, self.model.default_bit_rate(), &self.target, knowledge, &mut |_| ());
        let tally = tally.map(|tally| tally.lock().unwrap_or_else(PoisonError::into_inner).clone());
        (report.verdict, tally.unwrap_or_default())
    }

    fn row(&self, mutant: Mutant, place: usize, primitives: &Arc<[Primitive]>) -> WireRow {
        let mut knowledge = Knowledge::default();
        let (mut outcome, mut unclear) = (Outcome::Unchanged, None);
        for case in self.cases_with(place) {
            let (verdict, tally) = self.judge(case, Some(mutant), primitives, &mut knowledge);
            if tally.changed > 0 && matches!(outcome, Outcome::Unchanged) {
                outcome = Outcome::Passed;
            }
            match verdict.kind() {
                Kind::Fail => {
                    outcome = found(case, &verdict, mutant.primitive.service);
                    break;
                }
                Kind::Inconclusive | Kind::Error => {
                    let (first, count) = unclear.unwrap_or((case, 0));
                    unclear = Some((first, count + 1));
                }
                _ => {}
            }
        }
        if let (Outcome::Passed, Some((case, count))) = (&outcome, unclear) {
            outcome = Outcome::Inconclusive(case, count);
        }
        WireRow { mutant, model: self.model.id(), outcome }
    }
}

fn found(case: &'static Case, verdict: &Verdict, service: Service) -> Outcome {
    let breach = verdict.breaches().iter().find(|ruled| ruled.kind() == Kind::Fail).map(|ruled| &ruled.breach);
    let is_named = breach.is_some_and(|breach| names(case, breach, service));
    Outcome::Found { case, is_named, breach: breach.map(ToString::to_string).unwrap_or_default() }
}

/// Whether a breach concerns a service: by its subject, or by the chapter of its case.
fn names(case: &'static Case, breach: &Breach, service: Service) -> bool {
    let of = |subject: Service| breach.subject == Subject::Service(subject);
    match service {
        // SDO reads and writes the objects.
        Service::Sdo => {
            of(Service::Sdo)
                || chapter(case) == "object dictionary"
                || matches!(breach.subject, Subject::Entry(_) | Subject::Object(_))
        }
        Service::Heartbeat => {
            let services = [Service::BootUp, Service::Heartbeat, Service::Guarding, Service::Nmt];
            services.into_iter().any(of) || chapter(case) == "network management"
        }
        // A case of another service may judge an EMCY.
        Service::Emcy => of(Service::Emcy) || chapter(case) == "emergencies" || expects_emcy(breach),
        Service::Pdo => matches!(breach.subject, Subject::Pdo { .. }) || chapter(case) == "process data",
        Service::Sync => of(Service::Sync) || case.family() == "301/sync",
        Service::Time => of(Service::Time) || case.family() == "301/time",
        Service::Lss => of(Service::Lss) || chapter(case) == "305",
        Service::Lmt => of(Service::Lmt) || chapter(case) == "205",
        other => of(other),
    }
}

fn expects_emcy(breach: &Breach) -> bool {
    let is_emcy = |observation: &Observation| matches!(observation, Observation::Emcy(_));
    matches!(&breach.allowed, Allowed::OneOf(allowed) if allowed.iter().any(is_emcy))
}
