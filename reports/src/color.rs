//! Colours of the terminal, for lines and for table cells.

use comfy_table::Cell;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Color {
    Red,
    Green,
    Yellow,
    Magenta,
    Cyan,
    Grey,
}

/// The escape sequence that ends a colour.
const END: &str = "\x1b[0m";

/// Appends the escape sequence that begins the colour, if there is one.
pub(crate) fn push_begin(color: Option<Color>, out: &mut Vec<u8>) {
    if let Some(color) = color {
        out.extend_from_slice(color.escape().as_bytes());
    }
}

/// Appends the escape sequence that ends the colour, if there is one.
pub(crate) fn push_end(color: Option<Color>, out: &mut Vec<u8>) {
    if color.is_some() {
        out.extend_from_slice(END.as_bytes());
    }
}

impl Color {
    /// The escape sequence that begins the colour.
    const fn escape(self) -> &'static str {
        match self {
            Self::Red => "\x1b[31m",
            Self::Green => "\x1b[32m",
            Self::Yellow => "\x1b[33m",
            Self::Magenta => "\x1b[35m",
            Self::Cyan => "\x1b[36m",
            Self::Grey => "\x1b[90m",
        }
    }

    /// A text in this colour, if `wanted`.
    pub(crate) fn paint(self, text: &str, wanted: bool) -> String {
        if wanted { format!("{}{text}{END}", self.escape()) } else { text.to_owned() }
    }

    /// A cell in this colour. The table ignores it if colours are not wanted. WebAssembly has no colours.
    pub(crate) fn cell(self, cell: Cell) -> Cell {
        #[cfg(not(target_family = "wasm"))]
        let cell = cell.fg(match self {
            Self::Red => comfy_table::Color::Red,
            Self::Green => comfy_table::Color::Green,
            Self::Yellow => comfy_table::Color::Yellow,
            Self::Magenta => comfy_table::Color::Magenta,
            Self::Cyan => comfy_table::Color::Cyan,
            Self::Grey => comfy_table::Color::DarkGrey,
        });
        cell
    }
}

/// A cell in bold.
pub(crate) fn bold(cell: Cell) -> Cell {
    #[cfg(not(target_family = "wasm"))]
    let cell = cell.add_attribute(comfy_table::Attribute::Bold);
    cell
}
