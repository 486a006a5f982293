//! The bench on which a case runs: it establishes the precondition, sends the stimulus, observes the device, and cleans
//! up.
//!
//! The parts of a bench are: `traffic` (the bus), `changes` (the values before changes), `knowledge` (the features of
//! the device), `case_log` (the findings of the case). The functions of a case need several of them:
//!
//! - [`nmt`]: commands, resets, boot-up;
//! - [`state`]: NMT states, seen and reached;
//! - [`sdo`], [`block`]: transfers and single messages;
//! - [`pdo`]: PDO parameters and mapping;
//! - [`objects`]: the objects of this device that can serve a case;
//! - `features`: the features of this device;
//! - `restore`: putting the device back as it was found.

mod acting;
mod answers;
mod attempt;
pub(crate) mod baseline;
pub mod block;
mod case_log;
mod changes;
mod clients;
mod decoder;
mod dialogue;
pub(crate) mod dictionary;
mod evidence;
mod features;
mod foreign;
mod frames;
mod idle;
pub(crate) mod interrupted;
mod knowledge;
mod measurement;
mod nanos;
pub mod nmt;
pub mod objects;
mod open_transfer;
mod operational;
pub mod pdo;
mod presence;
pub mod profile;
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
pub use objects::Candidate;
pub(crate) use operational::KeptOut;
pub use profile::{Profile, Registered};
pub use restore::Rescue;
pub use target::{Options, Target, Timing};
pub use traffic::{Sent, is_from};
pub use watch::Boots;
pub use zero_point::zero_point_of;

use crate::verdict::{Breach, Check, Judged, Stop};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, BusError, Health};
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

/// Delay of a frame to or from the tester above which a failure may be the tester's own. It equals the shortest wait by
/// which a case judges.
pub(crate) const HOST_LATE: Duration = Duration::from_millis(50);

/// The requirement on the tester's own machine, for reports of a violation.
pub(crate) const KEEPS_UP: &str = "the tester's machine keeps up";

/// The requirement on the device that its measured times reflect its clock, for reports of a violation.
pub(crate) const DEVICE_KEEPS_UP: &str = "the device keeps up";

/// Contents of a case's report beside its verdict.
#[derive(Debug, Default)]
pub(crate) struct Remains {
    /// The frames that were on the bus.
    pub evidence: Evidence,
    /// Other events: an unexpected EMCY, a value that could not be restored.
    pub notes: Vec<String>,
    /// Boot-up messages that no command explains.
    pub boots: Boots,
    /// The measurements.
    pub measurements: Vec<Measurement>,
    /// The objects that the case chose among several.
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

    /// Takes over the knowledge of another bench about the same device.
    pub(crate) fn learn(&mut self, knowledge: Knowledge) {
        self.knowledge = knowledge;
    }

    /// The knowledge about the device that holds in every run.
    pub(crate) fn into_knowledge(self) -> Knowledge {
        self.knowledge.of_firmware()
    }

    /// The node-ID of the device under test.
    pub fn node(&self) -> NodeId {
        self.target.node
    }

