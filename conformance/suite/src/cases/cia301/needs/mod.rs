//! The needs of the cases of CiA 301.

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
