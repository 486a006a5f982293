//! What the cases of CiA 301 need.

mod block;
mod objects;
mod pdo;
mod state;
#[cfg(test)]
mod tests;

pub use block::*;
pub use objects::*;
pub use pdo::*;
pub use state::*;
