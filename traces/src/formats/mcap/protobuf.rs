//! Messages in Protocol Buffers. The schema is a `FileDescriptorSet`: a Protocol Buffers message itself, of which this
//! module reads only the fields' names, numbers and types.
//!
//! An absent field has the value 0. The data is `bytes` or `repeated uint32`.

use super::fields::{Role, Shape, Values};
use crate::damage::Flaw;
use std::borrow::Cow;
use std::collections::HashMap;

/// Maximum depth of nested messages.
const DEEPEST: usize = 8;
/// Maximum number of fields read from a schema.
const MOST_FIELDS: usize = 10_000;

/// The value of a field, as it is encoded.
#[derive(Clone, Copy, Debug)]
enum Wire<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

fn varint(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let mut number = 0u64;
    for (n, byte) in bytes.iter().enumerate().take(10) {
        number |= u64::from(byte & 0x7F).checked_shl(7 * n as u32)?;
        if byte & 0x80 == 0 {
            return Some((number, bytes.get(n + 1..)?));
        }
    }
    None
}

/// Parses the next field: its number and value, and the rest of the bytes.
fn field(bytes: &[u8]) -> Option<(u64, Wire<'_>, &[u8])> {
    let (key, bytes) = varint(bytes)?;
    let (value, rest) = match key & 7 {
        0 => varint(bytes).map(|(number, rest)| (Wire::Number(number), rest))?,
        1 => bytes.split_first_chunk().map(|(number, rest)| (Wire::Number(u64::from_le_bytes(*number)), rest))?,
        2 => {
            let (length, bytes) = varint(bytes)?;
            let (value, rest) = bytes.split_at_checked(usize::try_from(length).ok()?)?;
            (Wire::Bytes(value), rest)
        }
        5 => {
            bytes.split_first_chunk().map(|(number, rest)| (Wire::Number(u32::from_le_bytes(*number).into()), rest))?
        }
        _ => return None,
    };
    Some((key >> 3, value, rest))
}

/// Calls `each` for each field; `None` if the bytes are malformed.
fn for_each_field<'a>(mut bytes: &'a [u8], mut each: impl FnMut(u64, Wire<'a>) -> Option<()>) -> Option<()> {
    while !bytes.is_empty() {
        let (number, value, rest) = field(bytes)?;
        each(number, value)?;
        bytes = rest;
    }
    Some(())
}

/// A field as a schema describes it.
#[derive(Clone, Debug, Default)]
struct Field<'a> {
    name: &'a str,
    number: u64,
    repeated: bool,
    /// The type, as in `FieldDescriptorProto.Type`.
    kind: u64,
    /// The full name of a message field's type, without the leading dot.
    type_name: &'a str,
}

const TYPE_STRING: u64 = 9;
const TYPE_MESSAGE: u64 = 11;
const TYPE_BYTES: u64 = 12;

/// The schema's messages by their full names.
type Messages<'a> = HashMap<String, Vec<Field<'a>>>;

fn text(value: Wire<'_>) -> Option<&str> {
    match value {
        Wire::Bytes(bytes) => std::str::from_utf8(bytes).ok(),
        Wire::Number(_) => None,
    }
}

/// Parses a `FileDescriptorSet`: its field 1 are the files; of a file, field 2 is the package and field 4 the messages.
fn messages(set: &[u8]) -> Option<Messages<'_>> {
    let mut messages = HashMap::new();
    for_each_field(set, |number, file| {
        let (1, Wire::Bytes(file)) = (number, file) else { return Some(()) };
        let mut package = "";
        for_each_field(file, |number, value| {
            if number == 2 {
                package = text(value)?;
            }
            Some(())
        })?;
        for_each_field(file, |number, value| match (number, value) {
            (4, Wire::Bytes(descriptor)) => message(package, descriptor, 0, &mut messages),
            _ => Some(()),
        })
    })?;
    Some(messages)
}

/// Parses a `DescriptorProto`: name 1, fields 2, nested messages 3.
fn message<'a>(scope: &str, descriptor: &'a [u8], depth: usize, messages: &mut Messages<'a>) -> Option<()> {
    let (mut name, mut fields, mut inner) = ("", Vec::new(), Vec::new());
    for_each_field(descriptor, |number, value| {
        match (number, value) {
            (1, value) => name = text(value)?,
            (2, Wire::Bytes(descriptor)) => fields.push(describe(descriptor)?),
            (3, Wire::Bytes(descriptor)) => inner.push(descriptor),
            _ => {}
        }
        Some(())
    })?;
    let name = if scope.is_empty() { name.to_owned() } else { format!("{scope}.{name}") };
    if depth < DEEPEST {
        inner.into_iter().try_for_each(|descriptor| message(&name, descriptor, depth + 1, messages))?;
    }
    messages.insert(name, fields);
    Some(())
}

/// Parses a `FieldDescriptorProto`: name 1, number 3, label 4 (3 is repeated), type 5, name of the type 6.
fn describe(descriptor: &[u8]) -> Option<Field<'_>> {
    let mut field = Field::default();
    for_each_field(descriptor, |number, value| {
        match (number, value) {
            (1, value) => field.name = text(value)?,
            (3, Wire::Number(number)) => field.number = number,
            (4, Wire::Number(label)) => field.repeated = label == 3,
            (5, Wire::Number(kind)) => field.kind = kind,
            (6, value) => field.type_name = text(value)?.trim_start_matches('.'),
            _ => {}
        }
        Some(())
    })?;
    Some(field)
}

