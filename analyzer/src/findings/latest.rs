//! The last frame of each CAN-ID.

use super::seen::Seen;
use crate::network::Decoded;
use canvass_traces::Record;

/// The last frames of 128 CAN-IDs.
type Page = Box<[Option<Seen>]>;

/// The last frame of each CAN-ID of 11 bits, in pages of 128.
pub struct Latest {
    pages: Box<[Option<Page>]>,
}

impl Default for Latest {
    fn default() -> Self {
        Self { pages: (0..16).map(|_| None).collect() }
    }
}

impl Latest {
    /// The last frame with that CAN-ID.
    pub fn get(&self, id: u16) -> Option<&Seen> {
        self.pages.get(usize::from(id >> 7))?.as_ref()?.get(usize::from(id & 0x7F))?.as_ref()
    }

    /// Keeps a frame as the latest with its CAN-ID.
    pub fn keep(&mut self, id: u16, record: &Record, decoded: &Decoded) {
        let Some(page) = self.pages.get_mut(usize::from(id >> 7)) else { return };
        let page = page.get_or_insert_with(|| (0..128).map(|_| None).collect());
        match &mut page[usize::from(id & 0x7F)] {
            Some(seen) => {
                seen.record.clone_from(record);
                seen.decoded = *decoded;
            }
            free => *free = Some(Seen { record: record.clone(), decoded: *decoded }),
        }
    }
}
