//! `--allow`: permissions to change a device, by name or all at once.

use canvass_suite::touch::{Touch, UnknownTouch};
use std::collections::BTreeSet;
use std::str::FromStr;

/// A word that `--allow` takes.
#[derive(Clone, Copy, Debug)]
pub enum Allow {
    One(Touch),
    All,
}

impl FromStr for Allow {
    type Err = UnknownTouch;

    fn from_str(word: &str) -> Result<Self, UnknownTouch> {
        if word == "all" { Ok(Self::All) } else { word.parse().map(Self::One) }
    }
}

/// All touches that these words permit.
pub fn touches(words: &[Allow]) -> BTreeSet<Touch> {
    let of = |word: &Allow| match word {
        Allow::One(touch) => vec![*touch],
        Allow::All => Touch::ALL.to_vec(),
    };
    words.iter().flat_map(of).collect()
}
