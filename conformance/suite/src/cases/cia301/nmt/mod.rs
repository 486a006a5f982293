//! NMT: what a slave does on each command.

mod addressing;
mod broadcast;
mod parameters;
mod transitions;
