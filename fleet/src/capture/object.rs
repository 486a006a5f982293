//! Reads an object of a store in pieces: while one piece is decoded, the next one is downloaded.

use object_store::path::Path as ObjectPath;
use object_store::{ObjectStore, ObjectStoreExt};
use std::io::{self, Read};
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::task::JoinHandle;

/// A reader of an object.
pub struct ObjectReader {
    store: Arc<dyn ObjectStore>,
    path: ObjectPath,
    size: u64,
    /// Offset of the next piece to request.
    next: u64,
    coming: Option<JoinHandle<object_store::Result<bytes::Bytes>>>,
    piece: bytes::Bytes,
    handle: Handle,
}

impl ObjectReader {
    /// Size of a piece in bytes: large enough that the duration of a request does not matter.
    const PIECE: u64 = 8 << 20;

    /// A reader for an object of this length; requests run on `handle`.
    pub fn new(store: Arc<dyn ObjectStore>, path: ObjectPath, size: u64, handle: Handle) -> Self {
        Self { store, path, size, next: 0, coming: None, piece: bytes::Bytes::new(), handle }
    }

    fn ask(&mut self) {
        if self.next < self.size {
            let range = self.next..(self.next + Self::PIECE).min(self.size);
            self.next = range.end;
            let (store, path) = (Arc::clone(&self.store), self.path.clone());
            self.coming = Some(self.handle.spawn(async move { store.get_range(&path, range).await }));
        }
    }
}

impl Read for ObjectReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.piece.is_empty() {
            if self.coming.is_none() {
                self.ask();
            }
            let Some(coming) = self.coming.take() else { return Ok(0) };
            self.piece = self.handle.block_on(coming).map_err(io::Error::other)?.map_err(io::Error::other)?;
            self.ask();
        }
        let n = self.piece.len().min(buffer.len());
        let taken = self.piece.split_to(n);
        buffer[..n].copy_from_slice(&taken);
        Ok(n)
    }
}

impl Drop for ObjectReader {
    fn drop(&mut self) {
        if let Some(coming) = &self.coming {
            coming.abort();
        }
    }
}
