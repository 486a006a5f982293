//! For people: each kind of change once, with where it is and what follows from it.

use super::{Compared, fact, subject};
use crate::color::Color;
use canvass_analyzer::dictionary::difference::Class;
use std::fmt::Write;

pub(super) fn render(compared: &Compared, colors: bool) -> String {
    let mut text = String::new();
    for (kind, differences) in compared.by_kind() {
        let color = match kind.class {
            Class::Breaking => Color::Red,
            Class::Notable => Color::Yellow,
            Class::Harmless => Color::Green,
        };
        let class = color.paint(&kind.class.to_string(), colors);
        // Writing to a string can't fail.
        let _ = writeln!(text, "{class}[{}]: {}", kind.id, kind.title());
        for difference in differences {
            let (before, after) = (fact(difference.before.as_ref()), fact(difference.after.as_ref()));
            let _ = writeln!(text, "  {}: {before} -> {after}", subject(difference));
        }
        let _ = writeln!(text, "  = {}\n", kind.why());
    }
    let (old, new) = (crate::escape::printable(&compared.old), crate::escape::printable(&compared.new));
    let counts = if compared.differences.is_empty() { "no difference".to_owned() } else { compared.counts() };
    let _ = writeln!(text, "{old} -> {new}: {counts}");
    text
}
