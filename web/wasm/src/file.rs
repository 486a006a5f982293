//! Files that the user has opened: read a piece at a time, never held in memory.

use crate::host;
use canvass_reports::provenance::FileUsed;
use sha2::{Digest, Sha256};
use std::io::{self, Read};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A file that the user has opened.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ChosenFile {
    /// The page's number of the file.
    pub number: u32,
    /// The name of the file.
    pub name: String,
    /// The length in bytes.
    pub length: u64,
}

/// Reads a file from beginning to end.
pub struct FileReader {
    file: ChosenFile,
    at: u64,
    seen: Seen,
}

/// The part of a file that was read so far.
#[derive(Clone, Default)]
pub struct Seen(Arc<SeenState>);

#[derive(Default)]
struct SeenState {
    bytes: AtomicU64,
    /// The hash of the bytes read, if requested.
    hash: Option<Mutex<Sha256>>,
}

impl Seen {
    /// The state for a file whose hash is requested.
    pub fn hashed() -> Self {
        Self(Arc::new(SeenState { hash: Some(Mutex::default()), ..SeenState::default() }))
    }

    /// Number of bytes read.
    pub fn bytes(&self) -> u64 {
        self.0.bytes.load(Ordering::Relaxed)
    }

    fn see(&self, bytes: &[u8]) {
        self.0.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        if let Some(hash) = &self.0.hash {
            hash.lock().unwrap_or_else(PoisonError::into_inner).update(bytes);
        }
    }

    fn digest(&self) -> Option<String> {
        let hash = self.0.hash.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Some(hexadecimal(&hash.finalize()))
    }
}

/// A hash in the notation of reports.
pub fn hexadecimal(hash: &[u8]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl FileReader {
    /// A reader at the beginning of the file.
    pub const fn new(file: ChosenFile, seen: Seen) -> Self {
        Self { file, at: 0, seen }
    }
}

impl Read for FileReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = usize::try_from(self.file.length.saturating_sub(self.at)).unwrap_or(usize::MAX);
        let wanted = left.min(buffer.len());
        let Some(buffer) = buffer.get_mut(..wanted).filter(|buffer| !buffer.is_empty()) else { return Ok(0) };
        let read = host::read(self.file.number, self.at, buffer)?;
        self.at += read as u64;
        self.seen.see(buffer.get(..read).unwrap_or_default());
        Ok(read)
    }
}

impl ChosenFile {
    /// The file with its hash, if that was requested. For the hash, the unread rest of the file is read.
    pub fn used(&self, role: &'static str, seen: &Seen) -> FileUsed {
        if seen.0.hash.is_none() {
            return FileUsed { role, path: self.name.clone(), content: None };
        }
        let mut rest = FileReader { file: self.clone(), at: seen.bytes(), seen: seen.clone() };
        let mut buffer = vec![0; 64 * 1024];
        let read = std::iter::repeat_with(|| rest.read(&mut buffer)).find(|read| !matches!(read, Ok(1..)));
        let whole = matches!(read, Some(Ok(0)));
        let content = seen.digest().filter(|_| whole).map(|digest| (seen.bytes(), digest));
        FileUsed { role, path: self.name.clone(), content }
    }
}
