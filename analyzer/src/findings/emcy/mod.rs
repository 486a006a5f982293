//! Rules about EMCY.

mod contradiction;
mod never_cleared;
mod raised;
mod storm;
