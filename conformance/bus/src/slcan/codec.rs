//! The SLCAN protocol (LAWICEL's ASCII protocol), without I/O: frames and commands as lines that end with CR.
//!
//! ```text
//! tiiildd...[tttt]        data frame, 11 bits: identifier, DLC, data, and a timestamp in ms if switched on by Z1
//! Tiiiiiiiildd...[tttt]   data frame, 29 bits
//! riiil, Riiiiiiiil       remote frames
//! d, D, b, B              CAN FD frames without and with bit rate switching (an extension)
//! CR                      done            BEL (07h)   refused
//! z CR, Z CR              frame taken for sending, 11 and 29 bits
//! Fhh CR                  status flags    Vhhhh, Nhhhh  version, serial number
//! ```
//!
//! Hexadecimal digits may have both cases; a DLC of a classical frame may be 9 to F and stands for 8 bytes of data.

use canvass_traces::{CanId, ChannelId, Flags, Frame, Record, Timestamp};
use std::fmt;

/// CR, the end of a line.
pub const END: u8 = b'\r';
/// BEL, the answer "refused".
pub const REFUSED: u8 = 0x07;

/// Maximum length of a line: a CAN FD frame of 64 bytes with timestamp, 1 + 8 + 1 + 128 + 4.
const LONGEST_LINE: usize = 160;

/// The bit rates of S0 to S8, in bit/s.
pub const BIT_RATES: [u32; 9] = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

/// One line, in either direction.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Message {
    /// A frame; its record has no time and no channel yet.
    Frame {
        /// The frame.
        record: Record,
        /// The time on the adapter's clock in milliseconds, 0 to 59 999.
        milliseconds: Option<u16>,
    },
    /// The adapter has carried out the last command.
    Done,
    /// The adapter has refused the last command.
    Refused,
    /// The adapter has taken a frame for sending.
    Taken,
    /// The status flags.
    Status(Status),
    /// The version or serial number.
    Text(String),
    /// A command from a program to an adapter.
    Command(Command),
    /// Any other line.
    Unknown(Vec<u8>),
}

/// A command to an adapter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Command {
    /// `S0` to `S8`: an index into [`BIT_RATES`].
    BitRate(u8),
    /// `O`: open the channel.
    Open,
    /// `L`: open the channel for listening only.
    Listen,
    /// `C`: close the channel.
    Close,
    /// `Z0`, `Z1`: switch timestamps off or on.
    Timestamps(bool),
    /// `F`: read the status flags.
    Status,
    /// `V`: read the version.
    Version,
    /// `N`: read the serial number.
    SerialNumber,
    /// Commands that only tune an adapter: acceptance filters, automatic polling, bit timing registers.
    Tuning,
}

/// The status flags of an adapter's CAN controller (SJA1000).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Status(pub u8);

impl Status {
    const NAMES: [(u8, &'static str); 7] = [
        (0x01, "receive queue full"),
        (0x02, "transmit queue full"),
        (0x04, "error warning"),
        (0x08, "data overrun"),
        (0x20, "error-passive"),
        (0x40, "arbitration lost"),
        (0x80, "bus error"),
    ];

    /// Whether frames were lost in the adapter.
    pub(crate) const fn has_lost(self) -> bool {
        self.0 & 0x09 != 0
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let set = Self::NAMES.iter().filter(|(bit, _)| self.0 & bit != 0).map(|&(_, name)| name);
        let names: Vec<&str> = set.collect();
        f.write_str(&if names.is_empty() { "no error".to_owned() } else { names.join(", ") })
    }
}

/// Splits bytes into messages.
#[derive(Debug, Default)]
pub struct Decoder {
    line: Vec<u8>,
    /// Whether the current line is longer than any message, and so is skipped.
    overlong: bool,
}

impl Decoder {
    /// Adds received bytes, and passes every message that they complete to `found`.
    pub fn push(&mut self, bytes: &[u8], mut found: impl FnMut(Message)) {
        for &byte in bytes {
            match byte {
                // BEL is an answer without CR; bytes before it are the rest of a cut line.
                REFUSED => {
                    self.finish_cut(&mut found);
                    found(Message::Refused);
                }
                END => {
                    let overlong = std::mem::take(&mut self.overlong);
                    found(if overlong { Message::Unknown(self.line.clone()) } else { Message::read(&self.line) });
                    self.line.clear();
                }
                // Some terminals send LF after CR.
                b'\n' if self.line.is_empty() => {}
                _ if self.line.len() < LONGEST_LINE => self.line.push(byte),
                _ => self.overlong = true,
            }
        }
    }

