//! The object dictionary before a run and after it: what a device is left with.

use crate::behaviour::Changed;
use crate::zero_point::Moved;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;

/// All objects that could be read, before the first case and after the last one.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Comparison {
    /// Whether the device answered after the run: if not, nothing can be said of its values.
    pub is_complete: bool,
    /// How many objects could be read before or after.
    pub objects: usize,
    /// Those that differ, by rising index.
    pub changes: Vec<Change>,
    /// The commands that give the device its values again, in the order in which it takes them.
    pub commands: Vec<String>,
    /// Settings that a start brings with another value than before, by rising index: they are stored so.
    pub stored: Vec<Change>,
    /// Zero points that are not where they were: that in use, and that which a start brings.
    pub zero_points: Vec<Moved>,
    /// What the device does otherwise than before after a start.
    pub behaviour: Vec<Changed>,
}

/// An object whose value is another one than before.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Change {
    /// The object.
    pub multiplexer: Multiplexer,
    /// What the description calls it. Text of a file: may hold anything.
    pub name: Option<String>,
    /// Its type, by the description or the standard.
    pub data_type: Option<DataType>,
    /// Whose value it is.
    pub nature: Nature,
    /// The value before the run; `None` if it could not be read.
    pub before: Option<Vec<u8>>,
    /// The value after the run; `None` if it can't be read any more.
    pub after: Option<Vec<u8>>,
}

/// Whose an object's value is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Nature {
    /// It is written over the bus: the run has to leave it as it was.
    Setting,
    /// It never changes.
    Constant,
    /// The device sets it, whatever is tested: a position, an error register, a count.
    Own,
}

impl Nature {
    /// The word for it in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Setting => "setting",
            Self::Constant => "constant",
            Self::Own => "own",
        }
    }
}

impl Change {
    /// Whether the run has left something behind that it should not have.
    pub fn is_left(&self) -> bool {
        self.nature != Nature::Own
    }
}

impl Comparison {
    /// What the run has left changed.
    pub fn left(&self) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(|change| change.is_left())
    }

    /// The values that the device sets itself, as far as they differ.
    pub fn own(&self) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(|change| !change.is_left())
    }

    /// Whether the device is known to be as it was.
    pub fn is_as_found(&self) -> bool {
        self.is_complete
            && self.left().next().is_none()
            && self.stored.is_empty()
            && self.zero_points.iter().all(|moved| moved.is_denied)
            && self.behaviour.is_empty()
    }
}
