//! A small language for selecting frames: `service=sdo and node in 1..8 and index=0x6003 or abort`.
//!
//! ```text
//! expression = conjunction { "or" conjunction }
//! conjunction = factor { "and" factor }
//! factor     = "not" factor | "(" expression ")" | test
//! test       = number-field ("=" | "!=" | "<" | "<=" | ">" | ">=") number
//!            | number-field ["not"] "in" range { "," range }
//!            | ("service" | "channel") ("=" | "!=") name
//!            | ("service" | "channel") ["not"] "in" name { "," name }
//!            | flag
//! range      = number [ ".." number ]         both ends are in it
//! number     = 255 | 0xFF | FFh
//! number-field = node | id | index | sub | len | abort | emcy
//! flag       = abort | emcy | violation | remote | extended | fd | error | tx | rx
//! ```
//!
//! A test of a field that the frame does not have is false, also with `!=` or `not in`. A `not` in front of such a test
//! makes it true.

mod completion;
mod expression;
mod parser;

pub use completion::Completion;
pub use expression::{Filter, Subject};
pub use parser::FilterError;

#[cfg(test)]
mod tests;
