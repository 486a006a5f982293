//! The device profiles whose properties the fuzzer checks, a folder each.

mod cia406;
