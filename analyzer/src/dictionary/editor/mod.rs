//! Editor functions for an EDS or DCF: outline, hover texts, completion, definitions and references of objects, and the
//! change of an index. Places are bytes of the text.

mod complete;
mod hover;
mod keys;
mod navigate;
mod outline;

pub use complete::{Completion, complete};
pub use hover::{Hover, hover};
pub use navigate::{definition, index_at, references, rename};
pub use outline::{Symbol, outline};

#[cfg(test)]
mod tests;
