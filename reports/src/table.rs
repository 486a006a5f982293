//! Tables for terminals. WebAssembly has neither terminals nor colours.

use comfy_table::{ContentArrangement, Table, presets};

/// A table of this width, with or without colours, whatever the actual terminal is.
pub(crate) fn table(width: u16, colors: bool) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Dynamic);
    style(&mut table, colors);
    table.set_width(width);
    table
}

#[cfg(not(target_family = "wasm"))]
fn style(table: &mut Table, colors: bool) {
    if colors {
        table.enforce_styling();
    } else {
        table.force_no_tty();
    }
}

#[cfg(target_family = "wasm")]
const fn style(_: &mut Table, _: bool) {}
