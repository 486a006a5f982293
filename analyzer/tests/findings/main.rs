//! Captures with known faults: every rule finds its fault, with the right node and time, and nothing else is found.
//! Nothing is found in healthy traffic.

#[cfg(test)]
mod accused;
#[cfg(test)]
mod block;
#[cfg(test)]
mod boot;
#[cfg(test)]
mod bus;
#[cfg(test)]
mod capture;
#[cfg(test)]
mod drive;
#[cfg(test)]
mod emcy_lss;
#[cfg(test)]
mod encoder;
#[cfg(test)]
mod field;
#[cfg(test)]
mod frames;
#[cfg(test)]
mod guarding;
#[cfg(test)]
mod healthy;
#[cfg(test)]
mod incidents;
#[cfg(test)]
mod nmt;
#[cfg(test)]
mod nodes;
#[cfg(test)]
mod pdo;
#[cfg(test)]
mod sdo;
#[cfg(test)]
mod statistics;
#[cfg(test)]
mod steady;
#[cfg(test)]
mod stories;
#[cfg(test)]
mod together;
#[cfg(test)]
mod traffic;
#[cfg(test)]
mod unfinished;
#[cfg(test)]
mod unusual;
