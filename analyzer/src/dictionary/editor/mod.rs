//! Editor functions for an EDS or DCF: outline, hover texts, completion, definitions, references
//! and new indexes of objects.
//! Places are bytes of the text.

mod complete;
mod hover;
mod keys;
mod navigate;
mod outline;

pub use complete::{Completion, complete};
pub use hover::{Hover, hover};
pub use navigate::{definition, references, rename, renamed_at};
pub use outline::{Symbol, outline};

#[cfg(test)]
mod tests;
