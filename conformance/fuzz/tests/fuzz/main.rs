//! The fuzzer finds the claimed faults, finds nothing on healthy devices, and reports whether it could repeat a
//! violation.
#![cfg(test)]

mod coverage;
mod faults;
mod healthy;
mod interrupted;
mod limits;
mod live;
mod perishable;
mod proofs;
mod reproduced;
mod right_answers;
mod stands;
