//! Where a case runs: it reaches the precondition, gives the stimulus, sees what happens, and cleans up.
//!
//! A bench is made of what it knows: `traffic` (the bus), `changes` (what the device was before), `knowledge` (what the device
//! can), `case_log` (what the case has found). What a case does needs several of them:
//!
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
pub(crate) mod baseline;
pub mod block;
mod case_log;
mod changes;
mod clients;
mod decoder;
pub(crate) mod dictionary;
mod evidence;
mod features;
mod foreign;
mod frames;
pub(crate) mod interrupted;
mod knowledge;
mod measurement;
mod nanos;
pub mod nmt;
pub mod objects;
mod operational;
pub mod pdo;
mod presence;
mod profile;
pub(crate) mod promptness;
mod provide;
mod quiet;
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
pub use case_log::Use;
pub use decoder::Decoder;
pub use evidence::{Annotate, Evidence, Exhibit};
pub use knowledge::Met;
pub(crate) use knowledge::{Found, Knowledge};
pub use measurement::{Measurement, Unit, percentile};
pub(crate) use operational::KeptOut;
pub(crate) use profile::{Profile, Registered};
pub use restore::Rescue;
pub use target::{Options, Target, Timing};
pub use traffic::{Sent, is_from};
pub use watch::Boots;
pub use zero_point::zero_point_of;

use crate::verdict::{Breach, Check, Judged, Stop};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, Health};
use canvass_traces::{Duration, Timestamp};
use case_log::CaseLog;
use changes::Changes;
use std::sync::atomic::AtomicBool;
use traffic::Traffic;

/// The bus, the device under test, and what happens between them while a case runs.
pub struct Bench<'a> {
    target: &'a Target,
    options: &'a Options,
    pub(crate) traffic: Traffic<'a>,
    pub(crate) changes: Changes,
    pub(crate) knowledge: Knowledge,
    log: CaseLog,
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
            target,
            options,
            traffic: Traffic::new(bus, target, options.limit, annotate, cancel),
            changes: Changes::default(),
            knowledge: Knowledge::default(),
            log: CaseLog::default(),
        }
    }

    /// Takes over what another bench found out about the same device.
    pub(crate) fn learn(&mut self, knowledge: Knowledge) {
        self.knowledge = knowledge;
    }

    /// What was found out about the device.
    pub(crate) fn into_knowledge(self) -> Knowledge {
        self.knowledge.of_firmware()
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
        self.traffic.now()
    }

    /// How well the bus and the tester's own machine work.
    pub fn health(&self) -> Health {
        self.traffic.health()
    }

    /// Whether the bus is a live one.
    pub fn is_live(&self) -> bool {
        self.traffic.is_live()
    }

    /// The bit rate of the bus in bit/s, where it is known.
    pub fn bit_rate(&self) -> Option<u32> {
        self.traffic.bit_rate()
    }

    /// By how much a frame can be late, or another early after it, through nobody's fault.
    pub fn bus_delay(&self) -> Duration {
        self.traffic.bus_delay()
    }

    /// How late the tester's machine has been at most so far, where that does not excuse the device altogether.
    pub fn host_delay(&self) -> Duration {
        self.traffic.host_delay()
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
        self.traffic.evidence()
    }

    /// Whether the run is to end: the user has cancelled it, or its time is over.
    pub fn is_cancelled(&self) -> bool {
        self.traffic.is_cancelled()
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
        self.log.record(breach, self.traffic.evidence().last());
    }

    /// What the case has found wrong so far; `last` ended it.
    pub(crate) fn take_breaches(&mut self, last: Option<Box<Breach>>) -> Vec<Breach> {
        if let Some(last) = last {
            self.record(*last);
        }
        self.log.take_breaches()
    }

    /// Adds a sentence to the case's report. Does not change the verdict.
    pub fn note(&mut self, text: impl Into<String>) {
        self.log.notes.push(text.into());
    }

    /// Adds a measurement to the case's report. Does not change the verdict.
    pub fn measure(&mut self, name: impl Into<String>, value: Duration) {
        self.log.measure(name.into(), value.nanos(), Unit::Nanoseconds);
    }

    /// Adds a count to the case's report. Does not change the verdict.
    pub fn count(&mut self, name: impl Into<String>, value: u64) {
        self.log.measure(name.into(), value, Unit::Count);
    }

    /// Says in the case's report which object served it.
    pub(crate) fn uses(&mut self, multiplexer: Multiplexer, purpose: &'static str) {
        self.log.uses(Use { multiplexer, purpose });
    }

    /// How often the device was told to write its non-volatile memory since the start of the run.
    pub fn stores(&self) -> u32 {
        self.traffic.watch.stores()
    }

    /// Says that the case provokes errors: EMCYs are not noted as unasked.
    pub fn expect_emergencies(&mut self) {
        self.traffic.watch.expect_emergencies();
    }

    /// Forgets the case before: nothing of it counts for the next one.
    pub(crate) fn begin(&mut self) {
        self.traffic.begin();
        self.log = CaseLog::default();
        self.knowledge.promptness.begin();
    }

    /// Ends a case: puts back what it changed and hands over what it left behind.
    pub(crate) fn finish(&mut self) -> Remains {
        self.traffic.bear_lost_frames();
        self.restore();
        let (noted, measurements, uses) = self.log.take();
        let emergencies = self.traffic.watch.emergencies().map(|(at, emcy)| format!("EMCY at {at} s: {emcy}"));
        let notes = emergencies.chain(noted).collect();
        let boots = self.traffic.watch.boots();
        Remains { evidence: self.traffic.take_evidence(), notes, boots, measurements, uses }
    }
}
