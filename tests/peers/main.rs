//! The peers agree: files that canvass writes are read by other people's programs with equal frames and times, and
//! files that they write are read by canvass.
//!
//! `cargo xtask ci` installs the peers (tshark, can-utils, xmllint, and a Python environment with what `requirements.txt`
//! names) and runs these tests, which are behind the feature `peers`.

#[cfg(test)]
mod agreement;
#[cfg(test)]
mod can_utils;
#[cfg(test)]
mod cantools;
#[cfg(test)]
mod junit;
#[cfg(test)]
mod kept;
#[cfg(test)]
mod python;
#[cfg(test)]
mod recording;
#[cfg(test)]
mod services;
#[cfg(test)]
mod tshark;
