//! The captures that were read.

use canvass_traces::Quality;

/// A capture, and its quality.
#[derive(Clone, Copy, Debug)]
pub struct SourceQuality<'a> {
    /// The name of the capture.
    pub name: &'a str,
    /// The quality of the capture.
    pub quality: &'a Quality,
}
