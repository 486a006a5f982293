//! The meaning of columns as a person gives it: `time[ms],id,len,data`.

use std::fmt;
use std::str::FromStr;

/// The meaning of the numbers in pasted lines, in their order, for lines that fit several readings.
///
/// ```
/// use canvass_traces::Columns;
///
/// let columns: Columns = "line,time[ms],id,len,data".parse()?;
/// assert_eq!(columns.to_string(), "line,time[ms],id,len,data");
/// assert!("time,len".parse::<Columns>().is_err(), "an identifier and data are needed");
/// # Ok::<(), canvass_traces::ColumnsError>(())
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Columns {
    text: String,
    pub(crate) columns: Vec<Column>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Column {
    Line,
    Time(Option<Unit>),
    Channel,
    Direction,
    Id(IdForm),
    Length,
    Data(Option<Radix>),
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum IdForm {
    Usual,
    Decimal,
    /// An identifier of eight digits has 11 bits.
    Bits11,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Radix {
    Hexadecimal,
    Decimal,
}

/// The unit of times that are plain numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Unit {
    Seconds,
    Millis,
    Micros,
    Nanos,
}

impl Unit {
    pub(crate) const ALL: [Self; 4] = [Self::Seconds, Self::Millis, Self::Micros, Self::Nanos];

    pub(crate) const fn nanos(self) -> u64 {
        match self {
            Self::Seconds => 1_000_000_000,
            Self::Millis => 1_000_000,
            Self::Micros => 1_000,
            Self::Nanos => 1,
        }
    }

    /// The unit's symbol, as in `time[ms]`.
    pub(crate) const fn symbol(self) -> &'static str {
        match self {
            Self::Seconds => "s",
            Self::Millis => "ms",
            Self::Micros => "us",
            Self::Nanos => "ns",
        }
    }

    pub(crate) fn by_symbol(symbol: &[u8]) -> Option<Self> {
        match symbol {
            b"\xC2\xB5s" | b"\xCE\xBCs" => Some(Self::Micros),
            _ => Self::ALL.into_iter().find(|unit| unit.symbol().as_bytes() == symbol),
        }
    }
}

/// Why a text names no columns.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ColumnsError {
    /// A column has an unknown name.
    #[error(
        "unknown column \"{0}\": expected line, time, time[s], time[ms], time[us], time[ns], channel, dir, id, id[hex], \
         id[dec], id[11], id[29], len, data, data[hex] or data[dec]"
    )]
    Unknown(String),
    /// The identifier or the data are missing, or the data are not last.
    #[error("expected id and, as the last column, data, such as time[ms],id,len,data")]
    Incomplete,
}

impl FromStr for Columns {
    type Err = ColumnsError;

    fn from_str(text: &str) -> Result<Self, ColumnsError> {
        let column = |name: &str| column(name.trim()).ok_or_else(|| ColumnsError::Unknown(name.trim().to_owned()));
        let columns = text.split(',').map(column).collect::<Result<Vec<_>, _>>()?;
        let ids = columns.iter().filter(|column| matches!(column, Column::Id(_))).count();
        match columns.split_last() {
            Some((Column::Data(_), before))
                if ids == 1 && !before.iter().any(|column| matches!(column, Column::Data(_))) =>
            {
                Ok(Self { text: text.to_owned(), columns })
            }
            _ => Err(ColumnsError::Incomplete),
        }
    }
}

fn column(name: &str) -> Option<Column> {
    Some(match name {
        "line" | "number" | "-" => Column::Line,
        "time" => Column::Time(None),
        "channel" | "bus" => Column::Channel,
        "dir" | "direction" => Column::Direction,
        "id" | "id[hex]" | "id[29]" => Column::Id(IdForm::Usual),
        "id[dec]" => Column::Id(IdForm::Decimal),
        "id[11]" => Column::Id(IdForm::Bits11),
        "len" | "dlc" => Column::Length,
        "data" => Column::Data(None),
        "data[hex]" => Column::Data(Some(Radix::Hexadecimal)),
        "data[dec]" => Column::Data(Some(Radix::Decimal)),
        _ => {
            let unit = name.strip_prefix("time[")?.strip_suffix(']')?;
            Column::Time(Some(Unit::by_symbol(unit.as_bytes())?))
        }
    })
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Columns {
    /// The unit of the time, if the columns give it.
    pub(crate) fn unit(&self) -> Option<Unit> {
        self.columns.iter().find_map(|column| if let Column::Time(unit) = column { *unit } else { None })
    }

    pub(crate) fn decides_wide_ids(&self) -> bool {
        self.text.contains("id[11]") || self.text.contains("id[29]")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_list_of_columns_is_refused() {
        for (text, expected) in [
            ("time,id,len,date", "unknown column \"date\""),
            ("time[h],id,data", "unknown column \"time[h]\""),
            ("time,id", "expected id and"),
            ("data,id", "expected id and"),
            ("id,id,data", "expected id and"),
            ("", "unknown column \"\""),
        ] {
            let error = text.parse::<Columns>().unwrap_err().to_string();
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }
}
