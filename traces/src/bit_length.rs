//! How many bits a classical CAN frame takes on the bus (ISO 11898-1).
//!
//! ```text
//! base format      SOF  ID 11  RTR  IDE  r0  DLC 4  data 0..64  CRC 15 | CRC delimiter  ACK 2  EOF 7 | intermission 3
//! extended format  SOF  ID 11  SRR  IDE  ID 18  RTR  r1  r0  DLC 4  data  CRC 15 | the same
//!                  \------------------------- with stuff bits -----------------/ \------- fixed form -------/
//! ```
//!
//! After five equal bits the sender inserts a complementary one, which itself counts as the first of the next run.
//! Where the last five bits of the CRC are equal, a stuff bit follows them too. Stuff bits are no input of the CRC.
//!
//! The result is exact. Tables give CRC and stuff bits byte by byte, which is fast enough for every frame.

use crate::{Frame, FrameKind};

/// The bits between two frames (intermission); they are not part of a frame.
pub const INTERMISSION: u32 = 3;

/// CRC delimiter, ACK slot and delimiter, end of frame: none of them is stuffed.
const FIXED_FORM: u32 = 1 + 2 + 7;

/// The number of bits of a classical data or remote frame, from start of frame to end of frame, with its stuff bits and
/// without the [`INTERMISSION`]. `None` for CAN FD, CAN XL and error frames.
pub fn bit_length(frame: &Frame) -> Option<u32> {
    if frame.is_error() || frame.is_fd() || frame.is_xl() {
        return None;
    }
    let data = frame.data();
    Some(if frame.id().is_extended() {
        with_header(extended_header(frame), 39, data, frame.bytes())
    } else {
        with_header(base_header(frame), 19, data, frame.bytes())
    })
}

/// The bits from SOF to DLC of the base format: 19 bits, in whole bytes.
fn base_header(frame: &Frame) -> [u8; 3] {
    let [_, bytes @ ..] = (frame.id().raw() << 7 | control(frame)).to_be_bytes();
    bytes
}

/// The bits from SOF to DLC of the extended format: 39 bits, in whole bytes. SRR and IDE are recessive.
fn extended_header(frame: &Frame) -> [u8; 5] {
    let raw = u64::from(frame.id().raw());
    let bits = (raw >> 18) << 27 | 0b11 << 25 | (raw & 0x3_FFFF) << 7 | u64::from(control(frame));
    let [_, _, _, bytes @ ..] = bits.to_be_bytes();
    bytes
}

/// The control bits: RTR, two dominant bits, DLC.
#[inline]
fn control(frame: &Frame) -> u32 {
    u32::from(frame.kind() == FrameKind::Remote) << 6 | u32::from(frame.dlc() & 0xF)
}

/// The number of bits of a frame with the given header of `len` bits; `filled` is the data, filled up with zeros.
#[inline]
fn with_header<const N: usize>(header: [u8; N], len: u32, data: &[u8], filled: [u8; 8]) -> u32 {
    // Nearly all frames have eight bytes; a constant number of bytes lets the compiler unroll the loops.
    match data.len() {
        8 => filled_up(header, len, &filled, crc15(header, 8, filled)),
        other => filled_up(header, len, data, crc15(header, other, filled)),
    }
}

/// The number of bits of a frame with the given header of `len` bits, data and CRC.
#[inline(always)]
fn filled_up<const N: usize>(header: [u8; N], len: u32, data: &[u8], crc: u16) -> u32 {
    let [first, rest @ ..] = &header[..] else { return 0 };
    // Stuff bits are looked up by whole bytes. The bits that fill up the first byte alternate, so they get no stuff
    // bits; the last of them differs from the dominant SOF, so the counted run begins with SOF, as on the bus.
    const ALTERNATING: u8 = 0b0101_0101;
    let mut stuffing = Stuffing::default();
    stuffing.byte(first | ALTERNATING << (len % 8));
    rest.iter().for_each(|byte| stuffing.byte(*byte));
    data.iter().for_each(|byte| stuffing.byte(*byte));
    // The bits that fill up the last byte are the complement of its last bit, so they end its run and add no stuff
    // bit.
    let [upper, lower] = (crc << 1 | !crc & 1).to_be_bytes();
    stuffing.byte(upper);
    stuffing.byte(lower);
    len + 8 * data.len() as u32 + 15 + stuffing.stuffed() + FIXED_FORM
}

