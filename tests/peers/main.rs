//! The peers agree: files that canvass writes are read by other people's programs with equal frames and times, and
//! files that they write are read by canvass; clients of language servers have sessions with it.
//!
//! `cargo xtask ci` installs the peers (tshark, can-utils, xmllint, a Python environment with what `requirements.txt` names, Node
//! with what the extension of Visual Studio Code needs) and runs these tests, which are behind the feature `peers`.

#[cfg(test)]
mod agreement;
#[cfg(test)]
mod as_found;
#[cfg(test)]
mod can_utils;
#[cfg(test)]
mod cantools;
#[cfg(test)]
mod extension;
#[cfg(test)]
mod junit;
#[cfg(test)]
mod kept;
#[cfg(test)]
mod language_server;
#[cfg(test)]
mod python;
#[cfg(test)]
mod recording;
#[cfg(test)]
mod services;
#[cfg(test)]
mod tshark;
