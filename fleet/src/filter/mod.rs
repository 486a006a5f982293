//! Filters that are applied before a row is made. They are plain data, so that they can be sent with a plan.

mod expression;

pub use expression::tests_of;

use crate::table::column::{Get, Rows, Take, nanos};
use serde::{Deserialize, Serialize};

/// A column and the condition on its value.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
pub struct Test {
    /// The column's name.
    pub column: String,
    /// The condition on the value.
    pub condition: Condition,
}

/// A condition on a value. As in SQL, a value that is null fulfils no condition but [`Condition::Null`].
#[derive(Clone, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
pub enum Condition {
    /// The value is in this range, both ends included; `None` is open. Times are in nanoseconds, yes is 1, no is 0.
    Between(Option<i128>, Option<i128>),
    /// The value is one of these numbers.
    OneOf(Vec<i128>),
    /// The value is none of these numbers.
    NoneOf(Vec<i128>),
    /// The value is one of these texts.
    OneOfTexts(Vec<String>),
    /// The value is none of these texts.
    NoneOfTexts(Vec<String>),
    /// The value is null.
    Null,
    /// The value is not null.
    NotNull,
}

impl Condition {
    /// Whether a number fulfils the condition.
    pub fn of_number(&self, value: Option<i128>) -> bool {
        let Some(value) = value else { return matches!(self, Self::Null) };
        match self {
            Self::Between(low, high) => low.is_none_or(|low| low <= value) && high.is_none_or(|high| value <= high),
            Self::OneOf(any) => any.contains(&value),
            Self::NoneOf(none) => !none.contains(&value),
            Self::NotNull => true,
            Self::Null | Self::OneOfTexts(_) | Self::NoneOfTexts(_) => false,
        }
    }

    /// Whether a text fulfils the condition.
    pub fn of_text(&self, value: Option<&str>) -> bool {
        let Some(value) = value else { return matches!(self, Self::Null) };
        match self {
            Self::OneOfTexts(any) => any.iter().any(|text| text == value),
            Self::NoneOfTexts(none) => !none.iter().any(|text| text == value),
            Self::NotNull => true,
            Self::Null | Self::Between(..) | Self::OneOf(_) | Self::NoneOf(_) => false,
        }
    }
}

/// The tests of one table, each with the function that gets its value.
pub struct Filter<R: Rows> {
    tests: Vec<Found<R>>,
    scratch: String,
}

/// A test and its column.
enum Found<R: Rows> {
    /// The number has this value: the most frequent test, and the fastest.
    Is(Take<R, u64>, u64),
    Any(Get<R>, Condition),
}

impl<R: Rows> Found<R> {
    fn new(get: Get<R>, condition: Condition) -> Self {
        let one = match (&condition, &get) {
            (Condition::OneOf(values), Get::Unsigned(_, get)) => {
                <[i128; 1]>::try_from(&values[..]).ok().map(|[one]| (*get, one))
            }
            (Condition::Between(Some(low), Some(high)), Get::Unsigned(_, get)) if low == high => Some((*get, *low)),
            _ => None,
        };
        match one.and_then(|(get, one)| Some((get, u64::try_from(one).ok()?))) {
            Some((get, one)) => Self::Is(get, one),
            None => Self::Any(get, condition),
        }
    }
}

impl<R: Rows> Filter<R> {
    /// A filter of these tests. A test of a column that the table lacks lets no row pass.
    pub fn new(tests: &[Test]) -> Self {
        let find = |test: &Test| {
            let column = R::COLUMNS.iter().find(|column| column.name == test.column);
            let never: Get<R> = Get::Flag(|_| None);
            match column {
                Some(column) => Found::new(column.get, test.condition.clone()),
                None => Found::Any(never, Condition::NotNull),
            }
        };
        Self { tests: tests.iter().map(find).collect(), scratch: String::new() }
    }

    /// A filter with only the tests that give the same result for all rows of frames that are alike. Frames with 29-bit
    /// CAN-IDs may be alike and differ in the CAN-ID: `any_id` omits the tests of the CAN-ID.
    pub fn of_alike(tests: &[Test], any_id: bool) -> Self {
        let is_alike = |test: &&Test| R::ALIKE.contains(&&*test.column) && !(any_id && test.column == "can_id");
        Self::new(&tests.iter().filter(is_alike).cloned().collect::<Vec<_>>())
    }

    /// Whether there is no test: all rows pass.
    pub const fn is_empty(&self) -> bool {
        self.tests.is_empty()
    }

    /// Whether a row passes all tests.
    #[inline]
    pub fn passes(&mut self, row: &R::Row<'_>) -> bool {
        let scratch = &mut self.scratch;
        self.tests.iter().all(|test| match test {
            Found::Is(get, value) => get(row) == Some(*value),
            Found::Any(get, condition) => passes(get, condition, row, scratch),
        })
    }
}

fn passes<R: Rows>(get: &Get<R>, condition: &Condition, row: &R::Row<'_>, scratch: &mut String) -> bool {
    match get {
        Get::Time(get) => condition.of_number(get(row).map(|time| i128::from(nanos(time)))),
        Get::Unsigned(_, get) => condition.of_number(get(row).map(i128::from)),
        Get::Signed(get) => condition.of_number(get(row).map(i128::from)),
        Get::Flag(get) => condition.of_number(get(row).map(i128::from)),
        Get::Word(get) => condition.of_text(get(row)),
        Get::Name(write) | Get::Text(write) => {
            scratch.clear();
            let is_there = write(row, scratch);
            condition.of_text(is_there.then_some(scratch.as_str()))
        }
        // `tests_of` makes no tests of such columns.
        Get::Real(_) | Get::Bytes(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_holds_of_null_but_that_it_is() {
        let all = [
            Condition::Between(None, None),
            Condition::OneOf(vec![1]),
            Condition::NoneOf(vec![1]),
            Condition::OneOfTexts(vec![]),
            Condition::NoneOfTexts(vec![]),
            Condition::NotNull,
        ];
        assert!(all.iter().all(|condition| !condition.of_number(None) && !condition.of_text(None)));
        assert!(Condition::Null.of_number(None) && Condition::Null.of_text(None));
        assert!(!Condition::Null.of_number(Some(0)) && !Condition::Null.of_text(Some("")));
    }
}