    fn finish_cut(&mut self, found: &mut impl FnMut(Message)) {
        if !self.line.is_empty() {
            found(Message::Unknown(std::mem::take(&mut self.line)));
        }
        self.overlong = false;
    }
}

impl Message {
    /// Parses a line without its end.
    pub fn read(line: &[u8]) -> Self {
        let Some((&kind, rest)) = line.split_first() else { return Self::Done };
        let understood = match kind {
            b't' | b'T' | b'r' | b'R' | b'd' | b'D' | b'b' | b'B' => frame(kind, rest),
            b'z' | b'Z' if rest.is_empty() => Some(Self::Taken),
            b'F' if rest.len() == 2 => hex(rest).map(|flags| Self::Status(Status(flags as u8))),
            b'V' | b'v' | b'N' if !rest.is_empty() => Some(Self::Text(String::from_utf8_lossy(line).into_owned())),
            _ => command(kind, rest).map(Self::Command),
        };
        understood.unwrap_or_else(|| Self::Unknown(line.to_vec()))
    }
}

fn command(kind: u8, rest: &[u8]) -> Option<Command> {
    Some(match (kind, rest) {
        (b'S', &[digit @ b'0'..=b'8']) => Command::BitRate(digit - b'0'),
        (b'O', []) => Command::Open,
        (b'L', []) => Command::Listen,
        (b'C', []) => Command::Close,
        (b'Z', &[digit @ b'0'..=b'1']) => Command::Timestamps(digit == b'1'),
        (b'F', []) => Command::Status,
        (b'V', []) => Command::Version,
        (b'N', []) => Command::SerialNumber,
        (b's' | b'M' | b'm' | b'X' | b'W' | b'Q' | b'U', rest) if !rest.is_empty() => Command::Tuning,
        _ => return None,
    })
}

fn frame(kind: u8, rest: &[u8]) -> Option<Message> {
    let extended = kind.is_ascii_uppercase();
    let (id, rest) = rest.split_at_checked(if extended { 8 } else { 3 })?;
    let id = if extended { CanId::extended(hex(id)?) } else { CanId::standard(hex(id)?) }?;
    let (&dlc, rest) = rest.split_first()?;
    let dlc = char::from(dlc).to_digit(16)? as u8;
    let (record, rest) = match kind.to_ascii_lowercase() {
        b'r' => (plain(Frame::remote(id, dlc.min(8))?), rest),
        b't' => {
            let (data, rest) = data(rest, usize::from(dlc.min(8)))?;
            (plain(Frame::new(id, &data)?.with_raw_dlc(dlc)), rest)
        }
        kind => {
            let (data, rest) = data(rest, usize::from(*Frame::FD_LENGTHS.get(usize::from(dlc))?))?;
            let flags = if kind == b'b' { Flags::FDF.with(Flags::BRS) } else { Flags::FDF };
            (Record::fd(Timestamp::ZERO, ChannelId(0), id, flags, &data)?, rest)
        }
    };
    let milliseconds = match rest.len() {
        0 => None,
        4 => Some(hex(rest)? as u16),
        _ => return None,
    };
    Some(Message::Frame { record, milliseconds })
}

fn plain(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

/// Parses `len` bytes; returns also the rest of the digits.
fn data(digits: &[u8], len: usize) -> Option<(Vec<u8>, &[u8])> {
    let (digits, rest) = digits.split_at_checked(2 * len)?;
    Some((canvass_traces::hex::parse(digits)?, rest))
}

/// Parses up to eight hexadecimal digits.
fn hex(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |number: u32, &digit| Some(number << 4 | char::from(digit).to_digit(16)?))
}

/// Appends a frame as a line; `None` if SLCAN has no line for it (error frames, CAN XL).
pub fn write_frame(record: &Record, line: &mut Vec<u8>) -> Option<()> {
    let frame = &record.frame;
    if frame.is_error() || frame.is_xl() {
        return None;
    }
    let kind = match (frame.is_remote(), frame.is_fd(), frame.flags().contains(Flags::BRS)) {
        (true, ..) => b'r',
        (_, false, _) => b't',
        (_, true, false) => b'd',
        (_, true, true) => b'b',
    };
    let id = frame.id();
    let head = if id.is_extended() {
        format!("{}{:08X}", char::from(kind.to_ascii_uppercase()), id.raw())
    } else {
        format!("{}{:03X}", char::from(kind), id.raw())
    };
    line.extend_from_slice(head.as_bytes());
    line.push(digit(frame.dlc()));
    for &byte in record.data() {
        line.extend_from_slice(&[digit(byte >> 4), digit(byte & 15)]);
    }
    line.push(END);
    Some(())
}

fn digit(value: u8) -> u8 {
    b"0123456789ABCDEF".get(usize::from(value)).copied().unwrap_or(b'0')
}

impl Command {
    /// Appends the line of the command.
    pub fn write(self, line: &mut Vec<u8>) {
        match self {
            Self::BitRate(index) => line.extend_from_slice(&[b'S', digit(index)]),
            Self::Open => line.push(b'O'),
            Self::Listen => line.push(b'L'),
            Self::Close => line.push(b'C'),
            Self::Timestamps(on) => line.extend_from_slice(&[b'Z', digit(u8::from(on))]),
            Self::Status => line.push(b'F'),
            Self::Version => line.push(b'V'),
            Self::SerialNumber => line.push(b'N'),
            Self::Tuning => line.extend_from_slice(b"X1"),
        }
        line.push(END);
    }