    /// The device under test, with the facts that are known of it.
    pub fn target(&self) -> &'a Target {
        self.target
    }

    /// The options of the test.
    pub fn options(&self) -> &'a Options {
        self.options
    }

    /// The maximum waits.
    pub fn timing(&self) -> Timing {
        self.options.timing
    }

    /// Time without a frame that counts as silence. It is longer for a device that answers more slowly.
    pub fn silence(&self) -> Duration {
        let slowest = self.knowledge.slowest_answer;
        self.timing().silence.max(slowest + Duration::from_nanos(slowest.nanos() / 4))
    }

    /// The time on the bus.
    pub fn now(&self) -> Timestamp {
        self.traffic.now()
    }

    /// The state of the bus and of the tester's own machine.
    pub fn health(&self) -> Health {
        self.traffic.health()
    }

    /// Whether the bus is a live one.
    pub fn is_live(&self) -> bool {
        self.traffic.is_live()
    }

    /// The bit rate of the bus in bit/s, if it is known.
    pub fn bit_rate(&self) -> Option<u32> {
        self.traffic.bit_rate()
    }

    /// Whether another client has sent anything to the device during the run.
    pub(crate) fn has_other_clients(&self) -> bool {
        !self.traffic.clients.messages_of_run().is_empty()
    }

    /// Changes the tester's own bit rate, in bit/s: the device is to be followed.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus does not work any more.
    pub(crate) fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), Stop> {
        self.try_bit_rate(bit_rate).map_err(|error| traffic::broken(&error))
    }

    /// Changes the tester's own bit rate, in bit/s, if this end of the bus can do that.
    pub(crate) fn try_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.traffic.set_bit_rate(bit_rate)
    }

    /// Time by which the bus alone may delay a frame, or shorten the interval to the next frame.
    pub(crate) fn bus_delay(&self) -> Duration {
        self.traffic.bus_delay()
    }

    /// The longest delay of the tester's machine so far, but at most [`HOST_LATE`]: a longer delay excuses the device
    /// altogether.
    pub(crate) fn host_delay(&self) -> Duration {
        self.traffic.host_delay()
    }

    /// Maximum time after a frame until the device has acted on it, if it acts at once: the reaction time of the
    /// options plus the delays of bus and host.
    pub fn shortly(&self) -> Duration {
        self.timing().reaction + self.bus_delay() + self.host_delay()
    }

    /// Maximum difference of a single period: the tolerance of the user plus the delay of the bus.
    pub fn tolerance(&self, period: Duration) -> Duration {
        self.timing().tolerance(period) + self.bus_delay()
    }

    /// The frames on the bus since the case began.
    pub fn evidence(&self) -> &Evidence {
        self.traffic.evidence()
    }

    /// The time that the case has taken so far.
    pub(crate) fn time_of_case(&self) -> Duration {
        let first = self.evidence().frames().next();
        first.map_or(Duration::ZERO, |first| self.now().since(first.record.timestamp))
    }

    /// Whether the run must end: the user has cancelled it, or its time is over.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.traffic.is_cancelled()
    }

    /// Records the breach of a check, and lets the case continue. If the rest of a case can't be judged after a breach,
    /// the case returns the breach with `?` instead.
    ///
    /// # Errors
    /// None. The type of the result lets a case end with this call.
    pub fn check(&mut self, check: Check) -> Judged {
        if let Err(breach) = check {
            self.record(*breach);
        }
        Ok(())
    }

    /// Runs a check for each of several subjects. After a breach of one subject the others are still judged.
    ///
    /// # Errors
    /// The reason that ends the case: the bus failed, or a precondition of one subject can't be reached.
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

    /// The breaches of the case so far; `last` is the breach that ended it.
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

    /// Names in the case's report the object that served it.
    pub(crate) fn uses(&mut self, multiplexer: Multiplexer, purpose: &'static str) {
        self.log.uses(Use { multiplexer, purpose });
    }

    /// Number of commands since the start of the run that made the device write its non-volatile memory.
    pub fn stores(&self) -> u32 {
        self.traffic.watch.stores()
    }

    /// Declares that the case provokes errors: the report then does not note EMCYs as unexpected.
    pub(crate) fn expect_emergencies(&mut self) {
        self.traffic.watch.expect_emergencies();
    }

    /// Begins a case: forgets all that belongs to the last case.
    pub(crate) fn begin(&mut self) {
        self.traffic.begin();
        self.log = CaseLog::default();
        self.knowledge.promptness.begin();
    }

    /// Ends a case: puts back its changes and returns the contents of its report.
    pub(crate) fn finish(&mut self) -> Remains {
        self.traffic.bear_lost_frames();
        self.make_server_idle();
        self.restore();
        let (noted, measurements, uses) = self.log.take();
        let emergencies = self.traffic.watch.emergencies().map(|(at, emcy)| format!("EMCY at {at} s: {emcy}"));
        let notes = emergencies.chain(noted).collect();
        let boots = self.traffic.watch.boots();
        Remains { evidence: self.traffic.take_evidence(), notes, boots, measurements, uses }
    }
}
