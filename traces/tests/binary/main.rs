//! The binary formats: samples of other programs, damaged and hostile captures, and the files that canvass writes.

#[cfg(test)]
mod details;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod lost;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod shown;
#[cfg(test)]
mod written;
