//! Plans for decoding the messages of a ROS schema: the steps through the bytes, with the role of each value.
//!
//! The encodings CDR and ROS 1 use the same plan; they differ in the layout of numbers and texts.

use super::fields::{Role, Shape, Values};
use super::ros_definition::{Count, Definitions, Field, FieldKind, Message};
use super::run::{self, Extent, Run};
use crate::damage::Flaw;
use crate::{Record, Timestamp};
use std::borrow::Cow;

/// Maximum depth of nested messages.
const DEEPEST: usize = 16;
/// Maximum number of steps of a plan: a hostile schema may square the number of steps with each level.
const MOST_STEPS: usize = 10_000;

/// The layout of values in an encoding. Every method returns `None` if the bytes end too early.
pub(crate) trait Layout<'a> {
    /// Reads a number of 1, 2, 4 or 8 bytes.
    fn number(&mut self, size: usize) -> Option<u64>;
    /// Skips `count` numbers of `size` bytes.
    fn skip_numbers(&mut self, size: usize, count: usize) -> Option<()>;
    /// Skips a text.
    fn skip_text(&mut self, wide: bool) -> Option<()>;
    /// Reads `count` bytes.
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]>;
    /// Reads a run of numbers: its bytes, and the position of each number in them.
    fn run<'r>(&mut self, run: &'r Run) -> Option<(&'a [u8], &'r Extent)>;
    /// The number of `size` bytes at the beginning of the bytes.
    fn placed(&self, bytes: &[u8], size: usize) -> Option<u64>;
}

/// A step through a message's bytes.
#[derive(Clone, Debug)]
pub(crate) enum McapStep {
    Number {
        size: usize,
        signed: bool,
        role: Option<Role>,
    },
    /// Several numbers that are read together.
    Run(Run),
    Text {
        wide: bool,
    },
    Data(Count),
    /// Numbers without a role.
    Numbers {
        size: usize,
        count: Count,
    },
    /// Texts or messages without a role. The body is never empty and takes at least one byte.
    Repeat {
        count: Count,
        body: Vec<McapStep>,
    },
}

/// The steps through the messages of a schema.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// The steps up to the last value with a role.
    steps: Vec<McapStep>,
    shape: Shape,
}

impl Plan {
    /// The plan for a schema; `None` if its messages are no CAN frames.
    pub(crate) fn new(definitions: &Definitions) -> Option<Self> {
        let messages = definitions.0.as_slice();
        let target = find(messages, 0, &mut vec![false; messages.len()])?;
        let mut compiler = Compiler { messages, target, found: false, timed: false, steps_left: MOST_STEPS };
        let mut steps = compiler.message(0, 0, true)?;
        let last = steps.iter().rposition(McapStep::has_role)?;
        steps.truncate(last + 1);
        let steps = run::joined(steps);
        Some(Self { steps, shape: shape(messages.get(target)?)? })
    }

    /// The frame of a message; its time is the message's own time stamp, else `logged`.
    #[inline]
    pub(crate) fn record<'a>(&self, layout: &mut impl Layout<'a>, logged: Timestamp) -> Result<Record, Flaw> {
        let mut values = Values::default();
        if self.steps.iter().try_for_each(|step| step.read(layout, &mut values)).is_none() {
            return Err(Flaw::malformed("a message as its schema says", "an end before its last field"));
        }
        values.record(&self.shape, logged)
    }
}

/// The message with the fields of a frame: the first message or, if it has none, one inside it.
fn find(messages: &[Message], place: usize, seen: &mut [bool]) -> Option<usize> {
    let message = messages.get(place)?;
    if std::mem::replace(seen.get_mut(place)?, true) {
        return None;
    }
    if shape(message).is_some() {
        return Some(place);
    }
    message.fields.iter().find_map(|field| match (field.kind, field.count) {
        (FieldKind::Message(inner), Count::One) => find(messages, inner, seen),
        _ => None,
    })
}

/// The frame format of a message with the fields of a frame; `None` for other messages.
fn shape(message: &Message) -> Option<Shape> {
    let roles: Vec<_> = message.fields.iter().filter_map(|field| Some((role(field)?, field))).collect();
    let of = |wanted| roles.iter().find(|(role, _)| *role == wanted).map(|(_, field)| field);
    of(Role::Id)?;
    let capacity = match of(Role::Data)?.count {
        Count::Array(n) => Some(n),
        Count::Sequence(bound) => bound,
        Count::One => None,
    };
    let has_length = of(Role::Dlc).is_some() || of(Role::Length).is_some();
    let shape = Shape { named_fd: Shape::is_named_fd(&message.name), capacity, has_length };
    shape.is_can(&message.name).then_some(shape)
}

/// The role of a field, if its name has one and its type fits.
fn role(field: &Field) -> Option<Role> {
    let role = Role::by_name(&field.name)?;
    let fits = match (role, field.kind, field.count) {
        (Role::Data, FieldKind::Number { size: 1, .. }, Count::Array(_) | Count::Sequence(_)) => true,
        (Role::Data, ..) => false,
        (_, FieldKind::Number { .. }, Count::One) => true,
        _ => false,
    };
    fits.then_some(role)
}

