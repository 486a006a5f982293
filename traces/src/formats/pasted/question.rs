//! Questions about lines that can be read in two ways.

use super::layout::{DataForm, Layout, Role};
use std::fmt;

/// Pasted lines that fit two readings, and the columns that choose one of them.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Question {
    readings: [String; 2],
    columns: [String; 2],
}

impl Question {
    pub(super) fn new(first: impl Into<String>, second: impl Into<String>, columns: [String; 2]) -> Self {
        Self { readings: [first.into(), second.into()], columns }
    }

    /// The two readings in words.
    pub fn readings(&self) -> [&str; 2] {
        self.readings.each_ref().map(String::as_str)
    }

    /// For each reading the [`Columns`](crate::Columns) that choose it.
    pub fn columns(&self) -> [&str; 2] {
        self.columns.each_ref().map(String::as_str)
    }
}

impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([first, second], [one, other]) = (self.readings(), self.columns());
        write!(f, "its lines fit two readings, {first} or {second}: give --columns {one} or --columns {other}")
    }
}

/// The columns of a layout as a person gives them. Details that are not in doubt are named only where they are unusual.
pub(super) fn columns_of(layout: &Layout, unit: &str, id: &str, data: &str) -> String {
    let id = match () {
        () if !id.is_empty() => id,
        () if layout.id_is_decimal => "dec",
        () => &layout.given.id,
    };
    let data = match () {
        () if !data.is_empty() => data,
        () if layout.data == DataForm::Decimal => "dec",
        () => &layout.given.data,
    };
    let time = if layout.differences { "delta" } else { "time" };
    let with = |name: &str, detail: &str| {
        if detail.is_empty() { name.to_owned() } else { format!("{name}[{detail}]") }
    };
    let column = |role: &Role| match role {
        Role::Skip | Role::Micros => "line".to_owned(),
        Role::Time => with(time, unit),
        Role::Channel => "channel".to_owned(),
        Role::Id => with("id", id),
        Role::Length => "len".to_owned(),
    };
    let date = (!layout.given.date.is_empty()).then(|| with("date", &layout.given.date));
    let mut columns: Vec<String> = date.into_iter().chain(layout.before.iter().map(column)).collect();
    columns.push(with("data", data));
    columns.join(",")
}