    /// The answer of an adapter to the command, for a bus on which this program is the adapter.
    pub fn answer(self) -> &'static [u8] {
        match self {
            Self::Status => b"F00\r",
            Self::Version => b"V1013\r",
            Self::SerialNumber => b"NCANV\r",
            _ => b"\r",
        }
    }
}

/// Makes the adapter's clock, which restarts every minute, continuous.
#[derive(Debug, Default)]
pub struct MinuteClock {
    last: Option<(u16, Timestamp)>,
    nanos: u64,
}

/// The period of the adapter's clock.
pub(super) const MINUTE: u64 = 60_000_000_000;

impl MinuteClock {
    /// The time on a continuous clock; `arrived` determines the number of minutes that have passed.
    pub fn unwrap(&mut self, milliseconds: u16, arrived: Timestamp) -> Timestamp {
        let within = u64::from(milliseconds) * 1_000_000;
        if let Some((last, at)) = self.last {
            let step = (within + MINUTE - u64::from(last) * 1_000_000 % MINUTE) % MINUTE;
            // This machine's clock determines the number of minutes; an error of less than half a minute does not
            // matter.
            let turns = (arrived.since(at).0 + MINUTE / 2).saturating_sub(step) / MINUTE;
            self.nanos += step + turns * MINUTE;
        } else {
            self.nanos = within;
        }
        self.last = Some((milliseconds, arrived));
        Timestamp(self.nanos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frame_of(line: &str) -> String {
        match Message::read(line.as_bytes()) {
            Message::Frame { record, milliseconds } => format!("{} {milliseconds:?}", record.frame),
            other => format!("{other:?}"),
        }
    }

    /// The examples in the description of the protocol, and the extension for CAN FD.
    #[test]
    fn lines_of_the_description() {
        assert_eq!(frame_of("t10021133"), "100#1133 None");
        assert_eq!(frame_of("t1002113305DC"), "100#1133 Some(1500)");
        assert_eq!(frame_of("T0000010021133"), "00000100#1133 None");
        assert_eq!(frame_of("r1003"), "100#R3 None");
        assert_eq!(frame_of("R000001003"), "00000100#R3 None");
        assert_eq!(frame_of("t63F84000600000000000"), "63F#4000600000000000 None");
        assert_eq!(frame_of("t123f0011223344556677"), "123#0011223344556677_F None");
        assert_eq!(frame_of("b1239000102030405060708090a0b"), "123##5000102030405060708090A0B None");
        for wrong in ["t8001AA", "t100211", "t1002113", "t10021133123", "tx00", "T200000000", "t10"] {
            assert!(frame_of(wrong).starts_with("Unknown"), "{wrong}");
        }
    }

    #[test]
    fn answers_and_commands() {
        let mut decoder = Decoder::default();
        let mut found = Vec::new();
        decoder.push(b"\rz\rF8", |message| found.push(message));
        decoder.push(b"9\r\x07t1\x07V1013\rS5\rO\rwhat\r", |message| found.push(message));
        let expected = [
            Message::Done,
            Message::Taken,
            Message::Status(Status(0x89)),
            Message::Refused,
            Message::Unknown(b"t1".to_vec()),
            Message::Refused,
            Message::Text("V1013".to_owned()),
            Message::Command(Command::BitRate(5)),
            Message::Command(Command::Open),
            Message::Unknown(b"what".to_vec()),
        ];
        assert_eq!(found, expected);
        assert_eq!(Status(0x89).to_string(), "receive queue full, data overrun, bus error");
        assert!(Status(0x08).has_lost() && !Status(0x80).has_lost());
    }

    #[test]
    fn a_line_without_end_takes_no_memory() {
        let mut decoder = Decoder::default();
        let mut found = Vec::new();
        decoder.push(&[b'A'; 100_000], |message| found.push(message));
        assert!(decoder.line.len() <= LONGEST_LINE && found.is_empty());
        decoder.push(b"\rt1000\r", |message| found.push(message));
        assert!(matches!(&found[..], [Message::Unknown(_), Message::Frame { .. }]), "{found:?}");
    }

    #[test]
    fn the_clock_of_a_minute_goes_on() {
        let mut clock = MinuteClock::default();
        let at = |ms: u64| Timestamp(ms * 1_000_000);
        assert_eq!(clock.unwrap(59_000, at(1_000_000)), at(59_000));
        assert_eq!(clock.unwrap(500, at(1_001_502)), at(60_500), "over the end of the minute");
        assert_eq!(clock.unwrap(500, at(1_001_503)), at(60_500), "in the same millisecond");
        assert_eq!(clock.unwrap(600, at(1_181_600)), at(240_600), "after three minutes of silence");
    }

    fn any_record() -> impl Strategy<Value = Record> {
        let id = prop_oneof![
            (0..0x800_u32).prop_map(CanId::standard_masked),
            (0..0x2000_0000_u32).prop_map(CanId::extended_masked)
        ];
        (id, prop::collection::vec(any::<u8>(), 0..=64), 0..4_u8).prop_map(|(id, data, kind)| {
            let short = &data[..data.len().min(8)];
            match kind {
                0 => plain(Frame::remote(id, short.len() as u8).unwrap()),
                1 => plain(Frame::new(id, short).unwrap()),
                _ => {
                    let len = Frame::FD_LENGTHS.iter().rev().find(|&&len| usize::from(len) <= data.len()).unwrap();
                    let flags = if kind == 2 { Flags::FDF } else { Flags::FDF.with(Flags::BRS) };
                    Record::fd(Timestamp::ZERO, ChannelId(0), id, flags, &data[..usize::from(*len)]).unwrap()
                }
            }
        })
    }

    proptest! {
        /// The lines of one end give the same frames at the other end, however the bytes are cut.
        #[test]
        fn frames_arrive(records in prop::collection::vec(any_record(), 1..8), cut in 1..9_usize) {
            let mut bytes = Vec::new();
            for record in &records {
                write_frame(record, &mut bytes).unwrap();
            }
            let (mut decoder, mut found) = (Decoder::default(), Vec::new());
            for part in bytes.chunks(cut) {
                decoder.push(part, |message| found.push(message));
            }
            let expected: Vec<_> =
                records.into_iter().map(|record| Message::Frame { record, milliseconds: None }).collect();
            prop_assert_eq!(found, expected);
        }

        #[test]
        fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let mut messages = 0;
            Decoder::default().push(&bytes, |_| messages += 1);
            prop_assert!(messages <= 2 * bytes.len());
        }
    }
}
