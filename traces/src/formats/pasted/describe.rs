//! The meaning of the columns in words, as the reader says it.

use super::Meaning;
use super::layout::{Behind, Core, DataForm, Role};

impl Meaning {
    /// The meaning of the columns in words.
    pub(super) fn describe(&self) -> String {
        let layout = match self {
            Self::Columns(layout) => layout,
            Self::Table(table) => return table.describe(),
        };
        let mut parts = Vec::new();
        if layout.has(Role::Time) || layout.behind == Behind::Time {
            let kind = if layout.differences { "time since the line before" } else { "time" };
            parts.push(format!("{kind} in {}", layout.unit.symbol()));
        }
        if layout.has(Role::Channel) {
            parts.push("channel".to_owned());
        }
        match layout.core {
            Core::Notation => parts.push("frames in candump's notation".to_owned()),
            Core::Slcan => parts.push("frames in SLCAN's notation".to_owned()),
            Core::Apart => {
                parts.push(if layout.id_is_decimal { "id in decimal" } else { "id in hex" }.to_owned());
                if layout.has(Role::Length) {
                    parts.push("length".to_owned());
                }
                parts.push(
                    if layout.data == DataForm::Decimal { "bytes in decimal" } else { "bytes in hex" }.to_owned(),
                );
            }
        }
        if layout.behind == Behind::CycleAndCount {
            parts.push("a list with the last frame of each id, and no times".to_owned());
        }
        parts.join(", ")
    }
}
