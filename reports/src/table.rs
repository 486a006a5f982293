//! Tables for terminals. In WebAssembly there is none, and no colours.

use comfy_table::{ContentArrangement, Table, presets};

#[cfg(not(target_family = "wasm"))]
pub(crate) use comfy_table::{Attribute, Color};
#[cfg(target_family = "wasm")]
pub(crate) use plain::{Attribute, Color, Paint};

/// A table of that width, with colours or without, whatever is known of the terminal.
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

/// The names of colours, which do nothing.
#[cfg(target_family = "wasm")]
mod plain {
    use comfy_table::Cell;

    pub(crate) enum Color {
        Green,
        Yellow,
        Red,
        Magenta,
        Cyan,
        DarkGrey,
    }

    pub(crate) enum Attribute {
        Bold,
    }

    pub(crate) trait Paint: Sized {
        fn fg(self, _: Color) -> Self {
            self
        }

        fn add_attribute(self, _: Attribute) -> Self {
            self
        }
    }

    impl Paint for Cell {}
}
