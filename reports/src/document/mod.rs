//! What a report says, apart from its form: an outcome, facts, and sections of tables, findings with their evidence, and
//! pictures.
//!
//! A report is a function from its result to a [`Document`]: see [`Report`]. Each form is one renderer of all documents.
//! Texts are as they came: each renderer makes them harmless.

pub mod html;
pub mod junit;
mod markdown;
mod text;

pub use text::height;

use crate::color::Color;
use junit::Suite;
use maud::Markup;
use serde_json::Value;
use std::io::{self, Write};

/// A result that is reported.
pub trait Report {
    /// What it says, as far as there is room.
    fn document(&self, depth: Depth) -> Document;

    /// Writes it for programs: the contract of [`crate::results`].
    ///
    /// # Errors
    /// The errors of `out`.
    fn json(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Writes it.
    ///
    /// # Errors
    /// The errors of `out`.
    fn write(&self, form: Form, out: &mut dyn Write) -> io::Result<()> {
        match form {
            Form::Text(style) => text::render(&self.document(Depth::Screen), style, out),
            Form::Markdown => markdown::render(&self.document(Depth::Paper), out),
            Form::Html => html::render(&self.document(Depth::Page), out),
            Form::Junit => {
                let Document { command, suites, .. } = self.document(Depth::Paper);
                junit::write(command, &suites, out)
            }
            Form::Json => self.json(out),
        }
    }
}

/// The form of a report.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// For a terminal.
    Text(Style),
    /// For merge requests and wikis.
    Markdown,
    /// One page that needs nothing else.
    Html,
    /// For CI servers.
    Junit,
    /// For programs.
    Json,
}

/// How a terminal is written to.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Style {
    /// With colours.
    pub color: bool,
    /// The width in columns, where it is known.
    pub width: Option<u16>,
}

/// How detailed a report is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Depth {
    /// What matters most.
    Screen,
    /// What a ticket needs.
    Paper,
    /// All of it.
    Page,
}

/// A report without its form.
#[derive(Debug, Default)]
pub struct Document {
    /// The command that it is of: `test`.
    pub command: &'static str,
    /// What kind of report it is: `CANopen conformance`.
    pub kind: &'static str,
    pub title: String,
    /// One line about the result, without a full stop.
    pub outcome: String,
    pub tone: Tone,
    pub facts: Vec<Fact>,
    /// Follows the facts.
    pub summary: Vec<Block>,
    pub sections: Vec<Section>,
    /// Where the result comes from.
    pub about: Option<Section>,
    /// The cases of the JUnit file.
    pub suites: Vec<Suite>,
    pub page: PageParts,
}

/// What only a page has.
#[derive(Debug, Default)]
pub struct PageParts {
    pub footer: &'static str,
    pub styles: &'static [&'static str],
    pub scripts: &'static [&'static str],
    /// For the scripts.
    pub data: Option<Value>,
}

/// A part of a document with a heading.
#[derive(Debug, Default)]
pub struct Section {
    /// Its name in links.
    pub id: &'static str,
    pub title: String,
    pub blocks: Vec<Block>,
}

/// A name and what it stands for.
pub type Fact = (String, String);

/// Whether something is good, for its colour.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Tone {
    #[default]
    Plain,
    Good,
    Doubt,
    Bad,
    /// Worth knowing.
    Info,
    /// Not known.
    Odd,
    Faint,
}

impl Tone {
    /// The class in pages.
    const fn class(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Good => "good",
            Self::Doubt => "doubt",
            Self::Bad => "bad",
            Self::Info => "info",
            Self::Odd => "odd",
            Self::Faint => "faint",
        }
    }

    const fn color(self) -> Option<Color> {
        match self {
            Self::Plain => None,
            Self::Good => Some(Color::Green),
            Self::Doubt => Some(Color::Yellow),
            Self::Bad => Some(Color::Red),
            Self::Info => Some(Color::Cyan),
            Self::Odd => Some(Color::Magenta),
            Self::Faint => Some(Color::Grey),
        }
    }
}