struct Compiler<'a> {
    messages: &'a [Message],
    /// The message with the fields of the frame; its first occurrence counts.
    target: usize,
    found: bool,
    /// Whether a time stamp has been found.
    timed: bool,
    steps_left: usize,
}

impl Compiler<'_> {
    /// The steps through a message; `None` if it is too large. `on_path`: whether this message or an enclosing one
    /// may be the target.
    fn message(&mut self, place: usize, depth: usize, on_path: bool) -> Option<Vec<McapStep>> {
        if depth > DEEPEST {
            return None;
        }
        let is_target = on_path && place == self.target && !self.found;
        self.found |= is_target;
        let mut steps = Vec::new();
        for field in &self.messages.get(place)?.fields {
            self.steps_left = self.steps_left.checked_sub(1)?;
            let time = on_path && !self.timed && self.is_time(field);
            match (field.kind, field.count) {
                (_, Count::Array(0)) => {}
                (FieldKind::Number { size, signed }, Count::One) => {
                    let role = if is_target { role(field) } else { None };
                    steps.push(McapStep::Number { size, signed, role });
                }
                (FieldKind::Number { .. }, count) if is_target && role(field) == Some(Role::Data) => {
                    steps.push(McapStep::Data(count));
                }
                (FieldKind::Number { size, .. }, count) => steps.push(McapStep::Numbers { size, count }),
                (FieldKind::Text, count) => repeat(&mut steps, count, vec![McapStep::Text { wide: false }]),
                (FieldKind::WideText, count) => repeat(&mut steps, count, vec![McapStep::Text { wide: true }]),
                (FieldKind::Message(inner), _) if time => steps.extend(self.time(inner)?),
                (FieldKind::Message(inner), Count::One) => steps.extend(self.message(inner, depth + 1, on_path)?),
                (FieldKind::Message(inner), count) => {
                    let body = self.message(inner, depth + 1, false)?;
                    repeat(&mut steps, count, body);
                }
            }
        }
        Some(steps)
    }

    /// Whether the field is a point in time: `stamp`, in a header or beside the frame's fields.
    fn is_time(&self, field: &Field) -> bool {
        let FieldKind::Message(inner) = field.kind else { return false };
        let parts = self.messages.get(inner).map_or(&[][..], |message| &message.fields);
        field.count == Count::One
            && Role::is_time(&field.name)
            && parts.len() == 2
            && parts
                .iter()
                .all(|part| matches!(part.kind, FieldKind::Number { .. }) && Role::of_time(&part.name).is_some())
    }

    fn time(&mut self, place: usize) -> Option<Vec<McapStep>> {
        self.timed = true;
        let steps = self.messages.get(place)?.fields.iter().map(|field| match field.kind {
            FieldKind::Number { size, signed } => {
                Some(McapStep::Number { size, signed, role: Role::of_time(&field.name) })
            }
            _ => None,
        });
        steps.collect()
    }
}

fn repeat(steps: &mut Vec<McapStep>, count: Count, body: Vec<McapStep>) {
    match count {
        _ if body.is_empty() && !matches!(count, Count::Sequence(_)) => {}
        Count::One => steps.extend(body),
        count => steps.push(McapStep::Repeat { count, body }),
    }
}

impl McapStep {
    fn has_role(&self) -> bool {
        matches!(self, Self::Number { role: Some(_), .. } | Self::Data(_))
    }

    #[inline]
    pub(crate) fn read<'a>(&self, layout: &mut impl Layout<'a>, values: &mut Values<'a>) -> Option<()> {
        match self {
            Self::Number { size, signed, role } => {
                let number = layout.number(*size)?;
                if let Some(role) = role {
                    values.set(*role, if *signed { sign_extended(number, *size) } else { number as i64 });
                }
            }
            Self::Run(run) => run.read(layout, values)?,
            Self::Text { wide } => layout.skip_text(*wide)?,
            Self::Data(count) => {
                let count = counted(layout, *count)?;
                values.data = Cow::Borrowed(layout.bytes(count)?);
            }
            Self::Numbers { size, count } => {
                let count = counted(layout, *count)?;
                layout.skip_numbers(*size, count)?;
            }
            Self::Repeat { count, body } => {
                let count = counted(layout, *count)?;
                // Each repetition takes at least one byte, so the end of the bytes limits a hostile count.
                for _ in 0..if body.is_empty() { 0 } else { count } {
                    body.iter().try_for_each(|step| step.read(layout, values))?;
                }
            }
        }
        Some(())
    }
}

#[inline]
fn counted<'a>(layout: &mut impl Layout<'a>, count: Count) -> Option<usize> {
    match count {
        Count::One => Some(1),
        Count::Array(n) => Some(n),
        Count::Sequence(_) => usize::try_from(layout.number(4)?).ok(),
    }
}

/// Converts the lowest `size` bytes to a signed number.
pub(crate) const fn sign_extended(number: u64, size: usize) -> i64 {
    let unused = 64 - 8 * size as u32;
    (number << unused) as i64 >> unused
}
