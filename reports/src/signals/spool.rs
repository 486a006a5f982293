//! Rows that wait until all columns are known. The new values of each row are stored in binary.

use canvass_analyzer::{NodeId, Number, PdoNumber};
use canvass_traces::Timestamp;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};

/// Rows that are written to a file or memory and read back.
pub struct Spool<F: Read + Write + Seek> {
    state: SpoolState<F>,
    buffer: Vec<u8>,
}

enum SpoolState<F> {
    Writing(F),
    Reading(BufReader<F>),
    Done,
}

/// A row as it is read back.
pub(super) struct Kept {
    pub time: Timestamp,
    /// The number of the channel's name, the node and the PDO.
    pub source: Option<(u16, NodeId, PdoNumber)>,
    pub changed: Vec<(usize, Number)>,
}

/// Number of bytes that are written at once.
const PART: usize = 64 * 1024;

impl<F: Read + Write + Seek> Spool<F> {
    /// A spool that keeps rows in the empty file `file`.
    pub const fn new(file: F) -> Self {
        Self { state: SpoolState::Writing(file), buffer: Vec::new() }
    }

    pub(super) fn keep(
        &mut self,
        time: Timestamp,
        source: Option<(u16, NodeId, PdoNumber)>,
        changed: &[(usize, Number)],
    ) -> io::Result<()> {
        let buffer = &mut self.buffer;
        buffer.extend_from_slice(&time.nanos().to_le_bytes());
        let (channel, node, kind, number) = match source {
            None => (0, 0, 0, 0),
            Some((channel, node, PdoNumber::Transmit(n))) => (channel, node.raw(), 1, n),
            Some((channel, node, PdoNumber::Receive(n))) => (channel, node.raw(), 2, n),
        };
        buffer.extend_from_slice(&channel.to_le_bytes());
        buffer.extend_from_slice(&[node, kind]);
        buffer.extend_from_slice(&number.to_le_bytes());
        buffer.extend_from_slice(&(changed.len() as u32).to_le_bytes());
        for &(column, number) in changed {
            let (tag, bits) = encode(number);
            buffer.extend_from_slice(&(column as u16).to_le_bytes());
            buffer.push(tag);
            buffer.extend_from_slice(&bits.to_le_bytes());
        }
        if self.buffer.len() >= PART { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        if let SpoolState::Writing(file) = &mut self.state {
            file.write_all(&self.buffer)?;
        }
        self.buffer.clear();
        Ok(())
    }

    /// The next row, in the order in which rows were kept. The first call ends the writing.
    pub(super) fn next(&mut self) -> io::Result<Option<Kept>> {
        if matches!(self.state, SpoolState::Writing(_)) {
            self.flush()?;
            self.state = match std::mem::replace(&mut self.state, SpoolState::Done) {
                SpoolState::Writing(mut file) => {
                    file.seek(SeekFrom::Start(0))?;
                    SpoolState::Reading(BufReader::with_capacity(PART, file))
                }
                other => other,
            };
        }
        let SpoolState::Reading(file) = &mut self.state else { return Ok(None) };
        let mut head = [0; 18];
        match file.read_exact(&mut head) {
            Ok(()) => kept(head, file).map(Some),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                self.state = SpoolState::Done;
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}

fn kept(head: [u8; 18], file: &mut impl Read) -> io::Result<Kept> {
    let [t0, t1, t2, t3, t4, t5, t6, t7, c0, c1, node, kind, p0, p1, n0, n1, n2, n3] = head;
    let (channel, number) = (u16::from_le_bytes([c0, c1]), u16::from_le_bytes([p0, p1]));
    let pdo = if kind == 1 { PdoNumber::Transmit(number) } else { PdoNumber::Receive(number) };
    let mut row = Kept {
        time: Timestamp(u64::from_le_bytes([t0, t1, t2, t3, t4, t5, t6, t7])),
        source: NodeId::new(node).map(|node| (channel, node, pdo)),
        changed: Vec::new(),
    };
    for _ in 0..u32::from_le_bytes([n0, n1, n2, n3]) {
        let mut value = [0; 11];
        file.read_exact(&mut value)?;
        let [c0, c1, tag, bits @ ..] = value;
        row.changed.push((usize::from(u16::from_le_bytes([c0, c1])), decode(tag, u64::from_le_bytes(bits))));
    }
    Ok(row)
}

const fn encode(number: Number) -> (u8, u64) {
    match number {
        Number::Boolean(value) => (0, value as u64),
        Number::Integer(value) => (1, value.cast_unsigned()),
        Number::Unsigned(value) => (2, value),
        Number::Real32(value) => (3, value.to_bits() as u64),
        Number::Real64(value) => (4, value.to_bits()),
    }
}

const fn decode(tag: u8, bits: u64) -> Number {
    match tag {
        0 => Number::Boolean(bits != 0),
        1 => Number::Integer(bits.cast_signed()),
        2 => Number::Unsigned(bits),
        3 => Number::Real32(f32::from_bits(bits as u32)),
        _ => Number::Real64(f64::from_bits(bits)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Cursor;

    fn number() -> impl Strategy<Value = Number> {
        prop_oneof![
            any::<bool>().prop_map(Number::Boolean),
            any::<i64>().prop_map(Number::Integer),
            any::<u64>().prop_map(Number::Unsigned),
            (-1e9_f32..1e9).prop_map(Number::Real32),
            (-1e9_f64..1e9).prop_map(Number::Real64),
        ]
    }

    proptest! {
        #[test]
        fn rows_come_back_as_they_went(rows in prop::collection::vec(
            (any::<u64>(), prop::option::of((any::<u16>(), 1_u8..=127, 1_u16..=512)),
             prop::collection::vec((0_usize..4096, number()), 0..9)), 0..9)) {
            let mut spool = Spool::new(Cursor::new(Vec::new()));
            let source = |source: Option<(u16, u8, u16)>| {
                source.map(|(channel, node, n)| (channel, NodeId::new(node).unwrap(), PdoNumber::Transmit(n)))
            };
            for (time, from, changed) in &rows {
                spool.keep(Timestamp(*time), source(*from), changed).unwrap();
            }
            for (time, from, changed) in rows {
                let kept = spool.next().unwrap().unwrap();
                prop_assert_eq!((kept.time, kept.source), (Timestamp(time), source(from)));
                prop_assert_eq!(kept.changed, changed);
            }
            prop_assert!(spool.next().unwrap().is_none());
        }
    }
}
