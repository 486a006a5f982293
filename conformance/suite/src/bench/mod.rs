//! Where a case runs: it reaches the precondition, gives the stimulus, sees what happens, and cleans up.
//!
//! - `traffic`: frames out and in;
//! - [`nmt`]: commands, resets, boot-up;
//! - [`state`]: NMT states, seen and reached;
//! - [`sdo`], [`block`]: transfers and single messages;
//! - [`pdo`]: PDO parameters and mapping;
//! - [`objects`]: which objects of this device serve a case;
//! - `features`: what this device has;
//! - `restore`: as it was found.

mod acting;
mod answers;
mod attempt;
mod baseline;
pub mod block;
mod clients;
mod decoder;
mod dictionary;
mod evidence;
mod features;
mod foreign;
mod journalled;
mod knowledge;
mod measurement;
pub mod nmt;
pub mod objects;
mod operational;
pub mod pdo;
mod presence;
mod profile;
mod promptness;
mod provide;
mod restore;
mod rewrite;
pub mod sdo;
mod start;
pub mod state;
mod target;
#[cfg(test)]
mod tests;
mod traffic;
mod undisturbed;
mod watch;
mod zero_point;

pub use baseline::Harm;
pub use decoder::Decoder;
pub use evidence::{Annotate, Evidence, Exhibit};
pub(crate) use foreign::Foreign;
pub use knowledge::Met;
pub(crate) use knowledge::{Found, Knowledge};
pub use measurement::{Measurement, Unit, percentile};
pub(crate) use operational::KeptOut;
pub(crate) use profile::{Profile, Registered};
pub use restore::Rescue;
pub use target::{Options, Target, Timing};
pub use traffic::{Sent, is_from};
pub use watch::Boots;

use crate::journal::Journal;
use crate::verdict::{Breach, Check, Judged, Reason, Stop};
use baseline::Baseline;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, Health};
use canvass_traces::{Duration, Timestamp};
use clients::Clients;
use promptness::Promptness;
use rewrite::Original;
use std::sync::atomic::{AtomicBool, Ordering};
use watch::Watch;

/// The bus, the device under test, and what happens between them while a case runs.
pub struct Bench<'a> {
    bus: &'a mut dyn Bus,
    target: &'a Target,
    options: &'a Options,
    annotate: &'a mut dyn Annotate,
    cancel: &'a AtomicBool,
    /// When the time of the run is over.
    ends: Timestamp,
    /// What is changed, and what it was before.
    journal: Option<Journal>,
    evidence: Evidence,
    /// What the case has found wrong so far.
    breaches: Vec<Breach>,
    /// Answers of the SDO server whose form is wrong, one of each sort.
    untidy: Vec<Breach>,
    watch: Watch,
    /// What the case has changed, with the values before.
    changes: Vec<Original>,
    /// What earlier cases have changed and could not put back.
    unrestored: Vec<Original>,
    notes: Vec<String>,
    measurements: Vec<Measurement>,
    uses: Vec<Use>,
    /// Waits end at once when the user cancels, except while things are being put back.
    restoring: bool,
    /// The case has told the device to become operational.
    started: bool,
    foreign: Foreign,
    clients: Clients,
    promptness: Promptness,
    /// When the last frame was on the bus.
    taken_at: Timestamp,
    /// The case in which the device left the bus, if it did not come back.
    gone: Option<&'static str>,
    /// While a case runs: how many frames were lost before it.
    lost_before: Option<u64>,
    /// Frames taken since then.
    taken: u64,
    knowledge: Knowledge,
    /// What the device was before the run.
    baseline: Baseline,
    /// A zero point is being put back: the only write to what moves it outside of a case that may move it.
    moving_zero_point: bool,
    /// The case wrote an object that is stored as soon as it is written.
    wrote_memory: bool,
}

/// A failure that comes while a frame takes longer than this to or from the tester may be the tester's own: it is as long
/// as the shortest wait that a case judges by.
pub(crate) const HOST_LATE: Duration = Duration::from_millis(50);

/// What the tester's own machine has to do. Reports name it where it did not.
pub(crate) const KEEPS_UP: &str = "the tester's machine keeps up";

/// What the device has to do, so that its times are those of its clock. Reports name it where it did not.
pub(crate) const DEVICE_KEEPS_UP: &str = "the device keeps up";

/// What a case leaves behind for its report.
#[derive(Debug, Default)]
pub struct Remains {
    /// The frames that were on the bus.
    pub evidence: Evidence,
    /// What else happened: an EMCY nobody asked for, a value that could not be restored.
    pub notes: Vec<String>,
    /// Boot-up messages that no command explains.
    pub boots: Boots,
    /// What was measured.
    pub measurements: Vec<Measurement>,
    /// Which of several objects served.
    pub uses: Vec<Use>,
}

