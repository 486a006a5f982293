//! `--allow`: what may be done to a device, by name or all of it.

use canvass_suite::touch::{Touch, UnknownTouch};
use std::collections::BTreeSet;
use std::str::FromStr;

/// One word of it.
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

/// All that the words name.
pub fn touches(words: &[Allow]) -> BTreeSet<Touch> {
    let of = |word: &Allow| match word {
        Allow::One(touch) => vec![*touch],
        Allow::All => Touch::ALL.to_vec(),
    };
    words.iter().flat_map(of).collect()
}
