//! The layouts that columns can mean which a person gives.

use super::layout::{Core, DataForm, Given, Layout, Role};
use crate::columns::{Column, Columns, IdForm, Radix};

/// The layouts that these columns can mean. Times of the day, dates and names of channels are no numbers, so they
/// may or may not fill a column of numbers.
pub(super) fn layouts(columns: &Columns) -> Vec<Layout> {
    let forms: &[DataForm] = match columns.columns.last() {
        Some(Column::Data(Some(Radix::Hexadecimal))) => &[DataForm::Padded, DataForm::Compact, DataForm::Unpadded],
        Some(Column::Data(Some(Radix::Decimal))) => &[DataForm::Decimal],
        _ => &[DataForm::Padded, DataForm::Compact, DataForm::Unpadded, DataForm::Decimal],
    };
    let variants = [(true, true), (true, false), (false, true), (false, false)];
    let layouts = forms.iter().flat_map(|form| {
        variants.iter().map(|(time, channel)| layout(columns, *form, *time, *channel)).collect::<Vec<_>>()
    });
    let mut distinct = Vec::new();
    for layout in layouts {
        if !distinct.contains(&layout) {
            distinct.push(layout);
        }
    }
    distinct
}

fn layout(columns: &Columns, form: DataForm, time: bool, channel: bool) -> Layout {
    let role = |column: &Column| match column {
        Column::Line => Some(Role::Skip),
        Column::Time(_) | Column::Delta(_) => time.then_some(Role::Time),
        Column::Channel => channel.then_some(Role::Channel),
        Column::Id(_) => Some(Role::Id),
        Column::Length => Some(Role::Length),
        Column::Direction | Column::Date(_) | Column::Data(_) => None,
    };
    let mut layout = Layout::new(columns.columns.iter().filter_map(role).collect(), Core::Apart, form);
    layout.id_is_decimal = columns.columns.contains(&Column::Id(IdForm::Decimal));
    let [id, data, date] = ["id", "data", "date"].map(|name| columns.detail(name).to_owned());
    layout.given = Given { id, data, date };
    layout.differences = columns.columns.iter().any(|column| matches!(column, Column::Delta(_)));
    layout.month_first = columns.month_first().unwrap_or(layout.month_first);
    layout.wide_is_standard = columns.columns.contains(&Column::Id(IdForm::Bits11));
    layout
}
