//! Channel names: the name of the bus on which a frame was seen.

use std::collections::HashMap;
use std::fmt;

/// A channel of a capture: its index in the [`Channels`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct ChannelId(pub u16);

/// The names of the channels seen so far, such as `can0` or `1`.
#[derive(Clone, Debug, Default)]
pub struct Channels {
    names: Vec<Box<str>>,
    /// The index of each name; used only for more than [`Channels::FEW`] names.
    places: HashMap<Box<str>, u16>,
    last: usize,
}

impl Channels {
    /// Maximum number of channels.
    pub const MAX: usize = 4096;
    /// Up to this number of channels a linear search is faster than the map.
    const FEW: usize = 16;
    /// The name of all further channels once [`Channels::MAX`] are known.
    pub const OVERFLOW: &'static str = "(more)";

    /// Makes an empty set of channels.
    pub fn new() -> Self {
        Self::default()
    }

    /// The channel of that name, added if it is new.
    ///
    /// A hostile file can name a new channel in every line; beyond [`Channels::MAX`] they all become one, named
    /// [`Channels::OVERFLOW`].
    pub fn intern(&mut self, name: &str) -> ChannelId {
        // Captures mostly repeat the channel of the frame before.
        if self.names.get(self.last).is_some_and(|known| **known == *name) {
            return ChannelId(self.last as u16);
        }
        self.last = self.find(name).unwrap_or_else(|| self.add(name));
        ChannelId(self.last as u16)
    }

    fn find(&self, name: &str) -> Option<usize> {
        if self.names.len() <= Self::FEW {
            return self.names.iter().position(|known| **known == *name);
        }
        self.places.get(name).map(|&place| usize::from(place))
    }

    fn add(&mut self, name: &str) -> usize {
        match self.names.len() {
            Self::MAX.. => return Self::MAX - 1,
            len if len == Self::MAX - 1 => self.names.push(Self::OVERFLOW.into()),
            _ => self.names.push(name.into()),
        }
        let place = self.names.len() - 1;
        if let Some(name) = self.names.get(place) {
            self.places.insert(name.clone(), place as u16);
        }
        place
    }

    /// The name of a channel; `?` for an id that is not of this capture.
    pub fn name(&self, id: ChannelId) -> &str {
        self.names.get(usize::from(id.0)).map_or("?", |name| name)
    }

    /// All names, in the order of their [`ChannelId`]s.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.names.iter().map(|name| &**name)
    }

    /// The number of channels seen.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether no channel was seen.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }
}

impl fmt::Display for ChannelId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_their_ids() {
        let mut channels = Channels::new();
        let (a, b) = (channels.intern("can0"), channels.intern("can1"));
        assert_eq!(channels.intern("can0"), a);
        assert_eq!((channels.name(a), channels.name(b)), ("can0", "can1"));
        assert_eq!(channels.name(ChannelId(9)), "?");
    }

    #[test]
    fn many_names_are_found_as_few_are() {
        let mut channels = Channels::new();
        for round in 0..2 {
            for n in 0..1000 {
                assert_eq!(channels.intern(&format!("can{n}")), ChannelId(n), "round {round}");
            }
        }
        assert_eq!(channels.len(), 1000);
    }

    #[test]
    fn a_new_name_in_every_line_does_not_fill_the_memory() {
        let mut channels = Channels::new();
        for n in 0..2 * Channels::MAX {
            channels.intern(&format!("c{n}"));
        }
        let last = channels.intern("yet another");
        assert_eq!(channels.len(), Channels::MAX);
        assert_eq!(channels.name(last), Channels::OVERFLOW);
    }
}
