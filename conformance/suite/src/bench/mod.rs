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

mod answers;
mod attempt;
pub mod block;
mod decoder;
mod dictionary;
mod evidence;
mod features;
mod foreign;
mod measurement;
pub mod nmt;
pub mod objects;
pub mod pdo;
mod presence;
mod restore;
mod rewrite;
pub mod sdo;
pub mod state;
mod target;
mod traffic;
mod watch;

pub use decoder::Decoder;
pub use evidence::{Annotate, Evidence, Exhibit};
pub(crate) use foreign::Foreign;
pub use measurement::{Measurement, Unit, percentile};
pub use target::{Deviation, Options, Target, Timing};
pub use traffic::{Sent, is_from};

use crate::need::Found;
use crate::verdict::{Breach, Check, Judged, Reason, Stop};
use canvass_analyzer::NodeId;
use canvass_bus::{Bus, Health};
use canvass_traces::{Duration, Timestamp};
use rewrite::Original;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use watch::Watch;

/// The bus, the device under test, and what happens between them while a case runs.
pub struct Bench<'a> {
    bus: &'a mut dyn Bus,
    target: &'a Target,
    options: &'a Options,
    annotate: &'a mut dyn Annotate,
    cancel: &'a AtomicBool,
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
    /// Waits end at once when the user cancels, except while things are being put back.
    restoring: bool,
    /// The case did not come to its own end, nor to the putting right that belongs to it.
    ended_early: bool,
    foreign: Foreign,
    /// The case in which the device left the bus, if it did not come back.
    gone: Option<&'static str>,
    /// While a case runs: how many frames were lost before it.
    lost_before: Option<u64>,
    /// Frames taken since then.
    taken: u64,
    knowledge: Knowledge,
}

/// What was found out about the device, and need not be found out again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Knowledge {
    features: BTreeMap<&'static str, Found>,
    starts_by_itself: Option<bool>,
    heartbeats: Option<state::Heartbeats>,
    /// Other nodes were looked for.
    others_known: bool,
}

/// What a case leaves behind for its report.
#[derive(Debug)]
pub struct Remains {
    /// The frames that were on the bus.
    pub evidence: Evidence,
    /// What else happened: an EMCY nobody asked for, a value that could not be restored.
    pub notes: Vec<String>,
    /// The device restarted without being told to.
    pub restarted: Option<Timestamp>,
    /// What was measured.
    pub measurements: Vec<Measurement>,
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
            restoring: false,
            ended_early: false,
            foreign: Foreign::default(),
            gone: None,
            lost_before: None,
            taken: 0,
            knowledge: Knowledge::default(),
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

    /// By how much a single period may differ: what the user tolerates, and what the bus itself takes.
    pub fn tolerance(&self, period: Duration) -> Duration {
        self.timing().tolerance(period) + self.bus_delay()
    }

    /// What was on the bus since the case began.
    pub fn evidence(&self) -> &Evidence {
        &self.evidence
    }

    /// Whether the user has cancelled the run.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
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
        self.foreign = Foreign::default();
        self.measurements.clear();
        self.watch.forget();
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
        if std::mem::take(&mut self.ended_early) {
            self.store_again();
        }
        let notes = self.watch.emergencies().map(|(at, emcy)| format!("EMCY at {at} s: {emcy}"));
        let notes: Vec<String> = notes.collect::<Vec<_>>().into_iter().chain(self.notes.drain(..)).collect();
        let measurements = std::mem::take(&mut self.measurements);
        let evidence = std::mem::take(&mut self.evidence);
        Remains { evidence, notes, restarted: self.watch.restarted(), measurements }
    }

    fn check_cancelled(&self) -> Result<(), Stop> {
        if self.is_cancelled() && !self.restoring {
            let reason = Reason::new("the case runs to its end", "no interruption", "the run was cancelled");
            return Err(Stop::Inconclusive(reason));
        }
        Ok(())
    }
}
