//! The binary formats: samples of other programs, damaged and hostile captures, and what canvass writes itself.

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
