//! The content of a report without its form: an outcome, facts, and sections of tables, findings with their evidence,
//! and pictures.
//!
//! A report is a function from its result to a [`Document`]: see [`Report`]. Each form has one renderer for all
//! documents. Texts are unescaped here; each renderer makes them harmless.

pub mod html;
pub mod junit;
mod markdown;
#[cfg(not(target_family = "wasm"))]
mod pdf;
pub(crate) mod sarif;
mod text;

pub use text::height;

use crate::color::Color;
use junit::Suite;
use maud::Markup;
use serde_json::Value;
use std::io::{self, Write};

/// A result to report.
pub trait Report {
    /// The content of the report, in the detail that `depth` allows.
    fn document(&self, depth: Depth) -> Document;

    /// Writes the result as JSON, by the contract of [`crate::results`].
    ///
    /// # Errors
    /// The errors of `out`.
    fn json(&self, out: &mut dyn Write) -> io::Result<()>;

    /// Writes the report in a form.
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
            Form::Sarif => sarif::render(&self.document(Depth::Paper), out),
            #[cfg(not(target_family = "wasm"))]
            Form::Pdf { appendix } => pdf::render(&self.document(Depth::Print), appendix, out),
            Form::Json => self.json(out),
        }
    }
}

/// The form of a report.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// Text for a terminal.
    Text(Style),
    /// Markdown for merge requests and wikis.
    Markdown,
    /// A self-contained HTML page.
    Html,
    /// JUnit XML for CI servers.
    Junit,
    /// SARIF for code hosts.
    Sarif,
    /// PDF for paper, with or without everything after the first pages.
    #[cfg(not(target_family = "wasm"))]
    Pdf {
        /// Whether the cases or findings follow in full.
        appendix: bool,
    },
    /// JSON for programs.
    Json,
}

/// The capabilities of the terminal.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Style {
    /// Whether colours are used.
    pub color: bool,
    /// The width in columns, if it is known.
    pub width: Option<u16>,
}

/// How detailed a report is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Depth {
    /// The most important facts, for a screen.
    Screen,
    /// The facts that a ticket needs.
    Paper,
    /// A first page to sign, and the facts that a ticket needs.
    Print,
    /// All facts, for a page.
    Page,
}

/// The content of a report without its form.
#[derive(Debug, Default)]
pub struct Document {
    /// The command that made the report: `test`.
    pub command: &'static str,
    /// The kind of the report: `CANopen conformance`.
    pub kind: &'static str,
    pub title: String,
    /// The result in one line, without a full stop.
    pub outcome: String,
    pub tone: Tone,
    pub facts: Vec<Fact>,
    /// The head of every printed page.
    pub head: String,
    /// The date of the result in the notation of RFC 3339; empty if it is unknown.
    pub date: String,
    /// The sections of a first page, which only HTML and PDF have.
    pub front: Vec<Section>,
    /// The blocks after the facts.
    pub summary: Vec<Block>,
    pub sections: Vec<Section>,
    /// The section about the provenance of the result.
    pub about: Option<Section>,
    /// The suites of the JUnit file.
    pub suites: Vec<Suite>,
    pub page: PageParts,
}

/// The parts that only an HTML page has.
#[derive(Debug, Default)]
pub struct PageParts {
    pub footer: &'static str,
    pub styles: &'static [&'static str],
    pub scripts: &'static [&'static str],
    /// The data for the scripts.
    pub data: Option<Value>,
}

/// A part of a document with a heading.
#[derive(Debug, Default)]
pub struct Section {
    /// The id of the section in links.
    pub id: &'static str,
    pub title: String,
    pub blocks: Vec<Block>,
}

/// A name and its value.
pub type Fact = (String, String);

/// The rating of a text, which determines its colour.
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
    /// The CSS class on pages.
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

/// A part of a section.
#[derive(Debug)]
pub enum Block {
    Text(String),
    /// A text that a reader must not overlook.
    Note(String),
    Items(Vec<String>),
    /// Short names, one after the other.
    Words(Vec<String>),
    Facts(Vec<Fact>),
    Table(Table),
    /// Preformatted lines under a title.
    Code(Code),
    /// Blocks that a page shows only on request.
    Fold {
        title: String,
        is_open: bool,
        blocks: Vec<Self>,
    },
    Finding(Finding),
    /// A picture, or an element for the scripts of a page. Only HTML has it.
    Markup(Markup),
}

/// Preformatted lines.
#[derive(Debug)]
pub struct Code {
    /// The title of the lines. May be empty.
    pub title: &'static str,
    /// The language in Markdown's notation: `rust`.
    pub language: &'static str,
    pub text: String,
}

/// A finding with its evidence.
#[derive(Debug, Default)]
pub struct Finding {
    pub tone: Tone,
    /// The severity in one word, with its sign if it has one.
    pub badge: String,
    pub title: String,
    /// The id of the rule, property or clause. May be empty.
    pub id: String,
    /// The anchor of the finding. May be empty.
    pub anchor: String,
    /// The word by which scripts filter: `fail`.
    pub data_kind: &'static str,
    /// Whether a page shows the whole finding at once.
    pub is_open: bool,
    pub body: Vec<Block>,
}

/// A table. Each row has as many cells as there are columns.
#[derive(Debug, Default)]
pub struct Table {
    /// The CSS class on pages.
    pub class: &'static str,
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
    /// Whether a terminal draws a frame.
    pub is_framed: bool,
}

#[derive(Clone, Debug, Default)]
pub struct Column {
    pub name: String,
    pub align: Align,
}

/// The alignment of the text in a cell.
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
    /// The anchor of the row. May be empty.
    pub anchor: String,
    /// The lines that a terminal shows instead of the cells. May be empty.
    pub lines: Vec<String>,
    /// Names and values for the scripts of a page.
    pub data: Vec<(&'static str, String)>,
}

#[derive(Clone, Debug, Default)]
pub struct Cell {
    pub text: String,
    pub tone: Tone,
    /// The CSS class on pages. May be empty.
    pub class: String,
    /// The meaning of a sign in words. May be empty.
    pub title: String,
    /// The target of the link on a page. May be empty.
    pub link: String,
}

impl Column {
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), align: Align::Left }
    }

    /// A column of numbers, aligned right.
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
    /// A row of plain texts.
    pub fn of<T: Into<Cell>>(cells: impl IntoIterator<Item = T>) -> Self {
        Self { cells: cells.into_iter().map(Into::into).collect(), ..Self::default() }
    }
}

impl Table {
    pub fn new(columns: impl IntoIterator<Item = Column>, rows: impl IntoIterator<Item = Row>) -> Self {
        Self { columns: columns.into_iter().collect(), rows: rows.into_iter().collect(), ..Self::default() }
    }

    /// A table whose columns are aligned left.
    pub fn of<const N: usize>(columns: [&str; N], rows: impl IntoIterator<Item = Row>) -> Self {
        Self::new(columns.map(Column::new), rows)
    }
}

impl Section {
    /// Number of lines of the section on a terminal.
    pub fn height(&self) -> usize {
        text::height(&self.blocks)
    }
}

impl Block {
    /// Blocks that a page shows only on request.
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
