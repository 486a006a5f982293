//! The program, end to end.

#[cfg(test)]
mod conformance;
#[cfg(test)]
mod decode;
#[cfg(test)]
mod running;