/// The use of a message's field, by its number.
#[derive(Clone, Debug)]
enum Use {
    Value(Role),
    /// Data as repeated numbers, one by one or packed.
    Numbers,
    Message(Plan),
}

/// The fields that have a use, by their numbers.
type Plan = Vec<(u64, Use)>;

/// The plan for reading the messages of a protobuf channel.
#[derive(Clone, Debug)]
pub(crate) struct ProtobufPlan {
    plan: Plan,
    shape: Shape,
}

impl ProtobufPlan {
    /// The plan for a schema; `None` if its messages are no CAN frames, or it can't be read.
    pub(crate) fn new(name: &str, schema: &[u8]) -> Option<Self> {
        let messages = messages(schema)?;
        let (target, shape) = find(&messages, name)?;
        let mut compiler = Compiler { messages: &messages, target: &target, timed: false, fields_left: MOST_FIELDS };
        let plan = compiler.message(name, 0)?;
        Some(Self { plan, shape })
    }

    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The values of a message.
    pub(crate) fn read<'a>(&self, message: &'a [u8]) -> Result<Values<'a>, Flaw> {
        let mut values = Values::default();
        match read(&self.plan, message, &mut values) {
            Some(()) => Ok(values),
            None => Err(Flaw::malformed("a protobuf message as its schema says", format!("{} bytes", message.len()))),
        }
    }
}

fn role(field: &Field<'_>) -> Option<Role> {
    let role = Role::by_name(field.name)?;
    let is_number = !field.repeated && !matches!(field.kind, TYPE_STRING | TYPE_MESSAGE | TYPE_BYTES);
    let is_data = if field.repeated {
        !matches!(field.kind, TYPE_STRING | TYPE_MESSAGE | TYPE_BYTES)
    } else {
        field.kind == TYPE_BYTES
    };
    (if role == Role::Data { is_data } else { is_number }).then_some(role)
}

fn shape(name: &str, fields: &[Field<'_>]) -> Option<Shape> {
    let has = |wanted| fields.iter().any(|field| role(field) == Some(wanted));
    let has_length = has(Role::Dlc) || has(Role::Length);
    let shape = Shape { named_fd: Shape::is_named_fd(name), capacity: None, has_length };
    (has(Role::Id) && has(Role::Data) && shape.is_can(name)).then_some(shape)
}

/// The message with the fields of a frame: the message of that name, or one directly inside it.
fn find(messages: &Messages<'_>, name: &str) -> Option<(String, Shape)> {
    let fields = messages.get(name)?;
    if let Some(shape) = shape(name, fields) {
        return Some((name.to_owned(), shape));
    }
    let inner = fields.iter().filter(|field| field.kind == TYPE_MESSAGE && !field.repeated);
    inner
        .filter_map(|field| Some((field.type_name.to_owned(), shape(field.type_name, messages.get(field.type_name)?)?)))
        .next()
}

struct Compiler<'a> {
    messages: &'a Messages<'a>,
    /// The message with the fields of the frame.
    target: &'a str,
    /// Whether a time stamp has been found.
    timed: bool,
    /// Number of fields still allowed: a hostile schema may multiply its fields with each level.
    fields_left: usize,
}

impl Compiler<'_> {
    /// The plan for a message: values in the target, time stamps up to two levels deep.
    fn message(&mut self, name: &str, depth: usize) -> Option<Plan> {
        let messages = self.messages;
        let mut plan = Vec::new();
        for field in messages.get(name)? {
            self.fields_left = self.fields_left.checked_sub(1)?;
            let is_message = field.kind == TYPE_MESSAGE && !field.repeated;
            if let (true, Some(role)) = (name == self.target, role(field)) {
                plan.push((field.number, if field.repeated { Use::Numbers } else { Use::Value(role) }));
            } else if is_message && !self.timed && Role::is_time(field.name) {
                self.timed = true;
                let parts = messages.get(field.type_name)?.iter();
                let parts =
                    parts.filter_map(|part| Some((part.number, Use::Value(Role::of_time(part.name)?)))).collect();
                plan.push((field.number, Use::Message(parts)));
            } else if is_message && depth < 2 && messages.contains_key(field.type_name) {
                plan.push((field.number, Use::Message(self.message(field.type_name, depth + 1)?)));
            }
        }
        Some(plan)
    }
}

fn read<'a>(plan: &Plan, message: &'a [u8], values: &mut Values<'a>) -> Option<()> {
    for_each_field(message, |number, value| {
        let Some((_, action)) = plan.iter().find(|(known, _)| *known == number) else { return Some(()) };
        match (action, value) {
            (Use::Value(Role::Data), Wire::Bytes(bytes)) => values.data = Cow::Borrowed(bytes),
            (Use::Numbers, Wire::Number(byte)) => values.data.to_mut().push(u8::try_from(byte).ok()?),
            (Use::Numbers, Wire::Bytes(mut packed)) => {
                while !packed.is_empty() {
                    let (byte, rest) = varint(packed)?;
                    values.data.to_mut().push(u8::try_from(byte).ok()?);
                    packed = rest;
                }
            }
            (Use::Value(role), Wire::Number(number)) => values.set(*role, number as i64),
            (Use::Message(inner), Wire::Bytes(message)) => read(inner, message, values)?,
            _ => return None,
        }
        Some(())
    })
}
