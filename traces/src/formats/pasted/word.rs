//! The words beside the numbers of a pasted line.

use crate::Direction;

/// A word that stands beside the columns.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Word {
    Direction(Direction),
    /// `R`: received, or a remote frame if the direction is already known.
    ReceivedOrRemote,
    Remote,
    Extended,
    Standard,
    /// A direction with the number of bits of the identifier: `R11`, `1T29`.
    Bits(Direction, bool),
    Fd,
    /// CAN FD with a faster bit rate for the data.
    Brs,
    /// The sender of a CAN FD frame is error passive.
    Esi,
    /// An error frame, which may have no identifier.
    ErrorFrame,
    /// An error, or a frame of another bus.
    Error,
    /// The name of an interface or channel: letters and then digits.
    Channel,
    /// Another name with a number, such as that of a message or a node.
    Name,
    /// A word that tools write in every line, and that says nothing of the frame.
    Usual,
    /// A word that counts only if other lines have it too.
    Unknown,
}

/// The meaning of the number after a label.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Label {
    Id,
    ExtendedId,
    Length,
    Data,
    Time,
    Channel,
    /// Whether the identifier has 29 bits.
    Extended,
    Remote,
    Other,
}

/// Longest word that is compared, in bytes.
const LONGEST: usize = 24;

fn lower(text: &[u8]) -> Option<([u8; LONGEST], usize)> {
    let mut lower = [0; LONGEST];
    lower.get_mut(..text.len())?.copy_from_slice(text);
    lower.make_ascii_lowercase();
    Some((lower, text.len()))
}

/// The meaning of a word; `None` for a text that is no word.
pub(super) fn word(text: &[u8]) -> Option<Word> {
    match text {
        b"R" => return Some(Word::ReceivedOrRemote),
        b"T" => return Some(Word::Direction(Direction::Tx)),
        _ => {}
    }
    let Some((lower, len)) = lower(text) else {
        return is_plain(text).then_some(Word::Unknown);
    };
    let lower = lower.get(..len).unwrap_or_default();
    Some(match lower {
        b"rx" | b"receive" | b"received" | b"recv" | b"rcv" | b"in" | b"<-" | b"<<" | b"\xE2\x86\x90" => {
            Word::Direction(Direction::Rx)
        }
        b"t" | b"tx" | b"send" | b"sent" | b"transmit" | b"transmitted" | b"txrq" | b"out" | b"->" | b">>"
        | b"\xE2\x86\x92" => Word::Direction(Direction::Tx),
        b"r" => Word::ReceivedOrRemote,
        b"rtr" | b"remote" | b"rr" | b"sr" | b"xr" => Word::Remote,
        b"x" | b"ext" | b"extended" | b"eff" | b"29bit" | b"29-bit" | b"extid" | b"ide" => Word::Extended,
        b"s" | b"std" | b"standard" | b"sff" | b"11bit" | b"11-bit" | b"base" | b"stdid" => Word::Standard,
        b"fd" | b"canfd" | b"fdf" => Word::Fd,
        b"bs" | b"brs" => Word::Brs,
        b"ei" | b"esi" => Word::Esi,
        b"errorframe" => Word::ErrorFrame,
        b"error" | b"err" | b"lin" => Word::Error,
        b"can" | b"frame" | b"data" | b"dt" | b"msg" | b"message" | b"line" | b"id" | b"identifier" | b"dlc"
        | b"len" | b"length" | b"bytes" | b"byte" | b"bus" | b"channel" | b"-" | b"--" | b"false" | b"n" | b"m"
        | b"l" | b"i" | b"cansend" | b"time" | b"timestamp" | b"at" | b"ms" | b"us" | b"hex" | b"dir" | b"from"
        | b"to" | b"on" | b"request" | b"packet" => Word::Usual,
        b"true" => Word::Unknown,
        _ if let Some(word) = bits(lower) => word,
        _ if is_name(text) => name(lower),
        _ if is_plain(text) => Word::Unknown,
        _ => return None,
    })
}

