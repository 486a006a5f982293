//! A table by node-ID.

use crate::NodeId;
use std::ops::{Index, IndexMut, Range};

/// One `T` for each node-ID from 1 to 127.
#[derive(Clone, Debug)]
pub struct PerNode<T>(Box<[T; 128]>);

impl<T: Default> Default for PerNode<T> {
    fn default() -> Self {
        Self(Box::new(std::array::from_fn(|_| T::default())))
    }
}

impl<T> PerNode<T> {
    /// All entries with their node-IDs.
    pub fn iter(&self) -> impl Iterator<Item = (NodeId, &T)> {
        NodeId::all().zip(self.0.iter().skip(1))
    }

    /// All entries by value, with their node-IDs.
    pub(crate) fn into_all(self) -> impl Iterator<Item = (NodeId, T)> {
        NodeId::all().zip(self.0.into_iter().skip(1))
    }

    /// All entries with their node-IDs, mutable.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (NodeId, &mut T)> {
        NodeId::all().zip(self.0.iter_mut().skip(1))
    }

    /// All entries, mutable.
    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.0.iter_mut().skip(1)
    }

    /// The entries that an NMT command addresses: one, or all for node 0.
    pub fn named(&self, node: u8) -> impl Iterator<Item = (NodeId, &T)> {
        let (places, ids) = named(node);
        ids.iter().copied().zip(self.0.get(places).unwrap_or_default())
    }

    /// The entries that an NMT command addresses, mutable.
    pub(crate) fn named_mut(&mut self, node: u8) -> impl Iterator<Item = (NodeId, &mut T)> {
        let (places, ids) = named(node);
        ids.iter().copied().zip(self.0.get_mut(places).unwrap_or_default())
    }
}

/// The indexes that an NMT command addresses, and their node-IDs.
fn named(node: u8) -> (Range<usize>, &'static [NodeId]) {
    static IDS: [NodeId; 127] = NodeId::ALL;
    let places = match usize::from(node) {
        0 => 1..128,
        node @ 1..=127 => node..node + 1,
        _ => 1..1,
    };
    let ids = IDS.get(places.start - 1..places.end - 1).unwrap_or_default();
    (places, ids)
}

impl<T: Default> PerNode<T> {
    /// Resets all entries to their default.
    pub fn reset(&mut self) {
        self.0.iter_mut().for_each(|value| *value = T::default());
    }

    /// Resets the entries that an NMT command addresses to their default.
    pub(crate) fn reset_named(&mut self, node: u8) {
        match NodeId::new(node) {
            Some(node) => self[node] = T::default(),
            None if node == 0 => self.reset(),
            None => {}
        }
    }
}

impl<T> Index<NodeId> for PerNode<T> {
    type Output = T;

    #[inline]
    fn index(&self, node: NodeId) -> &T {
        // A node-ID has 7 bits, so the index is valid.
        &self.0[usize::from(node.raw() & 0x7F)]
    }
}

impl<T> IndexMut<NodeId> for PerNode<T> {
    #[inline]
    fn index_mut(&mut self, node: NodeId) -> &mut T {
        &mut self.0[usize::from(node.raw() & 0x7F)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_for_each_node() {
        let mut of: PerNode<u32> = PerNode::default();
        assert_eq!(of.iter().count(), 127);
        of.iter_mut().for_each(|(node, value)| *value = u32::from(node.raw()));
        assert_eq!((of[NodeId::MIN], of[NodeId::new(127).unwrap()]), (1, 127));
        of.reset_named(5);
        of.reset_named(200);
        assert_eq!((of[NodeId::new(5).unwrap()], of[NodeId::new(6).unwrap()]), (0, 6));
        assert_eq!(of.named(7).map(|(_, value)| *value).collect::<Vec<_>>(), [7]);
        assert_eq!((of.named(0).count(), of.named(128).count()), (127, 0));
        of.reset_named(0);
        assert!(of.iter().all(|(_, value)| *value == 0));
    }
}