/// The CRC sequence over a header and `len` bytes of data. Leading zeros don't change the CRC, so it can be computed
/// over whole bytes. The CRC is linear: the contributions of the bytes are looked up independently of each other.
#[inline(always)]
fn crc15<const N: usize>(header: [u8; N], len: usize, data: [u8; 8]) -> u16 {
    let shift = 64 - 8 * len as u32;
    let data = u64::from_be_bytes(data).checked_shr(shift).unwrap_or(0).to_le_bytes();
    let mut crc = 0;
    for (byte, table) in data.iter().zip(&CRC_TABLES) {
        crc ^= table[usize::from(*byte)];
    }
    for (byte, table) in header.iter().rev().zip(&CRC_TABLES[len..]) {
        crc ^= table[usize::from(*byte)];
    }
    crc
}

/// Counts stuff bits, byte by byte.
#[derive(Default)]
struct Stuffing {
    /// Entry of [`STUFF_TABLE`] for the last byte: the run after it, and its number of stuff bits.
    last: u16,
    /// Sum of all entries. The lower half is the sum of the runs, which can't overflow in 15 bytes; the upper half is
    /// the number of stuff bits.
    sum: u32,
}

impl Stuffing {
    #[inline]
    fn byte(&mut self, byte: u8) {
        // The look-up is the only step that depends on the byte before.
        self.last = STUFF_TABLE[usize::from(byte)][usize::from(self.last & 0xF)];
        self.sum += u32::from(self.last);
    }

    const fn stuffed(&self) -> u32 {
        self.sum >> 8
    }
}

/// The run of equal bits at the end of the sent bits.
#[derive(Clone, Copy)]
struct Run {
    bit: bool,
    /// Length of the run, 0 to 4: the fifth equal bit is followed by a stuff bit, which begins a new run.
    len: u8,
}

impl Run {
    /// The run after one more bit, and whether a stuff bit was added after it.
    const fn after(self, bit: bool) -> (Self, bool) {
        let len = if self.bit == bit { self.len + 1 } else { 1 };
        if len == 5 { (Self { bit: !bit, len: 1 }, true) } else { (Self { bit, len }, false) }
    }

    const fn number(self) -> usize {
        (self.bit as usize) << 3 | self.len as usize
    }

    const fn of_number(number: u8) -> Self {
        Self { bit: number & 8 != 0, len: number & 7 }
    }
}

/// Generator polynomial of CAN: x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1.
const CRC_POLYNOMIAL: u16 = 0x4599;

/// The CRC that a byte contributes, by the number of bytes after it and by its value. The longest header and data
/// have 103 bits.
const CRC_TABLES: [[u16; 256]; 13] = {
    let mut tables = [[0; 256]; 13];
    let mut following = 0;
    while following < 13 {
        let mut byte = 0;
        while byte < 256 {
            let mut crc = if following == 0 { (byte as u16) << 7 } else { tables[following - 1][byte] };
            let mut bit = 0;
            while bit < 8 {
                crc = if crc & 0x4000 != 0 { crc << 1 ^ CRC_POLYNOMIAL } else { crc << 1 } & 0x7FFF;
                bit += 1;
            }
            tables[following][byte] = crc;
            byte += 1;
        }
        following += 1;
    }
    tables
};