/// `r11`, `t29`, with or without the number of the bus before it.
fn bits(lower: &[u8]) -> Option<Word> {
    let bus = lower.iter().take_while(|byte| byte.is_ascii_digit()).count();
    match lower.get(bus..)? {
        b"r11" => Some(Word::Bits(Direction::Rx, false)),
        b"r29" => Some(Word::Bits(Direction::Rx, true)),
        b"t11" => Some(Word::Bits(Direction::Tx, false)),
        b"t29" => Some(Word::Bits(Direction::Tx, true)),
        _ => None,
    }
}

/// The meaning of letters and then digits.
fn name(lower: &[u8]) -> Word {
    const BEGIN: [&[u8]; 10] = [b"ch", b"bus", b"port", b"net", b"if", b"hs", b"ms", b"ls", b"usb", b"kvaser"];
    let has = |part: &[u8]| lower.windows(part.len()).any(|window| window == part);
    let letters = lower.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    match () {
        () if lower.get(..letters) == Some(b"lin") => Word::Error,
        () if has(b"can") || has(b"bus") || BEGIN.iter().any(|stem| lower.starts_with(stem)) => Word::Channel,
        () => Word::Name,
    }
}

/// Letters and then digits: `can0`, `PCAN_USBBUS1`, `TPDO1`.
fn is_name(text: &[u8]) -> bool {
    let letters = text.iter().take_while(|byte| byte.is_ascii_alphabetic() || **byte == b'_').count();
    let digits = text.len() - letters;
    letters >= 2 && (1..=3).contains(&digits) && text.iter().skip(letters).all(u8::is_ascii_digit)
}

/// A word of a language or a name: no part of an expression.
fn is_plain(text: &[u8]) -> bool {
    let is_letter = |byte: &u8| byte.is_ascii_alphabetic() || !byte.is_ascii();
    text.iter().any(is_letter)
        && text.iter().all(|byte| is_letter(byte) || byte.is_ascii_digit() || b"-_/.".contains(byte))
}

/// The meaning of a label, without its colon.
pub(super) fn label(text: &[u8]) -> Option<Label> {
    let (lower, len) = lower(text)?;
    Some(match lower.get(..len).unwrap_or_default() {
        b"id" | b"can-id" | b"can_id" | b"canid" | b"cob-id" | b"cob_id" | b"cobid" | b"identifier"
        | b"arbitration_id" | b"msgid" | b"frameid" | b"stdid" => Label::Id,
        b"extid" | b"eid" => Label::ExtendedId,
        b"dlc" | b"dl" | b"len" | b"length" | b"size" => Label::Length,
        b"data" | b"payload" | b"bytes" | b"msg" | b"message" | b"d" => Label::Data,
        b"timestamp" | b"time" | b"ts" | b"t" => Label::Time,
        b"channel" | b"ch" | b"chn" | b"bus" => Label::Channel,
        b"ide" | b"ext" | b"extended" | b"is_extended" | b"is_extended_id" | b"xtd" => Label::Extended,
        b"rtr" | b"remote" | b"is_remote" | b"is_remote_frame" => Label::Remote,
        _ if is_plain(text) => Label::Other,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_channels() {
        for name in ["can0", "slcan12", "PCAN_USBBUS1", "ch1", "vcan0"] {
            assert_eq!(word(name.as_bytes()), Some(Word::Channel), "{name}");
        }
        for name in ["can", "x1", "node-5", "1x", "TPDO1", "drive_1", "LIN1"] {
            assert_ne!(word(name.as_bytes()), Some(Word::Channel), "{name}");
        }
    }

    #[test]
    fn arrows_are_directions() {
        assert_eq!(word("←".as_bytes()), Some(Word::Direction(Direction::Rx)));
        assert_eq!(word("→".as_bytes()), Some(Word::Direction(Direction::Tx)));
    }
}
