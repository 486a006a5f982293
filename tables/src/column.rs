//! Columns of tables: name, type and meaning of each, and the function that gets its value from a row.

use arrow_schema::{DataType, Field, TimeUnit};
use canvass_traces::Timestamp;

/// The rows of one table.
pub trait Rows: Sized + 'static {
    /// A row, which borrows its data.
    type Row<'a>;

    /// The columns, in their order.
    const COLUMNS: &'static [Column<Self>];

    /// The columns whose values are the same for frames that are alike ([`canvass_analyzer::network::Steady`]), in
    /// tables with rows of frames. For frames with 29-bit CAN-IDs, `can_id` is not the same.
    const ALIKE: &'static [&'static str] = &[];

    /// Whether the columns at these indexes contain the column with this name.
    fn asks(columns: &[usize], name: &str) -> bool {
        columns.iter().filter_map(|&at| Self::COLUMNS.get(at)).any(|column| column.name == name)
    }
}

/// A column of a table.
pub struct Column<R: Rows> {
    /// The name of the column.
    pub name: &'static str,
    /// The meaning of the column: one line of the documentation.
    pub doc: &'static str,
    /// The function that gets the column's value from a row.
    pub get: Get<R>,
}

/// The width of an unsigned integer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Width {
    /// 8 bits.
    U8,
    /// 16 bits.
    U16,
    /// 32 bits.
    U32,
    /// 64 bits.
    U64,
}

/// Gets a value from a row.
pub type Take<R, T> = for<'a, 'b> fn(&'b <R as Rows>::Row<'a>) -> Option<T>;
/// Writes a text of a row; `false` if the row has no text.
pub type Write<R> = for<'a, 'b, 'c> fn(&'b <R as Rows>::Row<'a>, &'c mut String) -> bool;
/// Borrows bytes of a row.
pub type Borrow<R> = for<'a, 'b> fn(&'b <R as Rows>::Row<'a>) -> Option<&'b [u8]>;

/// The function that gets the value of a column from a row, by the type of the value.
pub enum Get<R: Rows> {
    /// A time: nanoseconds, UTC.
    Time(Take<R, Timestamp>),
    /// An unsigned integer.
    Unsigned(Width, Take<R, u64>),
    /// A signed integer.
    Signed(Take<R, i64>),
    /// A floating-point number.
    Real(Take<R, f64>),
    /// Yes or no.
    Flag(Take<R, bool>),
    /// One of a few words of the program: a dictionary.
    Word(Take<R, &'static str>),
    /// A text with few different values: a dictionary.
    Name(Write<R>),
    /// A text.
    Text(Write<R>),
    /// Bytes.
    Bytes(Borrow<R>),
}

impl<R: Rows> Clone for Get<R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Rows> Copy for Get<R> {}

impl<R: Rows> Get<R> {
    /// The Arrow type.
    pub fn data_type(&self) -> DataType {
        match self {
            Self::Time(_) => DataType::Timestamp(TimeUnit::Nanosecond, Some("UTC".into())),
            Self::Unsigned(Width::U8, _) => DataType::UInt8,
            Self::Unsigned(Width::U16, _) => DataType::UInt16,
            Self::Unsigned(Width::U32, _) => DataType::UInt32,
            Self::Unsigned(Width::U64, _) => DataType::UInt64,
            Self::Signed(_) => DataType::Int64,
            Self::Real(_) => DataType::Float64,
            Self::Flag(_) => DataType::Boolean,
            Self::Word(_) | Self::Name(_) => dictionary(),
            Self::Text(_) => DataType::Utf8,
            Self::Bytes(_) => DataType::Binary,
        }
    }
}

impl<R: Rows> Column<R> {
    /// The Arrow field. Every column may be null, if a capture lacks the value.
    pub fn field(&self) -> Field {
        Field::new(self.name, self.get.data_type(), true)
    }
}

/// The type of texts with few different values.
pub fn dictionary() -> DataType {
    DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8))
}

/// The time in Arrow's form: signed nanoseconds. Times after 2262-04-11 become that date.
pub fn nanos(time: Timestamp) -> i64 {
    i64::try_from(time.nanos()).unwrap_or(i64::MAX)
}

/// Declares columns: `name: kind "meaning" = |row| value;`, one after the other.
#[macro_export]
macro_rules! columns {
    ($rows:ty: $($name:literal $kind:ident $doc:literal = $get:expr;)*) => {
        &[$($crate::column::Column::<$rows> {
            name: $name,
            doc: $doc,
            get: $crate::columns!(@get $rows, $kind, $get),
        }),*]
    };
    (@get $rows:ty, time, $get:expr) => { $crate::column::Get::Time($get) };
    (@get $rows:ty, u8, $get:expr) => {
        $crate::column::Get::Unsigned($crate::column::Width::U8, $get)
    };
    (@get $rows:ty, u16, $get:expr) => {
        $crate::column::Get::Unsigned($crate::column::Width::U16, $get)
    };
    (@get $rows:ty, u32, $get:expr) => {
        $crate::column::Get::Unsigned($crate::column::Width::U32, $get)
    };
    (@get $rows:ty, u64, $get:expr) => {
        $crate::column::Get::Unsigned($crate::column::Width::U64, $get)
    };
    (@get $rows:ty, i64, $get:expr) => { $crate::column::Get::Signed($get) };
    (@get $rows:ty, f64, $get:expr) => { $crate::column::Get::Real($get) };
    (@get $rows:ty, flag, $get:expr) => { $crate::column::Get::Flag($get) };
    (@get $rows:ty, word, $get:expr) => { $crate::column::Get::Word($get) };
    (@get $rows:ty, name, $get:expr) => { $crate::column::Get::Name($get) };
    (@get $rows:ty, text, $get:expr) => { $crate::column::Get::Text($get) };
    (@get $rows:ty, bytes, $get:expr) => { $crate::column::Get::Bytes($get) };
}

/// Writes a value; `false` if there is none.
pub fn write(out: &mut String, text: Option<impl std::fmt::Display>) -> bool {
    use std::fmt::Write as _;
    // Writing to a string can't fail.
    text.is_some_and(|text| write!(out, "{text}").is_ok())
}

/// Writes a text; `false` if there is none.
pub fn write_str(out: &mut String, text: Option<&str>) -> bool {
    text.inspect(|text| out.push_str(text)).is_some()
}
