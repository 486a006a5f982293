//! The program on real SocketCAN: interfaces, processes, and their faults.
//!
//! `cargo xtask vcan` runs these tests, on this machine's kernel if it has vcan, else on Debian's kernel in QEMU. Each
//! test has an interface of its own, so that tests can run at the same time. In QEMU the clock counts instructions:
//! work takes time there, waiting does not.

#[cfg(test)]
mod bundle;
#[cfg(test)]
mod can_utils;
#[cfg(test)]
mod controllers;
#[cfg(test)]
mod crash;
#[cfg(test)]
mod faults;
#[cfg(test)]
mod fuzzing;
#[cfg(test)]
mod interface;
#[cfg(test)]
mod killed;
#[cfg(test)]
mod load;
#[cfg(test)]
mod machine;
#[cfg(test)]
mod python;
#[cfg(test)]
mod running;
#[cfg(test)]
mod serial;
#[cfg(test)]
mod traits;
#[cfg(test)]
mod verdicts;
