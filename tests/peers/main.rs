//! The peers agree: files that canvass writes are read by other people's programs with equal frames and times, and
//! files that they write are read by canvass.
//!
//! `cargo xtask ci` installs the peers (tshark, can-utils, and a Python environment with what `requirements.txt`
//! names) and runs these tests, which are behind the feature `peers`.

mod agreement;
mod can_utils;
mod kept;
mod python;
mod recording;
mod tshark;
