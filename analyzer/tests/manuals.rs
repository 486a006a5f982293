//! The byte sequences printed in the devices' manuals, each with the meaning that the manual gives it.
//!
//! One file of rows for each manual, in `manuals/`: `section; CAN-ID; bytes; service; key words; note`. All key
//! words, separated by `|`, must be in the text. `remote` stands for a remote frame. A row breaks no rule of the
//! protocol unless its note begins with `erratum`. A line that begins with `> ` is a frame that the manual does not
//! print but that the next row needs before it; `reset` begins a new network.

#[cfg(test)]
mod trace;

use trace::Trace;

/// A row of a manual.
struct ManualRow<'a> {
    line: usize,
    section: &'a str,
    frame: String,
    service: &'a str,
    words: Vec<&'a str>,
    note: &'a str,
}

impl<'a> ManualRow<'a> {
    /// Parses a row; `None` if there are fewer than five columns.
    fn new(line: usize, text: &'a str) -> Option<Self> {
        let columns: Vec<_> = text.split(';').map(str::trim).collect();
        let [section, id, bytes, service, words, note @ ..] = columns.as_slice() else { return None };
        Some(Self {
            line,
            section,
            frame: frame(id, bytes),
            service,
            words: words.split('|').map(str::trim).collect(),
            note: note.first().copied().unwrap_or_default(),
        })
    }

    /// The difference between the row and the decoded frame, if there is one.
    fn complaint(&self, said: &trace::Said) -> Option<String> {
        let missing = self.words.iter().find(|word| !said.text.contains(**word));
        let wrong = match (missing, said.decoded.violation) {
            _ if said.service() != self.service => format!("service {}, expected {}", said.service(), self.service),
            (Some(word), _) => format!("expected {word:?}"),
            (None, Some(violation)) if !self.note.starts_with("erratum") => format!("violation {violation}"),
            _ => return None,
        };
        Some(format!("line {}, section {}: {}: {wrong} in {:?}", self.line, self.section, self.frame, said.text))
    }
}

fn frame(id: &str, bytes: &str) -> String {
    if bytes == "remote" { format!("{id}#R") } else { format!("{id}#{bytes}") }
}

/// Decodes all rows in a network; returns their number.
fn play(rows: &str) -> usize {
    let mut trace = Trace::new();
    let mut count = 0;
    let mut complaints = Vec::new();
    for (line, text) in (1..).zip(rows.lines()) {
        if text.is_empty() || text.starts_with('#') {
        } else if text == "reset" {
            trace = Trace::new();
        } else if let Some((id, bytes)) = text.strip_prefix("> ").and_then(|context| context.split_once(' ')) {
            trace.say(&frame(id, bytes));
        } else if let Some(row) = ManualRow::new(line, text) {
            count += 1;
            complaints.extend(row.complaint(&trace.say(&row.frame)));
        } else {
            complaints.push(format!("line {line}: neither a row nor a frame: {text:?}"));
        }
    }
    assert!(complaints.is_empty(), "{} of {count} rows:\n{}", complaints.len(), complaints.join("\n"));
    count
}

macro_rules! manual {
    ($name:ident, $file:literal, $least:literal) => {
        #[test]
        fn $name() {
            let count = play(include_str!(concat!("manuals/", $file)));
            println!("{}: {count} rows", $file);
            assert!(count >= $least, "{count} rows, there were {}", $least);
        }
    };
}

manual!(kuebler_sendix, "kuebler-sendix.txt", 283);
manual!(kuebler_draw_wire, "kuebler-draw-wire.txt", 93);
manual!(lika_ax58, "lika-ax58.txt", 117);
manual!(tr_electronic, "tr-electronic.txt", 155);
