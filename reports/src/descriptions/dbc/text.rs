//! The text of a DBC file.

use super::{Message, Signal};
use canvass_analyzer::{Number, PdoNumber};
use std::fmt::Write;

/// The sender or receiver that stands for all other nodes.
const NOBODY: &str = "Vector__XXX";
/// The bit that marks an identifier of 29 bits.
const EXTENDED: u32 = 1 << 31;

pub(super) fn render(node: &str, messages: &[Message]) -> Vec<u8> {
    let mut text = format!("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {node}\n");
    // Writing to a string can't fail.
    for message in messages {
        let sender = if is_sent(message) { node } else { NOBODY };
        let _ = write!(text, "\nBO_ {} {}: {} {sender}\n", frame_id(message), message.name, message.length);
        for signal in &message.signals {
            self::signal(&mut text, signal, if is_sent(message) { NOBODY } else { node });
        }
    }
    text.push('\n');
    for message in messages {
        let id = frame_id(message);
        let _ = writeln!(text, "CM_ BO_ {id} \"{}\";", string(&message.comment));
        for signal in &message.signals {
            let _ = writeln!(text, "CM_ SG_ {id} {} \"{}\";", signal.name, string(&signal.comment));
        }
    }
    for message in messages {
        for signal in &message.signals {
            let kind = match signal.kind {
                Number::Real32(_) => 1,
                Number::Real64(_) => 2,
                Number::Boolean(_) | Number::Integer(_) | Number::Unsigned(_) => continue,
            };
            let _ = writeln!(text, "SIG_VALTYPE_ {} {} : {kind};", frame_id(message), signal.name);
        }
    }
    windows_1252(&text)
}

fn signal(text: &mut String, signal: &Signal, receiver: &str) {
    let sign = match signal.kind {
        Number::Boolean(_) | Number::Unsigned(_) => '+',
        Number::Integer(_) | Number::Real32(_) | Number::Real64(_) => '-',
    };
    let (factor, offset) = signal.unit.as_ref().map_or((1.0, 0.0), |unit| (unit.factor, unit.offset));
    let (low, high) = signal.limits.unwrap_or((0.0, 0.0));
    let unit = signal.unit.as_ref().map(|unit| string(&unit.symbol)).unwrap_or_default();
    let Signal { name, offset: first, bits, .. } = signal;
    // "@1" means the lowest bit first, as in CANopen.
    let _ =
        writeln!(text, " SG_ {name} : {first}|{bits}@1{sign} ({factor},{offset}) [{low}|{high}] \"{unit}\" {receiver}");
}

const fn is_sent(message: &Message) -> bool {
    matches!(message.pdo, PdoNumber::Transmit(_))
}

const fn frame_id(message: &Message) -> u32 {
    message.cob_id.can_id() | if message.cob_id.is_extended() { EXTENDED } else { 0 }
}

/// A quoted text on one line. A text from a file may contain any characters.
fn string(text: &str) -> String {
    let plain = text.chars().map(|character| match character {
        '"' => '\'',
        '\\' => '/',
        _ if character.is_control() => ' ',
        _ => character,
    });
    plain.collect()
}

/// A text in the character set Windows-1252. Characters that Latin-1 does not encode alike become `?`.
fn windows_1252(text: &str) -> Vec<u8> {
    let byte = |character: char| match u32::from(character) {
        code @ (0..=0x7F | 0xA0..=0xFF) => code as u8,
        _ => b'?',
    };
    text.chars().map(byte).collect()
}
