//! The provenance for people, and as properties of JUnit files.

use super::{ChosenBy, Provenance};
use crate::escape::{self, printable};
use maud::{Markup, html as markup};
use std::io::{self, Write};

/// The columns that a list of options takes.
const WIDTH: usize = 110;

/// For a terminal: a line for each fact, and the options in as few lines as they need.
pub fn text(provenance: &Provenance, out: &mut dyn Write) -> io::Result<()> {
    text_lines(provenance, provenance.settings()).iter().try_for_each(|line| writeln!(out, "{line}"))
}

/// The same where room is scarce: of the options those that somebody chose.
pub fn short_text(provenance: &Provenance) -> Vec<String> {
    let usual = provenance.options.iter().filter(|choice| choice.by == ChosenBy::Default).count();
    let mut settings = provenance.settings();
    settings.truncate(settings.len() - usual);
    text_lines(provenance, settings)
}

fn text_lines(provenance: &Provenance, settings: Vec<(String, String)>) -> Vec<String> {
    let shown = |(name, value): (String, String)| format!("{:12} {}", printable(&name), printable(&value));
    let mut all: Vec<String> = provenance.facts().into_iter().map(shown).collect();
    let settings: Vec<String> =
        settings.into_iter().map(|(name, value)| printable(&format!("{name}: {value}")).into_owned()).collect();
    let named = |(at, line): (usize, String)| format!("{:12} {line}", if at == 0 { "options" } else { "" });
    all.extend(lines(&settings).into_iter().enumerate().map(named));
    all
}

/// As many parts in a line as fit.
fn lines(parts: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in parts {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 2 + part.chars().count() <= WIDTH => {
                line.push_str("; ");
                line.push_str(part);
            }
            _ => lines.push(part.clone()),
        }
    }
    lines
}

/// A section of a Markdown document.
pub fn markdown(provenance: &Provenance, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "\n## About this report\n\n| | |\n|---|---|")?;
    let facts = provenance.facts().into_iter();
    let settings = provenance.settings().into_iter().map(|(name, value)| (format!("option {name}"), value));
    for (name, value) in facts.chain(settings) {
        writeln!(out, "| {} | {} |", escape::markdown(&name), escape::markdown(&value))?;
    }
    Ok(())
}

/// A section of a page, with the id `about`.
pub fn html(provenance: &Provenance) -> Markup {
    let row =
        |name: &str, value: &str| markup! { tr { th scope="row" { (printable(name)) } td { (printable(value)) } } };
    let settings = provenance.settings();
    markup! {
        section aria-labelledby="about" {
            h2 #about { "About this report" }
            div.card.scroll { table.about { tbody {
                @for (name, value) in provenance.facts() { (row(&name, &value)) }
            } } }
            @if !settings.is_empty() {
                details { summary { "Options" }
                    div.card.scroll { table.about { tbody {
                        @for (name, value) in settings { (row(&name, &value)) }
                    } } }
                }
            }
        }
    }
}

/// For JUnit files: names that programs can look for, and values.
pub fn junit_properties(provenance: &Provenance) -> Vec<(String, String)> {
    let named = |(name, value): (String, String)| (format!("canvass.{}", name.replace(' ', ".")), value);
    let facts = provenance.facts().into_iter().map(named);
    let settings = provenance.settings().into_iter().map(|(name, value)| (format!("canvass.option.{name}"), value));
    let printed = |(name, value): (String, String)| (printable(&name).into_owned(), printable(&value).into_owned());
    facts.chain(settings).map(printed).collect()
}
