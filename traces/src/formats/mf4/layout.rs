//! The blocks of a written file before its records. Each is built behind those to which it links, but the header, whose
//! place is fixed.

use super::reader::{FINISHED, HEADER, LOCAL, UNFINISHED};
use super::writer::{DATA_AT, FIELDS, Field, Kind, TIME};

/// Flags of a file that is not finished: the counts of records and the length of their block are not known.
const COUNTS_AND_LENGTH: u16 = 1 << 0 | 1 << 2;
/// Length of the header with its links.
const HEADER_LENGTH: usize = 104;
/// Kinds of channels, and of their encodings.
const FIXED: u8 = 0;
const MASTER: u8 = 2;
const UNSIGNED: u8 = 0;
const BYTES: u8 = 10;
/// The kind of synchronisation of a channel with times.
const BY_TIME: u8 = 1;
/// Flag of a channel: it belongs to a frame of a bus.
const CHANNEL_OF_BUS: u32 = 1 << 10;
/// Flags of a group: frames of a bus, and nothing else.
const GROUP_OF_BUS: u16 = 1 << 1 | 1 << 2;

/// The blocks before the records.
pub(super) struct Layout {
    bytes: Vec<u8>,
    counts: [u64; 4],
}

impl Layout {
    /// The blocks of a file that is not finished, whose measurement starts then, in nanoseconds since 1970.
    pub fn unfinished(start: u64, is_local: bool) -> Self {
        Self::new(identification(true), start, is_local, 0, [0; 4])
    }

    /// The blocks of a finished file, with the length of its records and the number of records of each group.
    pub fn finished(start: u64, is_local: bool, length: u64, counts: [u64; 4]) -> Self {
        Self::new(identification(false), start, is_local, length, counts)
    }

    fn new(identification: Vec<u8>, start: u64, is_local: bool, length: u64, counts: [u64; 4]) -> Self {
        let mut layout = Self { bytes: identification, counts };
        layout.bytes.resize(HEADER as usize + HEADER_LENGTH, 0);
        let history = layout.history(start);
        let groups = layout.groups();
        let data_group = layout.bytes.len() as u64;
        // The records follow the data group.
        let records = data_group + 64;
        layout.block(b"DG", &[0, groups, records, 0], &[1, 0, 0, 0, 0, 0, 0, 0]);
        layout.header(data_group, history, start, is_local);
        layout.begin(b"DT", 24 + length, &[]);
        layout
    }

    /// The bytes of the blocks, up to the first record.
    pub fn bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// Appends the beginning of a block, and returns its offset.
    fn begin(&mut self, id: &[u8; 2], length: u64, links: &[u64]) -> u64 {
        let at = self.bytes.len() as u64;
        self.bytes.extend_from_slice(b"##");
        self.bytes.extend_from_slice(id);
        self.bytes.extend([0; 4]);
        self.bytes.extend(length.to_le_bytes());
        self.bytes.extend((links.len() as u64).to_le_bytes());
        links.iter().for_each(|link| self.bytes.extend(link.to_le_bytes()));
        at
    }

