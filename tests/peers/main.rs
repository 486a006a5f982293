//! The peers agree: other people's programs read the files of canvass with equal frames and times, and canvass reads
//! their files; clients of language servers have sessions with canvass.
//!
//! `cargo xtask ci` installs the peers (tshark, can-utils, xmllint, a Python environment with the packages of
//! `requirements.txt`, Node with the packages of the extension for Visual Studio Code) and runs these tests, which are
//! behind the feature `peers`.

#[cfg(test)]
mod agreement;
#[cfg(test)]
mod as_found;
#[cfg(test)]
mod can_utils;
#[cfg(test)]
mod cantools;
#[cfg(test)]
mod configurations;
#[cfg(test)]
mod extension;
#[cfg(test)]
mod fuzz_pytest;
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
