//! Sequences of frames: valid dialogues, dialogues with one mistake, and nonsense.
//!
//! The generator is a proptest strategy. Its value is the concrete list of frames, so that a finding can be replayed
//! without the generator. The value tree shrinks this list ([`super::shrink`]).

mod dice;
mod layer_setting;
mod lmt;
mod lss;
mod network;
mod pdo;
mod sdo;
mod target;
mod values;

use super::Knowledge;
use super::coverage::{Command, LssCommand, LssState, SdoState};
use super::limits;
use super::profile::Dialogue;
use super::shrink::SequenceTree;
use super::stimulus::{Sequence, Start, Stimulus, Then};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo as sdo_wire;
use canvass_suite::touch::Touch;
use canvass_traces::{CanId, Duration, Frame};
pub(super) use dice::Dice;
use proptest::strategy::{NewTree, Strategy};
use proptest::test_runner::TestRunner;
use std::collections::BTreeSet;
use std::sync::Arc;
pub use target::{Target, Targets, UnknownTarget};

/// The strategy that generates sequences for one device.
#[derive(Clone, Debug)]
pub struct Dialogues {
    /// The knowledge of the device.
    pub knowledge: Arc<Knowledge>,
    /// The services to fuzz.
    pub targets: Targets,
    /// The touches that the user allows.
    pub allow: BTreeSet<Touch>,
    /// Whether the test stand can provide the device without node-ID.
    pub unconfigured: bool,
    /// Whether long pauses take no real time, as on a simulated bus.
    pub patient: bool,
    /// The SDO state and command to be exercised next, as they came least often.
    pub focus: Option<(SdoState, Command)>,
    /// The LSS state and command to be exercised next, as they came least often.
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

/// On a live device only one pause in [`PAUSES_LIVE`] is made.
const PAUSES_LIVE: usize = 16;

/// Maximum number of frames in a sequence.
const LONGEST: usize = 48;

/// A sequence that is being generated.
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
            match self.plan.targets.draw(|shares| self.dice.below(shares)) {
                Target::Lss if self.knowledge().services.lmt => self.lmt_dialogue(),
                Target::Lss if self.is_for_lss() => self.lss_dialogue(),
                Target::Pdo => self.pdo_dialogue(),
                Target::Nmt => self.nmt_dialogue(),
                Target::SyncEmcy => self.sync_dialogue(),
                Target::Sdo | Target::Lss | Target::All => self.sdo_dialogue(),
            }
        }
    }

    /// Whether an LSS dialogue may come next. If SDO is fuzzed, too, LSS comes only at the beginning of a sequence and
    /// on a device without node-ID.
    fn is_for_lss(&self) -> bool {
        !self.plan.targets.contains(Target::Sdo)
            || self.sequence.stimuli.is_empty()
            || self.sequence.start == Start::Unconfigured
    }

    fn knowledge(&self) -> &'a Knowledge {
        &self.plan.knowledge
    }

    fn node(&self) -> u16 {
        u16::from(self.plan.knowledge.node.raw())
    }

    fn push(&mut self, frame: Frame, then: Then) {
        // The finished frame is checked, so that no random choice causes a touch that is not allowed.
        if limits::of(&frame, self.knowledge(), &self.plan.allow).is_none() {
            self.sequence.stimuli.push(Stimulus { frame, then });
        }
    }

    /// Adds a frame that the device gets time to answer. Now and then the next frame follows at once.
    fn ask(&mut self, frame: Frame) {
        let then = if self.dice.one_in(64) { Then::AtOnce } else { Then::Settle };
        self.push(frame, then);
    }

    fn pause(&mut self, milliseconds: u64) {
        // On a live device few dialogues wait, because waiting takes real time.
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

    /// Whether the user allows writing the object.
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

/// The interface by which a profile writes its dialogues.
impl Dialogue for Script<'_> {
    fn knowledge(&self) -> &Knowledge {
        Script::knowledge(self)
    }

    fn below(&mut self, n: usize) -> usize {
        self.dice.below(n)
    }

    fn number(&mut self) -> u64 {
        self.dice.number()
    }

    fn value_of(&mut self, at: Multiplexer) -> Option<u64> {
        let known = Script::knowledge(self).entry(at).filter(|known| known.writable)?;
        Some(Script::value_of(self, known))
    }

    fn ask(&mut self, request: sdo_wire::Request) {
        self.sdo(request);
    }
}