    /// Appends a block, and returns its offset. Blocks begin at multiples of eight.
    fn block(&mut self, id: &[u8; 2], links: &[u64], data: &[u8]) -> u64 {
        let at = self.begin(id, (24 + 8 * links.len() + data.len()) as u64, links);
        self.bytes.extend_from_slice(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        at
    }

    /// Appends a text, which ends with a zero byte.
    fn text(&mut self, id: &[u8; 2], text: &str) -> u64 {
        let mut data = text.as_bytes().to_vec();
        data.push(0);
        data.resize(data.len().next_multiple_of(8), 0);
        self.block(id, &[], &data)
    }

    /// Writes the header into its place.
    fn header(&mut self, data_group: u64, history: u64, start: u64, is_local: bool) {
        let mut header = Self { bytes: Vec::new(), counts: self.counts };
        let mut data = start.to_le_bytes().to_vec();
        data.extend([0, 0, 0, 0, if is_local { LOCAL } else { 0 }]);
        data.resize(32, 0);
        header.block(b"HD", &[data_group, history, 0, 0, 0, 0], &data);
        let at = HEADER as usize;
        self.bytes[at..at + HEADER_LENGTH].copy_from_slice(&header.bytes);
    }

    /// Which program wrote the file, and when.
    fn history(&mut self, start: u64) -> u64 {
        let comment = format!(
            "<FHcomment><TX>written</TX><tool_id>canvass</tool_id><tool_vendor>canvass</tool_vendor>\
             <tool_version>{}</tool_version></FHcomment>",
            env!("CARGO_PKG_VERSION")
        );
        let comment = self.text(b"MD", &comment);
        let mut data = start.to_le_bytes().to_vec();
        data.resize(16, 0);
        self.block(b"FH", &[0, comment], &data)
    }

    /// All groups of records; returns the first one.
    fn groups(&mut self) -> u64 {
        let bus = self.text(b"TX", "CAN");
        // A bus (2), of the kind CAN (2).
        let source = self.block(b"SI", &[bus, bus, 0], &[2, 2, 0, 0, 0, 0, 0, 0]);
        let seconds = self.text(b"TX", "s");
        let nanoseconds = self.nanoseconds();
        Kind::ALL.iter().rev().fold(0, |next, &kind| {
            let time_name = self.text(b"TX", "Timestamp");
            let frame = self.frame(kind, source);
            let time = [frame, 0, time_name, 0, nanoseconds, 0, seconds, 0];
            let time =
                self.channel(&time, [MASTER, BY_TIME, UNSIGNED], &Field { name: "", byte: 0, bit: 0, bits: 64 }, 0);
            let name = self.text(b"TX", kind.name());
            let mut data = (kind as u64).to_le_bytes().to_vec();
            data.extend(self.counts[kind as usize].to_le_bytes());
            data.extend(GROUP_OF_BUS.to_le_bytes());
            data.extend([b'.', 0, 0, 0, 0, 0]);
            data.extend((TIME + DATA_AT + kind.data()).to_le_bytes());
            data.extend([0; 4]);
            self.block(b"CG", &[next, time, name, source, 0, 0], &data)
        })
    }

    /// The conversion of nanoseconds into seconds: linear (1), by offset and factor.
    fn nanoseconds(&mut self) -> u64 {
        let mut data = vec![1, 0, 0, 0, 0, 0, 2, 0];
        data.extend([0; 16]);
        data.extend(0_f64.to_le_bytes());
        data.extend(1e-9_f64.to_le_bytes());
        self.block(b"CC", &[0, 0, 0, 0], &data)
    }

    /// Appends the channel of a frame. The fields of the frame are its members.
    fn frame(&mut self, kind: Kind, source: u64) -> u64 {
        let data = Field { name: "DataBytes", byte: DATA_AT, bit: 0, bits: 8 * kind.data() };
        let has_data = kind.data() > 0;
        let first = if has_data { self.member(kind, &data, BYTES, source, 0) } else { 0 };
        let first = FIELDS.iter().rev().fold(first, |next, field| self.member(kind, field, UNSIGNED, source, next));
        let name = self.text(b"TX", kind.name());
        let whole = Field { name: "", byte: TIME, bit: 0, bits: 8 * (DATA_AT + kind.data()) };
        self.channel(&[0, first, name, source, 0, 0, 0, 0], [FIXED, 0, BYTES], &whole, CHANNEL_OF_BUS)
    }

    fn member(&mut self, kind: Kind, field: &Field, encoding: u8, source: u64, next: u64) -> u64 {
        let name = self.text(b"TX", &format!("{}.{}", kind.name(), field.name));
        let place = Field { byte: TIME + field.byte, ..*field };
        self.channel(&[next, 0, name, source, 0, 0, 0, 0], [FIXED, 0, encoding], &place, CHANNEL_OF_BUS)
    }

    /// Appends a channel, and returns its offset. `kind` holds the kind of the channel, of its synchronisation, and of its
    /// encoding.
    fn channel(&mut self, links: &Links, kind: [u8; 3], place: &Field, flags: u32) -> u64 {
        let mut data = kind.to_vec();
        data.push(place.bit);
        data.extend(place.byte.to_le_bytes());
        data.extend(place.bits.to_le_bytes());
        data.extend(flags.to_le_bytes());
        // No invalidation bit, precision, attachment or limits.
        data.resize(72, 0);
        self.block(b"CN", links, &data)
    }
}

/// The links of a channel: the next one, the first member, name, source, conversion, values, unit, comment.
type Links = [u64; 8];

fn identification(is_unfinished: bool) -> Vec<u8> {
    let mut bytes = if is_unfinished { UNFINISHED } else { FINISHED }.to_vec();
    bytes.extend_from_slice(b"4.10    canvass ");
    bytes.extend([0; 4]);
    bytes.extend(410_u16.to_le_bytes());
    bytes.resize(60, 0);
    bytes.extend(if is_unfinished { COUNTS_AND_LENGTH } else { 0 }.to_le_bytes());
    bytes.resize(HEADER as usize, 0);
    bytes
}
