//! Memory that many share: so that a capture in which every node of every bus shows as much as it can stays small.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bytes that are left for all who have a clone of it.
#[derive(Clone, Debug)]
pub struct Room(Arc<AtomicUsize>);

impl Room {
    /// Room for so many bytes.
    pub fn new(bytes: usize) -> Self {
        Self(Arc::new(AtomicUsize::new(bytes)))
    }

    /// Another room with as much left.
    #[must_use]
    pub fn apart(&self) -> Self {
        Self::new(self.0.load(Ordering::Relaxed))
    }

    /// Takes so many bytes, unless there are fewer.
    #[must_use]
    pub fn take(&self, bytes: usize) -> bool {
        let taken = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(bytes));
        taken.is_ok()
    }

    /// Gives back what was taken.
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
