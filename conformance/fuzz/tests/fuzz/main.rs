//! The fuzzer: it finds what it says it finds, nothing on healthy devices, and says honestly what it can't repeat.
#![cfg(test)]

mod coverage;
mod faults;
mod healthy;
mod interrupted;
mod limits;
mod live;
mod perishable;
mod reproduced;
mod right_answers;
mod stands;
