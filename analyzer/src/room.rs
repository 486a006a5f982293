//! Shared limits of memory: they keep the program small on a capture in which every node of every bus shows as much
//! as possible.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The number of bytes left for all clones.
#[derive(Clone, Debug)]
pub struct Room(Arc<AtomicUsize>);

impl Room {
    /// A room of this size.
    pub fn new(bytes: usize) -> Self {
        Self(Arc::new(AtomicUsize::new(bytes)))
    }

    /// An independent room with the same number of bytes left.
    #[must_use]
    pub fn apart(&self) -> Self {
        Self::new(self.0.load(Ordering::Relaxed))
    }

    /// Takes this many bytes; `false` if fewer are left.
    #[must_use]
    pub fn take(&self, bytes: usize) -> bool {
        let taken = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(bytes));
        taken.is_ok()
    }

    /// Returns bytes to the room.
    pub fn give(&self, bytes: usize) {
        self.0.fetch_add(bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_is_gone_for_all() {
        let room = Room::new(10);
        let other = room.clone();
        assert!(room.take(4) && other.take(6) && !room.take(1));
        other.give(3);
        assert!(!room.take(4) && room.take(3));
    }
}
