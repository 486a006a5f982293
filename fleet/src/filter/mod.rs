//! Filters that are asked before a row is made: plain data, which travel with a plan.

mod expression;

pub use expression::tests_of;

use crate::table::column::{Get, Rows, Take, nanos};
use serde::{Deserialize, Serialize};

/// A column and what is asked of its value.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
pub struct Test {
    /// The column's name.
    pub column: String,
    /// What must hold.
    pub condition: Condition,
}

/// What must hold of a value. Of a value that is null nothing holds but [`Condition::Null`], as in SQL.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
pub enum Condition {
    /// It is not less and not more; `None` is open. Times in nanoseconds; yes is 1, no is 0.
    Between(Option<i128>, Option<i128>),
    /// It is one of these.
    OneOf(Vec<i128>),
    /// It is none of these.
    NoneOf(Vec<i128>),
    /// It is one of these texts.
    OneOfTexts(Vec<String>),
    /// It is none of these texts.
    NoneOfTexts(Vec<String>),
    /// There is none.
    Null,
    /// There is one.
    NotNull,
}

impl Condition {
    /// Whether it holds of a number.
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

    /// Whether it holds of a text.
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

/// The tests of one table, with how each finds its value.
pub struct Filter<R: Rows> {
    tests: Vec<Found<R>>,
    scratch: String,
}

/// A test and its column.
enum Found<R: Rows> {
    /// The number is that one, as is asked most.
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
    /// These tests. One of a column that the table has not lets nothing pass.
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

    /// Those of these tests that tell by one row what they say of all that are alike; of frames with 29-bit CAN-IDs `any_id`
    /// leaves the CAN-ID out, which is another one for each.
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
        // `tests_of` makes no tests of these.
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
