//! The captures that were read.

use canvass_traces::Quality;

/// A capture, and its quality.
#[derive(Clone, Copy, Debug)]
pub struct SourceQuality<'a> {
    /// The name of the capture.
    pub name: &'a str,
    /// Its quality.
    pub quality: &'a Quality,
}
