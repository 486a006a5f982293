//! Places of a source file with possible changes.

use std::ops::Range;

/// A change of the program.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The text that replaces the original.
    pub text: String,
    /// The change in a few words.
    pub what: String,
}

/// The syntax of the choice between the original code and its mutants.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// An expression.
    Expression,
    /// A statement that is left out.
    Statement,
    /// A match arm without guard that is left out: the guard is inserted at the end of the range.
    Arm,
    /// The beginning of a function's body: the mutant returns at once.
    Body,
}

/// A place, with its mutants.
#[derive(Clone, Debug)]
pub struct Point {
    /// The range of bytes in the file.
    pub range: Range<usize>,
    pub form: Form,
    pub variants: Vec<Variant>,
    /// The name of the function around the place.
    pub function: String,
    /// The line, counted from 1.
    pub line: usize,
}

impl Variant {
    pub fn new(what: impl Into<String>, text: impl Into<String>) -> Self {
        Self { text: text.into(), what: what.into() }
    }
}
