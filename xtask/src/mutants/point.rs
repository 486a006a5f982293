//! Places of a source file at which it can be changed, and the changes.

use std::ops::Range;

/// A change of the program.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The text that replaces the original.
    pub text: String,
    /// The change in a few words.
    pub what: String,
}

/// How the choice between the program and its mutants is written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// An expression.
    Expression,
    /// A statement that is left out.
    Statement,
    /// A match arm without guard that is left out: the guard is put at the end of the range.
    Arm,
    /// The begin of a function's body: the mutant returns at once.
    Body,
}

/// A place, with its mutants.
#[derive(Clone, Debug)]
pub struct Point {
    /// Bytes of the file.
    pub range: Range<usize>,
    pub form: Form,
    pub variants: Vec<Variant>,
    /// The function that it is in.
    pub function: String,
    /// The line, counted from 1.
    pub line: usize,
}

impl Variant {
    pub fn new(what: impl Into<String>, text: impl Into<String>) -> Self {
        Self { text: text.into(), what: what.into() }
    }
}