/// The run after a byte (lower byte) and the number of stuff bits in it (upper byte), by the byte and the run before
/// it.
static STUFF_TABLE: [[u16; 16]; 256] = {
    let mut table = [[0; 16]; 256];
    let mut at = 0;
    while at < 16 * 256 {
        let (byte, number) = (at >> 4, at & 0xF);
        // Runs of 5 to 7 bits don't occur; their rows make the index a power of two.
        let mut run = Run::of_number(if number & 7 > 4 { 0 } else { number as u8 });
        let mut stuffed = 0;
        let mut bit = 8;
        while bit > 0 {
            bit -= 1;
            let (next, added) = run.after(byte >> bit & 1 != 0);
            run = next;
            stuffed += added as u16;
        }
        table[byte][number] = stuffed << 8 | run.number() as u16;
        at += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CanId;
    use proptest::prelude::*;

    /// The number of bits, counted bit by bit as ISO 11898-1 describes it; shares nothing with the code above.
    fn naive(frame: &Frame) -> u32 {
        let mut bits = vec![false];
        let mut push = |value: u32, len: u32| (0..len).rev().for_each(|n| bits.push(value >> n & 1 != 0));
        let remote = u32::from(frame.is_remote());
        if frame.id().is_extended() {
            push(frame.id().raw() >> 18, 11);
            push(0b11, 2);
            push(frame.id().raw() & 0x3_FFFF, 18);
            push(remote, 1);
            push(0, 2);
        } else {
            push(frame.id().raw(), 11);
            push(remote, 1);
            push(0, 2);
        }
        push(u32::from(frame.dlc()), 4);
        frame.data().iter().for_each(|&byte| push(u32::from(byte), 8));
        let mut crc = 0_u32;
        for &bit in &bits {
            let next = bit ^ (crc >> 14 & 1 != 0);
            crc = crc << 1 & 0x7FFF;
            if next {
                crc ^= 0x4599;
            }
        }
        (0..15).rev().for_each(|n| bits.push(crc >> n & 1 != 0));
        let mut sent: Vec<bool> = Vec::new();
        for bit in bits {
            sent.push(bit);
            // A stuff bit begins a new run, so the last five bits suffice to find the next one.
            if sent.len() >= 5 && sent[sent.len() - 5..].iter().all(|&b| b == bit) {
                sent.push(!bit);
            }
        }
        sent.len() as u32 + 10
    }

    fn standard(id: u32, data: &[u8]) -> Frame {
        Frame::new(CanId::standard(id).unwrap(), data).unwrap()
    }

    #[test]
    fn limits_of_the_standard() {
        // A frame has 44 + 8n bits and at most floor((34 + 8n - 1) / 4) stuff bits; 64 + 8n bits in the extended
        // format.
        let longest = (0..=0xFF).map(|byte| bit_length(&standard(0x78, &[byte; 8])).unwrap()).max();
        assert!(longest <= Some(44 + 64 + 24), "{longest:?}");
        assert!(bit_length(&standard(0x555, &[0x55; 8])).unwrap() >= 108);
        let id = CanId::extended(0x1555_5555).unwrap();
        assert!(bit_length(&Frame::new(id, &[0x55; 8]).unwrap()).unwrap() >= 128);
    }

    #[test]
    fn only_classical_frames() {
        let id = CanId::standard(1).unwrap();
        assert_eq!(bit_length(&Frame::fd(id, crate::Flags::BRS, &[0; 8]).unwrap()), None);
        assert_eq!(bit_length(&Frame::error(crate::ErrorClass(4), &[0; 8]).unwrap()), None);
    }

    #[test]
    fn runs_across_bytes() {
        let count = |bytes: &[u8]| {
            let mut stuffing = Stuffing::default();
            bytes.iter().for_each(|byte| stuffing.byte(*byte));
            stuffing.stuffed()
        };
        assert_eq!(count(&[0b1010_0000]), 1);
        assert_eq!(count(&[0b0101_0110, 0b0000_1111, 0b0000_1111]), 4, "each stuff bit opens the next run");
        assert_eq!(count(&[0b1010_1010, 0x55]), 0);
        assert_eq!(count(&[0b0101_0100, 0, 0, 0, 0]), 6, "34 zeros: a stuff bit after every five");
    }

    proptest! {
        #[test]
        fn as_bit_by_bit(id in 0u32..0x2000_0000, extended: bool, remote: bool, data in prop::collection::vec(
            prop_oneof![Just(0u8), Just(0xFF), any::<u8>()], 0..=8), dlc in 0u8..16) {
            let id = if extended { CanId::extended_masked(id) } else { CanId::standard_masked(id) };
            let frame = if remote { Frame::remote(id, data.len() as u8).unwrap() } else { Frame::new(id, &data).unwrap() };
            let frame = frame.with_raw_dlc(dlc);
            prop_assert_eq!(bit_length(&frame), Some(naive(&frame)));
        }
    }
}
