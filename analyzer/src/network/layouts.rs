//! The layouts of a node's PDOs, as they have been worked out.

use super::layout::Layout;
use crate::message::PdoNumber;
use std::collections::BTreeMap;

/// How many of each direction are found at once: those that have CAN-IDs of their own by default (CiA 301).
const USUAL: usize = 4;

/// The layouts by PDO: every PDO asks for its own several times.
#[derive(Clone, Default)]
pub(super) struct Layouts {
    transmit: [Known; USUAL],
    receive: [Known; USUAL],
    others: BTreeMap<PdoNumber, Known>,
}

/// `None` as long as nobody has asked; then the layout, if the mapping is known.
type Known = Option<Option<Layout>>;

impl Layouts {
    /// Whether that PDO's layout has been worked out, even if to nothing.
    pub fn is_worked_out(&self, pdo: PdoNumber) -> bool {
        self.known(pdo).is_some()
    }

    /// The layout, where it has been worked out and the mapping was known.
    pub fn get(&self, pdo: PdoNumber) -> Option<&Layout> {
        self.known(pdo)?.as_ref()
    }

    /// Keeps what has been worked out.
    pub fn insert(&mut self, pdo: PdoNumber, layout: Option<Layout>) {
        let place = match pdo {
            PdoNumber::Transmit(number) => self.transmit.get_mut(usize::from(number).wrapping_sub(1)),
            PdoNumber::Receive(number) => self.receive.get_mut(usize::from(number).wrapping_sub(1)),
        };
        match place {
            Some(place) => *place = Some(layout),
            None => *self.others.entry(pdo).or_default() = Some(layout),
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    #[inline]
    fn known(&self, pdo: PdoNumber) -> Option<&Option<Layout>> {
        let place = match pdo {
            PdoNumber::Transmit(number) => self.transmit.get(usize::from(number).wrapping_sub(1)),
            PdoNumber::Receive(number) => self.receive.get(usize::from(number).wrapping_sub(1)),
        };
        place.or_else(|| self.others.get(&pdo))?.as_ref()
    }
}
