//! The object dictionary before and after a run: the state in which the run leaves the device.

use crate::behaviour::Changed;
use crate::zero_point::Moved;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;

/// All objects that could be read, before the first case and after the last one.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Comparison {
    /// Whether the device answered after the run. If not, its values are unknown.
    pub is_complete: bool,
    /// Number of objects that could be read before or after the run.
    pub objects: usize,
    /// The objects that differ, by rising index.
    pub changes: Vec<Change>,
    /// The commands that give the device its earlier values again, in an order in which it accepts them.
    pub commands: Vec<String>,
    /// Settings whose stored value differs from the one before the run, by rising index.
    pub stored: Vec<Change>,
    /// Zero points that have moved: the one in use, and the one after a start.
    pub zero_points: Vec<Moved>,
    /// Differences in the behaviour of the device after a start.
    pub behaviour: Vec<Changed>,
}

/// An object whose value has changed.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Change {
    /// The object.
    pub multiplexer: Multiplexer,
    /// The name in the description. The text comes from a file: it may hold anything.
    pub name: Option<String>,
    /// The data type according to the description or the standard.
    pub data_type: Option<DataType>,
    /// How the value can change.
    pub nature: Nature,
    /// The value before the run; `None` if it could not be read.
    pub before: Option<Vec<u8>>,
    /// The value after the run; `None` if it can't be read any more.
    pub after: Option<Vec<u8>>,
}

/// How the value of an object can change. This decides whether the run must put it back.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Nature {
    /// The value is written over the bus: the run must leave it as it was.
    Setting,
    /// The value never changes.
    Constant,
    /// The device sets the value in any test: a position, an error register, a count.
    Own,
    /// The object acts when it is written, such as a preset: its earlier value is never written again.
    Acting,
}

impl Nature {
    /// The name of the nature in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Setting => "setting",
            Self::Constant => "constant",
            Self::Own => "own",
            Self::Acting => "acting",
        }
    }
}

impl Change {
    /// Whether the run has left a change that it should have put back.
    pub fn is_left(&self) -> bool {
        matches!(self.nature, Nature::Setting | Nature::Constant)
    }
}

impl Comparison {
    /// The changes that the run has left.
    pub fn left(&self) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(|change| change.is_left())
    }

    /// The changed values that the device sets itself.
    pub fn own(&self) -> impl Iterator<Item = &Change> {
        self.of(Nature::Own)
    }

    /// The changed values of objects that act when they are written.
    pub fn acting(&self) -> impl Iterator<Item = &Change> {
        self.of(Nature::Acting)
    }

    fn of(&self, nature: Nature) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(move |change| change.nature == nature)
    }

    /// Whether the device is known to be as before the run.
    pub fn is_as_found(&self) -> bool {
        self.is_complete
            && self.left().next().is_none()
            && self.stored.is_empty()
            && self.zero_points.iter().all(|moved| moved.is_denied)
            && self.behaviour.is_empty()
    }
}
