//! The meaning of columns as a person gives it: `time[ms],id,len,data`.

use super::clock::Unit;
use super::layout::{Core, DataForm, Layout, Role};
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
    columns: Vec<Column>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Column {
    Line,
    Time(Option<Unit>),
    Channel,
    Direction,
    Id(IdForm),
    Length,
    Data(Option<Radix>),
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum IdForm {
    Usual,
    Decimal,
    /// An identifier of eight digits has 11 bits.
    Bits11,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Radix {
    Hexadecimal,
    Decimal,
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
    pub(super) fn unit(&self) -> Option<Unit> {
        self.columns.iter().find_map(|column| if let Column::Time(unit) = column { *unit } else { None })
    }

    /// The layouts that these columns can mean. Times of the day, dates and names of channels are no numbers, so they
    /// may or may not fill a column of numbers.
    pub(super) fn layouts(&self) -> Vec<Layout> {
        let forms: &[DataForm] = match self.columns.last() {
            Some(Column::Data(Some(Radix::Hexadecimal))) => &[DataForm::Padded, DataForm::Compact, DataForm::Unpadded],
            Some(Column::Data(Some(Radix::Decimal))) => &[DataForm::Decimal],
            _ => &[DataForm::Padded, DataForm::Compact, DataForm::Unpadded, DataForm::Decimal],
        };
        let variants = [(true, true), (true, false), (false, true), (false, false)];
        let layouts = forms.iter().flat_map(|form| {
            variants.iter().map(|(time, channel)| self.layout(*form, *time, *channel)).collect::<Vec<_>>()
        });
        let mut distinct = Vec::new();
        for layout in layouts {
            if !distinct.contains(&layout) {
                distinct.push(layout);
            }
        }
        distinct
    }

    fn layout(&self, form: DataForm, time: bool, channel: bool) -> Layout {
        let role = |column: &Column| match column {
            Column::Line => Some(Role::Skip),
            Column::Time(_) => time.then_some(Role::Time),
            Column::Channel => channel.then_some(Role::Channel),
            Column::Id(_) => Some(Role::Id),
            Column::Length => Some(Role::Length),
            Column::Direction | Column::Data(_) => None,
        };
        let mut layout = Layout::new(self.columns.iter().filter_map(role).collect(), Core::Apart, form);
        layout.id_is_decimal = self.columns.contains(&Column::Id(IdForm::Decimal));
        layout.wide_is_standard = self.columns.contains(&Column::Id(IdForm::Bits11));
        layout
    }

    pub(super) fn decides_wide_ids(&self) -> bool {
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
