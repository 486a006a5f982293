//! The computed layouts of a node's PDOs.

use super::layout::Layout;
use crate::message::PdoNumber;
use std::collections::BTreeMap;

/// Number of PDOs of each direction in the array: the PDOs with default CAN-IDs (CiA 301).
const USUAL: usize = 4;

/// The layouts by PDO, cached because every PDO needs its layout several times.
#[derive(Clone, Default)]
pub(super) struct Layouts {
    transmit: [Known; USUAL],
    receive: [Known; USUAL],
    others: BTreeMap<PdoNumber, Known>,
}

/// `None` before the layout is computed; then the layout, if the mapping is known.
type Known = Option<Option<Layout>>;

impl Layouts {
    /// Whether the layout of the PDO is computed, even if it is unknown.
    pub(crate) fn is_worked_out(&self, pdo: PdoNumber) -> bool {
        self.known(pdo).is_some()
    }

    /// The layout, if it is computed and the mapping is known.
    pub fn get(&self, pdo: PdoNumber) -> Option<&Layout> {
        self.known(pdo)?.as_ref()
    }

    /// Stores a computed layout.
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

    /// Drops all layouts.
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