/// A piece of a section.
#[derive(Debug)]
pub enum Block {
    Text(String),
    /// What a reader must not overlook.
    Note(String),
    Items(Vec<String>),
    /// Short names, one after the other.
    Words(Vec<String>),
    Facts(Vec<Fact>),
    Table(Table),
    /// Lines that stay as they are, under a title.
    Code(Code),
    /// What a page shows only when it is asked to.
    Fold {
        title: String,
        is_open: bool,
        blocks: Vec<Self>,
    },
    Finding(Finding),
    /// A picture or what the scripts of a page need; no other form has it.
    Markup(Markup),
}

/// Lines that stay as they are.
#[derive(Debug)]
pub struct Code {
    /// What they are; may be empty.
    pub title: &'static str,
    /// As Markdown calls it: `rust`.
    pub language: &'static str,
    pub text: String,
}

/// Something that was found, with what proves it.
#[derive(Debug, Default)]
pub struct Finding {
    pub tone: Tone,
    /// How bad it is, in a word, with its sign if it has one.
    pub badge: String,
    pub title: String,
    /// The rule, property or clause; may be empty.
    pub id: String,
    /// Its name in links; may be empty.
    pub anchor: String,
    /// The word for the scripts that filter: `fail`.
    pub data_kind: &'static str,
    /// Whether a page shows all of it at once.
    pub is_open: bool,
    pub body: Vec<Block>,
}

/// Rows of as many cells as there are columns.
#[derive(Debug, Default)]
pub struct Table {
    /// The class in pages.
    pub class: &'static str,
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
    /// Whether a terminal draws its frame.
    pub is_framed: bool,
}

#[derive(Clone, Debug, Default)]
pub struct Column {
    pub name: String,
    pub align: Align,
}

/// Where the text of a cell stands.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum Align {
    #[default]
    Left,
    Center,
    Right,
}

#[derive(Debug, Default)]
pub struct Row {
    pub cells: Vec<Cell>,
    pub tone: Tone,
    /// Its name in links; may be empty.
    pub anchor: String,
    /// The lines of a terminal in place of its cells; may be empty.
    pub lines: Vec<String>,
    /// Names and values for the scripts of a page.
    pub data: Vec<(&'static str, String)>,
}

#[derive(Clone, Debug, Default)]
pub struct Cell {
    pub text: String,
    pub tone: Tone,
    /// The class in pages; may be empty.
    pub class: String,
    /// What a sign means, in words; may be empty.
    pub title: String,
    /// Where it leads to on a page; may be empty.
    pub link: String,
}

impl Column {
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), align: Align::Left }
    }

    /// Of numbers.
    pub fn right(name: impl Into<String>) -> Self {
        Self { align: Align::Right, ..Self::new(name) }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), ..Self::default() }
    }
}

impl Row {
    /// Of plain texts.
    pub fn of<T: Into<Cell>>(cells: impl IntoIterator<Item = T>) -> Self {
        Self { cells: cells.into_iter().map(Into::into).collect(), ..Self::default() }
    }
}

impl Table {
    pub fn new(columns: impl IntoIterator<Item = Column>, rows: impl IntoIterator<Item = Row>) -> Self {
        Self { columns: columns.into_iter().collect(), rows: rows.into_iter().collect(), ..Self::default() }
    }

    /// With columns that stand left.
    pub fn of<const N: usize>(columns: [&str; N], rows: impl IntoIterator<Item = Row>) -> Self {
        Self::new(columns.map(Column::new), rows)
    }
}

impl Section {
    /// The lines that it takes on a terminal.
    pub fn height(&self) -> usize {
        text::height(&self.blocks)
    }
}

impl Block {
    /// What a page shows only when it is asked to.
    pub fn fold(title: impl Into<String>, blocks: Vec<Self>) -> Self {
        Self::Fold { title: title.into(), is_open: false, blocks }
    }
}

/// A fact with a value of any type.
pub fn fact<T: ToString + ?Sized>(name: &str, value: &T) -> Fact {
    (name.to_owned(), value.to_string())
}

#[cfg(test)]
mod tests;
