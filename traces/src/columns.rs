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
    /// The time since the line before.
    Delta(Option<Unit>),
    /// A date whose numbers slashes separate.
    Date(DateOrder),
    Channel,
    Direction,
    Id(IdForm),
    Length,
    Data(Option<Radix>),
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum IdForm {
    Usual,
    Hexadecimal,
    /// An identifier of eight digits has 29 bits.
    Bits29,
    Decimal,
    /// An identifier of eight digits has 11 bits.
    Bits11,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum DateOrder {
    DayFirst,
    MonthFirst,
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
        "unknown column \"{0}\": expected line, time, time[s], time[ms], time[us], time[ns], delta (with the same \
         units), date[dmy], date[mdy], channel, dir, id, id[hex], id[dec], id[11], id[29], len, data, data[hex] or \
         data[dec]"
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
        "delta" => Column::Delta(None),
        "date[dmy]" => Column::Date(DateOrder::DayFirst),
        "date[mdy]" => Column::Date(DateOrder::MonthFirst),
        "channel" | "bus" => Column::Channel,
        "dir" | "direction" => Column::Direction,
        "id" => Column::Id(IdForm::Usual),
        "id[hex]" => Column::Id(IdForm::Hexadecimal),
        "id[29]" => Column::Id(IdForm::Bits29),
        "id[dec]" => Column::Id(IdForm::Decimal),
        "id[11]" => Column::Id(IdForm::Bits11),
        "len" | "dlc" => Column::Length,
        "data" => Column::Data(None),
        "data[hex]" => Column::Data(Some(Radix::Hexadecimal)),
        "data[dec]" => Column::Data(Some(Radix::Decimal)),
        _ => {
            let (kind, unit) = name.strip_suffix(']')?.split_once('[')?;
            let unit = Some(Unit::by_symbol(unit.as_bytes())?);
            match kind {
                "time" => Column::Time(unit),
                "delta" => Column::Delta(unit),
                _ => return None,
            }
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
        let unit = |column: &Column| match column {
            Column::Time(unit) | Column::Delta(unit) => *unit,
            _ => None,
        };
        self.columns.iter().find_map(unit)
    }

    pub(crate) fn id(&self) -> IdForm {
        let id = |column: &Column| if let Column::Id(form) = column { Some(*form) } else { None };
        self.columns.iter().find_map(id).unwrap_or(IdForm::Usual)
    }

    /// The radix of the data, if the columns give it.
    pub(crate) fn data(&self) -> Option<Radix> {
        self.columns.iter().find_map(|column| if let Column::Data(radix) = column { *radix } else { None })
    }

    /// The detail in the brackets of the column with this name, if it has one.
    pub(crate) fn detail<'a>(&'a self, name: &str) -> &'a str {
        let detail = |column: &'a str| column.trim().strip_prefix(name)?.strip_prefix('[')?.strip_suffix(']');
        let found = self.text.split(',').find_map(detail);
        found.unwrap_or_default()
    }

    /// Whether dates with slashes begin with the month, if the columns give it.
    pub(crate) fn month_first(&self) -> Option<bool> {
        self.columns.iter().find_map(|column| {
            if let Column::Date(order) = column { Some(*order == DateOrder::MonthFirst) } else { None }
        })
    }

    pub(crate) fn decides_wide_ids(&self) -> bool {
        matches!(self.id(), IdForm::Bits11 | IdForm::Bits29)
    }

    pub(crate) fn decides_ids(&self) -> bool {
        self.id() != IdForm::Usual
    }

    pub(crate) fn decides_data(&self) -> bool {
        self.data().is_some()
    }

    pub(crate) fn decides_dates(&self) -> bool {
        self.month_first().is_some()
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
