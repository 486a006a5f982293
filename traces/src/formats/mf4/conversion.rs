//! Conversions of the numbers in a record: linear ones, and tables such as that of a data length code.

use crate::damage::Flaw;
use nom::bytes::complete::take;
use nom::multi::count;
use nom::number::complete::{le_f64, le_u16, u8};
use nom::{IResult, Parser};

/// How a number in a record becomes the value of its channel.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Conversion {
    None,
    /// Offset and factor.
    Linear([f64; 2]),
    /// Numbers with their values.
    Table(Vec<(f64, f64)>),
}

const IDENTICAL: u8 = 0;
const LINEAR: u8 = 1;
/// A table whose numbers between two keys take the nearest value; with linear interpolation, which whole numbers of
/// frames do not need.
const TABLES: [u8; 2] = [4, 5];

/// Parses type, precision, flags, numbers of references and of values, range, values.
fn values(i: &[u8]) -> IResult<&[u8], (u8, Vec<f64>)> {
    let (i, (kind, _, _, _, length, _)) = (u8, u8, le_u16, le_u16, le_u16, take(16usize)).parse(i)?;
    count(le_f64, length.into()).map(|values| (kind, values)).parse(i)
}

impl Conversion {
    /// Reads the data of a block CC. A conversion into text, or by a formula, leaves the number as it is.
    pub fn read(data: &[u8]) -> Result<Self, Flaw> {
        let Ok((_, (kind, values))) = values(data) else {
            return Err(Flaw::malformed("a whole conversion", format!("{} bytes", data.len())));
        };
        match (kind, &values[..]) {
            (LINEAR, &[offset, factor, ..]) => Ok(Self::Linear([offset, factor])),
            (kind, pairs) if TABLES.contains(&kind) => {
                Ok(Self::Table(pairs.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect()))
            }
            (IDENTICAL | LINEAR.., _) => Ok(Self::None),
        }
    }

    /// Offset and factor.
    pub const fn linear(&self) -> [f64; 2] {
        match self {
            Self::Linear(linear) => *linear,
            Self::None | Self::Table(_) => [0.0, 1.0],
        }
    }

    /// The value of a number, as a whole number.
    pub fn whole(&self, raw: u64) -> u64 {
        match self {
            Self::None => raw,
            // A value below zero becomes 0.
            Self::Linear([offset, factor]) => (offset + factor * raw as f64).round() as u64,
            Self::Table(pairs) => {
                let distance = |pair: &&(f64, f64)| (pair.0 - raw as f64).abs();
                let nearest = pairs.iter().min_by(|one, other| distance(one).total_cmp(&distance(other)));
                nearest.map_or(raw, |(_, value)| value.round() as u64)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(kind: u8, values: &[f64]) -> Vec<u8> {
        let head = [&[kind, 0, 0, 0, 0, 0][..], &(values.len() as u16).to_le_bytes(), &[0; 16]].concat();
        values.iter().fold(head, |mut block, value| {
            block.extend(value.to_le_bytes());
            block
        })
    }

    #[test]
    fn constants_and_tables() {
        let read = |kind, values: &[f64]| Conversion::read(&block(kind, values)).unwrap();
        assert_eq!(read(1, &[9.0, 0.0]).whole(0), 9, "a constant");
        assert_eq!(read(1, &[1.0, 2.0]).whole(3), 7);
        assert_eq!(read(5, &[8.0, 8.0, 9.0, 12.0, 15.0, 64.0]).whole(9), 12, "a data length code of CAN FD");
        assert_eq!(read(0, &[]).whole(5), 5);
        assert_eq!(read(7, &[1.0]).whole(5), 5, "a conversion into text");
        assert!(Conversion::read(&block(1, &[9.0, 0.0])[..20]).is_err());
    }
}
