//! The last frame of each CAN-ID.

use super::seen::Seen;
use crate::network::Decoded;
use canvass_traces::Record;

/// The last frames of 128 CAN-IDs.
type Page = Box<[Option<Seen>; 128]>;

/// The last frame of each CAN-ID of 11 bits, in pages of 128.
pub struct Latest {
    pages: [Option<Page>; 16],
}

impl Default for Latest {
    fn default() -> Self {
        Self { pages: std::array::from_fn(|_| None) }
    }
}

impl Latest {
    /// The last frame with the CAN-ID `id`.
    #[inline]
    pub fn get(&self, id: u16) -> Option<&Seen> {
        self.pages.get(usize::from(id >> 7))?.as_ref()?[usize::from(id & 0x7F)].as_ref()
    }

    /// Keeps a frame as the latest with its CAN-ID.
    #[inline]
    pub fn keep(&mut self, id: u16, record: &Record, decoded: &Decoded) {
        let Some(page) = self.pages.get_mut(usize::from(id >> 7)) else { return };
        let page = page.get_or_insert_with(|| Box::new(std::array::from_fn(|_| None)));
        match &mut page[usize::from(id & 0x7F)] {
            Some(seen) => {
                seen.record.clone_from(record);
                seen.decoded = *decoded;
            }
            free => *free = Some(Seen { record: record.clone(), decoded: *decoded }),
        }
    }
}
