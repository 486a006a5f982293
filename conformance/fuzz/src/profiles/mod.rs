//! The device profiles whose properties the fuzzer checks, each in a folder.

mod cia406;
