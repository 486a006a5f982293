//! NMT: the reactions of a slave to each command.

mod addressing;
mod broadcast;
mod parameters;
mod transitions;
