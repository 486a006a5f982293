//! Sequences of frames: valid dialogues, dialogues with one thing wrong, and nonsense.
//!
//! A proptest strategy. The value is the concrete list of frames, so that what was found can be replayed without the
//! generator; the tree shrinks that list ([`super::shrink`]).

mod dice;
mod lmt;
mod lss;
mod network;
mod pdo;
mod sdo;
mod values;

use super::Knowledge;
use super::coverage::{Command, LssCommand, LssState, SdoState};
use super::limits;
use super::shrink::SequenceTree;
use super::stimulus::{Sequence, Start, Stimulus, Then};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::{lss as lss_wire, sdo as sdo_wire};
use canvass_suite::touch::Touch;
use canvass_traces::{CanId, Duration, Frame};
pub(super) use dice::Dice;
use proptest::strategy::{NewTree, Strategy};
use proptest::test_runner::TestRunner;
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// Which services are fuzzed.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Target {
    /// The SDO server.
    Sdo,
    /// The LSS slave.
    Lss,
    /// NMT and error control.
    Nmt,
    /// PDOs and their configuration.
    Pdo,
    /// SYNC, EMCY, heartbeat consumer.
    SyncEmcy,
    /// All of them, interleaved.
    #[default]
    All,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 6] = [Self::Sdo, Self::Lss, Self::Nmt, Self::Pdo, Self::SyncEmcy, Self::All];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sdo => "sdo",
            Self::Lss => "lss",
            Self::Nmt => "nmt",
            Self::Pdo => "pdo",
            Self::SyncEmcy => "sync-emcy",
            Self::All => "all",
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is no target of that name.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no target is called \"{0}\": there are sdo, lss, nmt, pdo, sync-emcy and all")]
pub struct UnknownTarget(pub String);

impl FromStr for Target {
    type Err = UnknownTarget;

    fn from_str(name: &str) -> Result<Self, UnknownTarget> {
        Self::ALL.into_iter().find(|target| target.name() == name).ok_or_else(|| UnknownTarget(name.to_owned()))
    }
}

/// The strategy: sequences for one device.
#[derive(Clone, Debug)]
pub struct Dialogues {
    /// The device.
    pub knowledge: Arc<Knowledge>,
    /// The services.
    pub target: Target,
    /// What the sequences may do beyond what leaves no trace.
    pub allow: BTreeSet<Touch>,
    /// Whether a device without node-ID can be had.
    pub unconfigured: bool,
    /// Whether a wait of seconds costs nothing.
    pub patient: bool,
    /// The combination of SDO state and command that was exercised least.
    pub focus: Option<(SdoState, Command)>,
    /// That of LSS.
    pub lss_focus: Option<(LssState, LssCommand)>,
}

impl Strategy for Dialogues {
    type Tree = SequenceTree;
    type Value = Sequence;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let mut script = Script::new(self, Dice::new(runner.rng()));
        script.write();
        Ok(SequenceTree::new(script.sequence))
    }
}

/// On a device that goes on, one pause in so many is made.
const PAUSES_LIVE: usize = 16;

/// The most frames of a sequence.
const LONGEST: usize = 48;

/// A sequence that is being written.
struct Script<'a> {
    plan: &'a Dialogues,
    dice: Dice<'a>,
    sequence: Sequence,
}

impl<'a> Script<'a> {
    fn new(plan: &'a Dialogues, dice: Dice<'a>) -> Self {
        let sequence = Sequence { start: Start::Configured, stimuli: Vec::with_capacity(LONGEST) };
        Self { plan, dice, sequence }
    }

    fn write(&mut self) {
        let dialogues = 1 + self.dice.below(8);
        for _ in 0..dialogues {
            if self.sequence.stimuli.len() >= LONGEST {
                break;
            }
            match self.plan.target {
                Target::Sdo => self.sdo_dialogue(),
                Target::Lss if self.knowledge().services.lmt => self.lmt_dialogue(),
                Target::Lss => self.lss_dialogue(),
                Target::Nmt => self.nmt_dialogue(),
                Target::Pdo => self.pdo_dialogue(),
                Target::SyncEmcy => self.sync_dialogue(),
                Target::All => match self.dice.below(12) {
                    0..=5 => self.sdo_dialogue(),
                    6 | 7 => self.pdo_dialogue(),
                    8 => self.nmt_dialogue(),
                    9 => self.sync_dialogue(),
                    _ if self.knowledge().services.lmt => self.lmt_dialogue(),
                    _ if self.sequence.stimuli.is_empty() || self.sequence.start == Start::Unconfigured => {
                        self.lss_dialogue();
                    }
                    _ => self.sdo_dialogue(),
                },
            }
        }
    }

    fn knowledge(&self) -> &'a Knowledge {
        &self.plan.knowledge
    }

    fn node(&self) -> u16 {
        u16::from(self.plan.knowledge.node.raw())
    }

    fn push(&mut self, frame: Frame, then: Then) {
        // Checked on the finished frame, so that no chance leads there.
        if limits::of(&frame, self.knowledge(), &self.plan.allow).is_none() {
            self.sequence.stimuli.push(Stimulus { frame, then });
        }
    }

    /// A frame that the device gets time to answer; now and then the next one follows at once.
    fn ask(&mut self, frame: Frame) {
        let then = if self.dice.one_in(64) { Then::AtOnce } else { Then::Settle };
        self.push(frame, then);
    }

    fn pause(&mut self, milliseconds: u64) {
        // Where waiting takes the time of people, few dialogues wait: the others go on at once.
        if !self.plan.patient && !self.dice.one_in(PAUSES_LIVE) {
            return;
        }
        if let Some(last) = self.sequence.stimuli.last_mut() {
            last.then = Then::Pause(Duration::from_millis(milliseconds));
        }
    }

    fn sdo(&mut self, request: sdo_wire::Request) {
        let frame = request.to_frame(sdo_wire::REQUEST_BASE + self.node());
        self.ask(frame);
    }

    fn lss(&mut self, request: lss_wire::Request) {
        self.ask(request.to_frame(lss_wire::MASTER_CAN_ID));
    }

    /// Whether the object may be written.
    fn may_write(&self, at: Multiplexer) -> bool {
        limits::writing(at, self.knowledge(), &self.plan.allow).is_none()
    }

    fn standard(id: u16) -> CanId {
        CanId::standard_masked(u32::from(id))
    }

    fn data(id: u16, bytes: &[u8]) -> Frame {
        let id = Self::standard(id);
        Frame::new(id, &bytes[..bytes.len().min(8)]).unwrap_or_else(|| Frame::full(id, [0; 8]))
    }
}