/// An object that served a case, where another could have.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Use {
    /// The object.
    pub multiplexer: Multiplexer,
    /// What for.
    pub purpose: &'static str,
}

impl<'a> Bench<'a> {
    /// A bench for one device. `cancel` ends every wait once it is set.
    pub fn new(
        bus: &'a mut dyn Bus,
        target: &'a Target,
        options: &'a Options,
        annotate: &'a mut dyn Annotate,
        cancel: &'a AtomicBool,
    ) -> Self {
        Self {
            journal: None,
            ends: options.limit.map_or(Timestamp::MAX, |limit| bus.now() + limit),
            bus,
            target,
            options,
            annotate,
            cancel,
            evidence: Evidence::default(),
            breaches: Vec::new(),
            untidy: Vec::new(),
            watch: Watch::new(target.node),
            changes: Vec::new(),
            unrestored: Vec::new(),
            notes: Vec::new(),
            measurements: Vec::new(),
            uses: Vec::new(),
            restoring: false,
            started: false,
            foreign: Foreign::default(),
            clients: Clients::new(target.node, target.description.as_ref()),
            promptness: Promptness::default(),
            taken_at: Timestamp::ZERO,
            gone: None,
            lost_before: None,
            taken: 0,
            knowledge: Knowledge::default(),
            baseline: Baseline::default(),
            moving_zero_point: false,
            wrote_memory: false,
        }
    }

    /// Takes over what another bench found out about the same device.
    pub(crate) fn learn(&mut self, knowledge: Knowledge) {
        self.knowledge = knowledge;
    }

    /// What was found out about the device.
    pub(crate) fn into_knowledge(self) -> Knowledge {
        self.knowledge
    }

    /// The node-ID of the device under test.
    pub fn node(&self) -> NodeId {
        self.target.node
    }

