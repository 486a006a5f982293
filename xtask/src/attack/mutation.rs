//! Random changes of files.

use super::chance::Chance;
use super::rows;
use super::seeds::{Seed, Seeds};

/// One change.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mutation {
    /// Bytes are replaced by random bytes.
    Bytes,
    /// A field of a row, or a number of a binary file, is replaced by a value that is difficult for readers.
    Field,
    /// A row, or a piece of a binary file, is doubled.
    Duplicated,
    Removed,
    Swapped,
    /// The rest of the file is cut off.
    Cut,
    /// A piece of a file of another format is inserted.
    Mixed,
}

/// Numbers and words that are difficult for readers.
const HARD: [&str; 14] = [
    "",
    "0",
    "-1",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "FFFFFFFFFFFFFFFF",
    "nan",
    "1e999",
    "0x",
    "RX",
    "\u{202e}",
    "00000000000000000000000000000000000000000000000000000000000000000000000",
];

/// Length of a piece of a binary file.
const STRETCH: usize = 48;

impl Mutation {
    /// A random change of a file, and the changed bytes.
    pub fn random(seed: &Seed, seeds: &Seeds, chance: &mut Chance) -> (Self, Vec<u8>) {
        let bytes = &seed.bytes;
        let pieces = pieces(bytes);
        let row = chance.below(pieces.len());
        match chance.below(8) {
            0 | 1 => {
                let mut changed = bytes.clone();
                for _ in 0..=chance.below(4) {
                    let at = chance.below(bytes.len());
                    // Line ends stay: other kinds of changes affect rows.
                    if let Some(byte) = changed.get_mut(at).filter(|byte| **byte != b'\n') {
                        *byte = chance.byte();
                    }
                }
                (Self::Bytes, changed)
            }
            2 => {
                let mut parts: Vec<Vec<u8>> = pieces.iter().map(|piece| piece.to_vec()).collect();
                if let Some(part) = parts.get_mut(row) {
                    *part = with_hard_field(part, chance);
                }
                (Self::Field, parts.concat())
            }
            3 => {
                let mut parts = pieces.clone();
                if let Some(piece) = pieces.get(row) {
                    parts.insert(row, piece);
                }
                (Self::Duplicated, parts.concat())
            }
            4 => {
                let kept = pieces.iter().enumerate().filter(|(at, _)| *at != row).map(|(_, piece)| *piece);
                (Self::Removed, kept.collect::<Vec<_>>().concat())
            }
            5 => {
                let (mut parts, other) = (pieces.clone(), chance.below(pieces.len()));
                if !parts.is_empty() {
                    parts.swap(row, other);
                }
                (Self::Swapped, parts.concat())
            }
            6 => {
                let at = chance.below(bytes.len());
                (Self::Cut, bytes.get(..at).unwrap_or_default().to_vec())
            }
            _ => {
                let (at, other) = (chance.below(bytes.len()), &seeds.any(chance).bytes);
                let from = chance.below(other.len());
                let stretch = other.get(from..other.len().min(from + 500)).unwrap_or_default();
                let (before, behind) = bytes.split_at(at);
                (Self::Mixed, [before, stretch, behind].concat())
            }
        }
    }

    /// Whether every unchanged row is a row of the original file.
    pub const fn keeps_rows(self) -> bool {
        !matches!(self, Self::Cut | Self::Mixed)
    }
}

/// The rows of a text, or pieces of a binary file.
fn pieces(bytes: &[u8]) -> Vec<&[u8]> {
    if std::str::from_utf8(bytes).is_ok() { rows(bytes) } else { bytes.chunks(STRETCH).collect() }
}

fn with_hard_field(piece: &[u8], chance: &mut Chance) -> Vec<u8> {
    let Ok(text) = std::str::from_utf8(piece) else {
        let mut piece = piece.to_vec();
        let hard = chance.of(&[0_u32, 1, 0x7FFF_FFFF, 0x8000_0000, u32::MAX]).copied().unwrap_or_default();
        let at = chance.below(piece.len().saturating_sub(4));
        if let Some(field) = piece.get_mut(at..at + 4) {
            field.copy_from_slice(&hard.to_le_bytes());
        }
        return piece;
    };
    let (line, end) = text.strip_suffix('\n').map_or((text, ""), |line| (line, "\n"));
    let is_between = |c: char| [' ', ',', ';', '=', '#', '(', ')', '\t'].contains(&c);
    let fields: Vec<&str> = line.split_inclusive(is_between).collect();
    let changed = chance.below(fields.len());
    let hard = chance.of(&HARD).copied().unwrap_or_default();
    let field = |(at, field): (usize, &&str)| {
        let separator = field.chars().last().filter(|&c| is_between(c)).map(String::from).unwrap_or_default();
        if at == changed { format!("{hard}{separator}") } else { (*field).to_owned() }
    };
    let line: String = fields.iter().enumerate().map(field).collect();
    format!("{line}{end}").into_bytes()
}
