//! One wrong thing that a device does on the bus: which message, what of it, how, and when.

use super::primitive::{Primitive, hyphened};
use canvass_analyzer::wire::Field;
use std::fmt;

/// A device that is right, but for this.
#[derive(Clone, Copy, Debug)]
pub struct Mutant {
    /// The message.
    pub primitive: Primitive,
    /// What is wrong with it.
    pub change: Change,
    /// Which of its messages.
    pub when: When,
}

/// What is wrong with a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Change {
    /// A field.
    Field(Field, FieldChange),
    /// The frame as a whole.
    Frame(FrameChange),
}

/// What becomes of a field.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FieldChange {
    /// All its bits are 0.
    Zero,
    /// All its bits are 1.
    Ones,
    /// One more.
    Plus,
    /// One less.
    Minus,
    /// Its highest bit is the other one.
    Flip,
    /// That of the message of its sort before.
    Before,
    /// That of the last message of its sort about another object.
    Other,
}

/// What becomes of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FrameChange {
    /// It is not sent.
    Lost,
    /// It is sent twice.
    Doubled,
    /// It is sent [`super::filter::LATE`] later.
    Late,
    /// The one before is sent once more, ahead of it.
    Early,
    /// The next frame of the device goes first.
    Swapped,
    /// It has a byte less.
    Shorter,
    /// It has a byte more.
    Longer,
    /// It has no byte.
    Empty,
    /// Its CAN-ID is one more.
    IdPlus,
    /// Its CAN-ID is one less.
    IdMinus,
    /// It is a remote frame.
    Remote,
    /// Its CAN-ID has 29 bits.
    Extended,
}

/// Which messages of its sort are wrong.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum When {
    /// The first since the device was switched on.
    First,
    /// All.
    Every,
    /// The second, the fourth and so on.
    EverySecond,
    /// The first after each reset.
    AfterReset,
}

impl FieldChange {
    const ALL: [(Self, &'static str); 7] = [
        (Self::Zero, "zero"),
        (Self::Ones, "ones"),
        (Self::Plus, "plus"),
        (Self::Minus, "minus"),
        (Self::Flip, "flip"),
        (Self::Before, "before"),
        (Self::Other, "other"),
    ];
}

impl FrameChange {
    const ALL: [(Self, &'static str); 12] = [
        (Self::Lost, "lost"),
        (Self::Doubled, "doubled"),
        (Self::Late, "late"),
        (Self::Early, "early"),
        (Self::Swapped, "swapped"),
        (Self::Shorter, "shorter"),
        (Self::Longer, "longer"),
        (Self::Empty, "empty"),
        (Self::IdPlus, "id-plus"),
        (Self::IdMinus, "id-minus"),
        (Self::Remote, "remote"),
        (Self::Extended, "extended"),
    ];
}

impl When {
    const ALL: [(Self, &'static str); 4] = [
        (Self::First, "first"),
        (Self::Every, "every"),
        (Self::EverySecond, "every-second"),
        (Self::AfterReset, "after-reset"),
    ];
}

impl Mutant {
    /// Every change of every field and frame, at all times.
    pub fn all(primitives: &[Primitive]) -> Vec<Self> {
        primitives.iter().flat_map(|primitive| Self::of(*primitive)).collect()
    }

    fn of(primitive: Primitive) -> Vec<Self> {
        let has_object = primitive.layout.has_object();
        let of_field = |field: &Field| {
            let field = *field;
            let changes = FieldChange::ALL.into_iter().filter(move |(change, _)| {
                // Of a single bit all that changes it is the same.
                let is_new =
                    field.bits > 1 || matches!(change, FieldChange::Zero | FieldChange::Ones | FieldChange::Flip);
                is_new && (has_object || *change != FieldChange::Other)
            });
            changes.map(move |(change, _)| Change::Field(field, change))
        };
        let of_fields = primitive.layout.fields.iter().flat_map(of_field);
        let changes = of_fields.chain(FrameChange::ALL.into_iter().map(|(change, _)| Change::Frame(change)));
        changes
            .flat_map(|change| When::ALL.into_iter().map(move |(when, _)| Self { primitive, change, when }))
            .collect()
    }
}

fn name_of<T: PartialEq>(all: &[(T, &'static str)], one: &T) -> &'static str {
    all.iter().find(|(known, _)| known == one).map_or("", |(_, name)| name)
}

/// `sdo/initiate-download/command-specifier/zero/every`.
impl fmt::Display for Mutant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let when = name_of(&When::ALL, &self.when);
        match &self.change {
            Change::Field(field, change) => {
                let change = name_of(&FieldChange::ALL, change);
                let (name, first) = (hyphened(field.name), field.first);
                // A message may have several reserved fields.
                let place = if field.is_reserved() { format!("-{first}") } else { String::new() };
                write!(f, "{}/{name}{place}/{change}/{when}", self.primitive.id())
            }
            Change::Frame(change) => {
                write!(f, "{}/frame/{}/{when}", self.primitive.id(), name_of(&FrameChange::ALL, change))
            }
        }
    }
}