    /// What is tested.
    pub fn target(&self) -> &'a Target {
        self.target
    }

    /// How to test.
    pub fn options(&self) -> &'a Options {
        self.options
    }

    /// How long to wait for what.
    pub fn timing(&self) -> Timing {
        self.options.timing
    }

    /// How long nothing must come where nothing may come: longer for a device whose answers take longer.
    pub fn silence(&self) -> Duration {
        let slowest = self.knowledge.slowest_answer;
        self.timing().silence.max(slowest + Duration::from_nanos(slowest.nanos() / 4))
    }

    /// The time on the bus.
    pub fn now(&self) -> Timestamp {
        self.bus.now()
    }

    /// How well the bus and the tester's own machine work.
    pub fn health(&self) -> Health {
        self.bus.health()
    }

    /// Whether the bus is a live one.
    pub fn is_live(&self) -> bool {
        self.bus.is_live()
    }

    /// How much of the bus others than the tester and the device have taken since [`Bench::begin`].
    pub(crate) fn foreign(&self) -> &Foreign {
        &self.foreign
    }

    /// The bit rate of the bus in bit/s, where it is known.
    pub fn bit_rate(&self) -> Option<u32> {
        self.bus.bit_rate()
    }

    /// By how much a frame can be late, or another early after it, through nobody's fault: one frame of the longest is on
    /// the wire when it is due, and its own length. Where the bit rate is not known, that of 125 kbit/s.
    pub fn bus_delay(&self) -> Duration {
        /// A 29-bit frame of eight bytes with all its stuff bits, and the intermission.
        const LONGEST: u64 = 160;
        const USUAL_BIT_RATE: u32 = 125_000;
        let bit_rate = u64::from(self.bit_rate().unwrap_or(USUAL_BIT_RATE).max(1));
        Duration::from_nanos(2 * LONGEST * 1_000_000_000 / bit_rate)
    }

    /// How late the tester's machine has been at most so far, from the bus or to it; what is later than the bound excuses the
    /// device altogether.
    pub fn host_delay(&self) -> Duration {
        self.health().latest().unwrap_or_default().min(HOST_LATE)
    }

    /// How long after a frame the device has acted on it, where it acts at once: what the timing says, and what bus
    /// and host add.
    pub fn shortly(&self) -> Duration {
        self.timing().reaction + self.bus_delay() + self.host_delay()
    }

    /// By how much a single period may differ: what the user tolerates, and what the bus itself takes.
    pub fn tolerance(&self, period: Duration) -> Duration {
        self.timing().tolerance(period) + self.bus_delay()
    }

    /// What was on the bus since the case began.
    pub fn evidence(&self) -> &Evidence {
        &self.evidence
    }

    /// Whether the run is to end: the user has cancelled it, or its time is over.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.is_out_of_time()
    }

    /// Whether the time of the run is over.
    pub(crate) fn is_out_of_time(&self) -> bool {
        self.ends != Timestamp::MAX && self.bus.now() >= self.ends
    }

    /// Whether the device is known to have left the bus.
    pub(crate) fn has_gone(&self) -> bool {
        self.gone.is_some()
    }

    /// Takes what a check found wrong, and lets the case go on.
    ///
    /// # Errors
    /// Those of later waits only: a breach that the rest of the case can't be judged after is returned with `?` instead.
    pub fn check(&mut self, check: Check) -> Judged {
        if let Err(breach) = check {
            self.record(*breach);
        }
        Ok(())
    }

    /// Runs a check for each of several subjects: a breach of one does not keep the others from being judged.
    ///
    /// # Errors
    /// What ends the case: the bus failed, or a precondition of one subject can't be reached.
    pub fn each<T>(
        &mut self,
        subjects: impl IntoIterator<Item = T>,
        mut check: impl FnMut(&mut Self, T) -> Judged,
    ) -> Judged {
        for subject in subjects {
            match check(self, subject) {
                Err(Stop::Breach(breach)) => self.record(*breach),
                other => other?,
            }
        }
        Ok(())
    }

    fn record(&mut self, breach: Breach) {
        let seen = breach.seen.or_else(|| self.evidence.last());
        self.breaches.push(Breach { seen, ..breach });
    }

    /// What the case has found wrong so far; `last` ended it.
    pub(crate) fn take_breaches(&mut self, last: Option<Box<Breach>>) -> Vec<Breach> {
        if let Some(last) = last {
            self.record(*last);
        }
        std::mem::take(&mut self.breaches)
    }

    /// Adds a sentence to the case's report. Does not change the verdict.
    pub fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// Adds a measurement to the case's report. Does not change the verdict.
    pub fn measure(&mut self, name: impl Into<String>, value: Duration) {
        self.measurements.push(Measurement { name: name.into(), value: value.nanos(), unit: Unit::Nanoseconds });
    }

    /// Adds a count to the case's report. Does not change the verdict.
    pub fn count(&mut self, name: impl Into<String>, value: u64) {
        self.measurements.push(Measurement { name: name.into(), value, unit: Unit::Count });
    }

    /// Says in the case's report which object served it.
    pub(crate) fn uses(&mut self, multiplexer: Multiplexer, purpose: &'static str) {
        let using = Use { multiplexer, purpose };
        if !self.uses.contains(&using) {
            self.uses.push(using);
        }
    }

    /// How often the device was told to write its non-volatile memory since the start of the run.
    pub fn stores(&self) -> u32 {
        self.watch.stores()
    }

    /// Says that the case provokes errors: EMCYs are not noted as unasked.
    pub fn expect_emergencies(&mut self) {
        self.watch.expect_emergencies();
    }

    /// Forgets the case before: nothing of it counts for the next one.
    pub(crate) fn begin(&mut self) {
        self.evidence = Evidence::default();
        self.breaches.clear();
        self.untidy.clear();
        self.notes.clear();
        self.begin_among_others();
        self.promptness.begin();
        self.measurements.clear();
        self.uses.clear();
        self.watch.forget();
        self.started = false;
    }

    /// A case during which frames are lost says nothing of the device: from now on its waits end as soon as that is seen.
    pub(crate) fn end_when_frames_are_lost(&mut self) {
        self.lost_before = Some(self.bus.health().lost);
        self.taken = 0;
    }

    /// Ends a case: puts back what it changed and hands over what it left behind.
    pub(crate) fn finish(&mut self) -> Remains {
        self.lost_before = None;
        self.restore();
        let notes = self.watch.emergencies().map(|(at, emcy)| format!("EMCY at {at} s: {emcy}"));
        let notes: Vec<String> = notes.collect::<Vec<_>>().into_iter().chain(self.notes.drain(..)).collect();
        let measurements = std::mem::take(&mut self.measurements);
        let (evidence, uses) = (std::mem::take(&mut self.evidence), std::mem::take(&mut self.uses));
        Remains { evidence, notes, boots: self.watch.boots(), measurements, uses }
    }

    fn check_cancelled(&self) -> Result<(), Stop> {
        if self.is_cancelled() && !self.restoring {
            let why = if self.is_out_of_time() { "the time of the run was over" } else { "the run was cancelled" };
            let reason = Reason::new("the case runs to its end", "no interruption", why);
            return Err(Stop::Inconclusive(reason));
        }
        Ok(())
    }
}
