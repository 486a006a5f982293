//! What was read.

use canvass_traces::Quality;

/// One of the captures that were read, and how far it can be trusted.
#[derive(Clone, Copy, Debug)]
pub struct SourceQuality<'a> {
    /// Its name.
    pub name: &'a str,
    /// What was seen of it.
    pub quality: &'a Quality,
}
