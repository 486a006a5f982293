//! What an editor shows of an EDS or DCF while it is written: an outline, what stands under the cursor, what may come next,
//! and where an object is described and named. Places are bytes of the text.

mod complete;
mod hover;
mod keys;
mod navigate;
mod outline;

pub use complete::{Completion, complete};
pub use hover::{Hover, hover};
pub use navigate::{definition, references};
pub use outline::{Symbol, outline};

#[cfg(test)]
mod tests;
