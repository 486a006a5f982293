//! What a table is made of: columns that say their name, type and meaning, and how a row gives their value.

use canvass_traces::Timestamp;
use datafusion::arrow::datatypes::{DataType, Field, TimeUnit};

/// The rows of one table.
pub trait Rows: Sized + 'static {
    /// A row, which borrows what it is made from.
    type Row<'a>;

    /// The columns, in their order.
    const COLUMNS: &'static [Column<Self>];

    /// The columns whose values are the same for frames that are alike ([`canvass_analyzer::network::Steady`]), where rows are
    /// made of frames. `can_id` is not the same for those with 29 bits.
    const ALIKE: &'static [&'static str] = &[];

    /// Whether a column is among those at these places.
    fn asks(columns: &[usize], name: &str) -> bool {
        columns.iter().filter_map(|&at| Self::COLUMNS.get(at)).any(|column| column.name == name)
    }
}

/// A column of a table.
pub struct Column<R: Rows> {
    /// What it is called.
    pub name: &'static str,
    /// What it says: one line of the documentation.
    pub doc: &'static str,
    /// How its value comes out of a row.
    pub get: Get<R>,
}

/// How wide a whole number from 0 is.
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

/// Takes a value out of a row.
pub type Take<R, T> = for<'a, 'b> fn(&'b <R as Rows>::Row<'a>) -> Option<T>;
/// Writes a text that a row has; `false` where it has none.
pub type Write<R> = for<'a, 'b, 'c> fn(&'b <R as Rows>::Row<'a>, &'c mut String) -> bool;
/// Borrows bytes of a row.
pub type Borrow<R> = for<'a, 'b> fn(&'b <R as Rows>::Row<'a>) -> Option<&'b [u8]>;

/// How the value of a column comes out of a row, by its type.
pub enum Get<R: Rows> {
    /// A point in time: nanoseconds, UTC.
    Time(Take<R, Timestamp>),
    /// A whole number from 0.
    Unsigned(Width, Take<R, u64>),
    /// A whole number with a sign.
    Signed(Take<R, i64>),
    /// A floating-point number.
    Real(Take<R, f64>),
    /// Yes or no.
    Flag(Take<R, bool>),
    /// One of a few words: a dictionary.
    Word(Take<R, &'static str>),
    /// A text of which there are few: a dictionary.
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
    /// The Arrow field. Every column may be null: what a capture does not say is not made up.
    pub fn field(&self) -> Field {
        Field::new(self.name, self.get.data_type(), true)
    }
}

/// The type of texts of which there are few.
pub fn dictionary() -> DataType {
    DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8))
}

/// The time as Arrow holds it: signed nanoseconds. Times after 2262-04-11 are given as that moment.
pub fn nanos(time: Timestamp) -> i64 {
    i64::try_from(time.nanos()).unwrap_or(i64::MAX)
}

/// Declares columns: `name: kind "meaning" = |row| value;`, one after the other.
macro_rules! columns {
    ($rows:ty: $($name:literal $kind:ident $doc:literal = $get:expr;)*) => {
        &[$($crate::table::column::Column::<$rows> {
            name: $name,
            doc: $doc,
            get: $crate::table::column::columns!(@get $rows, $kind, $get),
        }),*]
    };
    (@get $rows:ty, time, $get:expr) => { $crate::table::column::Get::Time($get) };
    (@get $rows:ty, u8, $get:expr) => {
        $crate::table::column::Get::Unsigned($crate::table::column::Width::U8, $get)
    };
    (@get $rows:ty, u16, $get:expr) => {
        $crate::table::column::Get::Unsigned($crate::table::column::Width::U16, $get)
    };
    (@get $rows:ty, u32, $get:expr) => {
        $crate::table::column::Get::Unsigned($crate::table::column::Width::U32, $get)
    };
    (@get $rows:ty, u64, $get:expr) => {
        $crate::table::column::Get::Unsigned($crate::table::column::Width::U64, $get)
    };
    (@get $rows:ty, i64, $get:expr) => { $crate::table::column::Get::Signed($get) };
    (@get $rows:ty, f64, $get:expr) => { $crate::table::column::Get::Real($get) };
    (@get $rows:ty, flag, $get:expr) => { $crate::table::column::Get::Flag($get) };
    (@get $rows:ty, word, $get:expr) => { $crate::table::column::Get::Word($get) };
    (@get $rows:ty, name, $get:expr) => { $crate::table::column::Get::Name($get) };
    (@get $rows:ty, text, $get:expr) => { $crate::table::column::Get::Text($get) };
    (@get $rows:ty, bytes, $get:expr) => { $crate::table::column::Get::Bytes($get) };
}
pub(crate) use columns;

/// Writes what there is.
pub fn write(out: &mut String, text: Option<impl std::fmt::Display>) -> bool {
    use std::fmt::Write as _;
    // Writing to a string can't fail.
    text.is_some_and(|text| write!(out, "{text}").is_ok())
}

/// Writes a text that is there.
pub fn write_str(out: &mut String, text: Option<&str>) -> bool {
    text.inspect(|text| out.push_str(text)).is_some()
}
