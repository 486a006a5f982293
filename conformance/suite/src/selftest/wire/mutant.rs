//! Mutants: one error of a device on the bus, given by the message, its part, the change and the time.

use super::primitive::{Primitive, hyphened};
use canvass_analyzer::wire::Field;
use std::fmt;

/// A device that is right except for one change.
#[derive(Clone, Copy, Debug)]
pub struct Mutant {
    /// The changed message.
    pub primitive: Primitive,
    /// The change of the message.
    pub change: Change,
    /// The messages of this sort that are changed.
    pub when: When,
}

/// A change of a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Change {
    /// A field is changed.
    Field(Field, FieldChange),
    /// The frame as a whole is changed.
    Frame(FrameChange),
}

/// A change of a field.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FieldChange {
    /// All bits of the field are 0.
    Zero,
    /// All bits of the field are 1.
    Ones,
    /// The value is one higher.
    Plus,
    /// The value is one lower.
    Minus,
    /// The highest bit of the field is inverted.
    Flip,
    /// The field has its value from the previous message of the sort.
    Before,
    /// The field has its value from the last message of the sort about another object.
    Other,
}

/// A change of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FrameChange {
    /// The frame is not sent.
    Lost,
    /// The frame is sent twice.
    Doubled,
    /// The frame is sent [`super::filter::LATE`] later.
    Late,
    /// The previous frame is sent once more before the frame.
    Early,
    /// The next frame of the device is sent before the frame.
    Swapped,
    /// The frame has one byte less.
    Shorter,
    /// The frame has one byte more.
    Longer,
    /// The frame has no data bytes.
    Empty,
    /// The CAN-ID of the frame is one higher.
    IdPlus,
    /// The CAN-ID of the frame is one lower.
    IdMinus,
    /// The frame is a remote frame.
    Remote,
    /// The CAN-ID of the frame has 29 bits.
    Extended,
}

/// The messages of a sort that are changed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum When {
    /// The first message since the device was switched on.
    First,
    /// All messages.
    Every,
    /// The second message, the fourth and so on.
    EverySecond,
    /// The first message after each reset.
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
    /// Every change of every field and frame, at every time.
    pub fn all(primitives: &[Primitive]) -> Vec<Self> {
        primitives.iter().flat_map(|primitive| Self::of(*primitive)).collect()
    }

    fn of(primitive: Primitive) -> Vec<Self> {
        let has_object = primitive.layout.has_object();
        let of_field = |field: &Field| {
            let field = *field;
            let changes = FieldChange::ALL.into_iter().filter(move |(change, _)| {
                // All changes of a single bit have the same effect.
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
