//! The fuzzer finds the claimed faults and nothing on healthy devices, and reports what it can't repeat as such.
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
