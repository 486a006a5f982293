//! Opening files, on disk or in an object store, for blocking readers.

use super::object::ObjectReader;
use super::{CaptureFile, is_url};
use datafusion::execution::runtime_env::RuntimeEnv;
use object_store::ObjectStore;
use object_store::path::Path as ObjectPath;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::sync::{Arc, Mutex, PoisonError};
use tokio::runtime::Handle;
use url::Url;

/// Opens files of this computer and of object stores. Opening blocks: call it only from a blocking task.
#[derive(Clone)]
pub struct Access {
    runtime: Arc<RuntimeEnv>,
    handle: Handle,
}

/// Why a file can't be read. The file or the store is the cause, not the content of the file.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// The file can't be opened or read.
    #[error("can't read {name}: {reason}")]
    Read {
        /// The file.
        name: String,
        /// The reason.
        reason: String,
    },
    /// The name is no URL of a known kind.
    #[error("{name} is no URL of an object store that is known: expected s3://BUCKET/KEY, or a path ({reason})")]
    Url {
        /// The name as the user gave it.
        name: String,
        /// The reason.
        reason: String,
    },
}

/// The reader's notes on a file: an error of reading, and the hash of the bytes read.
#[derive(Clone, Default)]
pub struct Notes(Arc<Mutex<Noted>>);

#[derive(Default)]
struct Noted {
    failure: Option<String>,
    digest: Option<Sha256>,
    /// Number of hashed bytes.
    hashed: u64,
}

impl Notes {
    fn with<T>(&self, use_it: impl FnOnce(&mut Noted) -> T) -> T {
        use_it(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The error of reading, if there was one.
    pub fn failure(&self) -> Option<String> {
        self.with(|noted| noted.failure.clone())
    }

    /// The number of bytes read and hashed, and their SHA-256 in hexadecimal; `None` if no hash was requested.
    pub fn sha256(&self) -> Option<(u64, String)> {
        let (hashed, digest) = self.with(|noted| (noted.hashed, noted.digest.clone()));
        digest.map(|digest| (hashed, hex(&digest.finalize())))
    }
}

/// Lower-case hexadecimal digits, as `sha256sum` prints them.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A reader that notes the hash of the bytes and an error of reading.
struct Watched {
    inner: Box<dyn Read + Send>,
    notes: Notes,
    hashes: bool,
}

impl Read for Watched {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer);
        match &read {
            Ok(n) if self.hashes => self.notes.with(|noted| {
                if let (Some(digest), Some(bytes)) = (&mut noted.digest, buffer.get(..*n)) {
                    digest.update(bytes);
                    noted.hashed += bytes.len() as u64;
                }
            }),
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => self.notes.with(|noted| noted.failure = Some(error.to_string())),
        }
        read
    }
}

impl Access {
    /// Access to the object stores of `runtime`; asynchronous requests run on `handle`.
    pub const fn new(runtime: Arc<RuntimeEnv>, handle: Handle) -> Self {
        Self { runtime, handle }
    }

    /// Opens a file; with `hashes`, the SHA-256 of the file is computed while it is read.
    ///
    /// # Errors
    /// [`AccessError`] if the file does not exist or can't be read.
    pub fn open(&self, file: &CaptureFile, hashes: bool) -> Result<(Box<dyn Read + Send>, Notes), AccessError> {
        let inner: Box<dyn Read + Send> = if is_url(file.place()) {
            let (store, path) = locate(&self.runtime, file.place())?;
            Box::new(ObjectReader::new(store, path, file.size, self.handle.clone()))
        } else {
            let unreadable =
                |error: io::Error| AccessError::Read { name: file.name.clone(), reason: error.to_string() };
            Box::new(File::open(file.place()).map_err(unreadable)?)
        };
        let notes = Notes::default();
        notes.with(|noted| noted.digest = hashes.then(Sha256::new));
        Ok((Box::new(Watched { inner, notes: notes.clone(), hashes }), notes))
    }

    /// The content of a file of at most `most` bytes, and its SHA-256.
    ///
    /// # Errors
    /// [`AccessError`] if the file can't be read or is longer.
    pub fn read(&self, file: &CaptureFile, most: u64) -> Result<(Vec<u8>, String), AccessError> {
        let unreadable = |reason: String| AccessError::Read { name: file.name.clone(), reason };
        if file.size > most {
            return Err(unreadable(format!("{} bytes are more than the {most} that such a file may have", file.size)));
        }
        let (reader, notes) = self.open(file, true)?;
        let mut content = Vec::new();
        reader.take(most).read_to_end(&mut content).map_err(|error| unreadable(error.to_string()))?;
        Ok((content, notes.sha256().unwrap_or_default().1))
    }

    /// The SHA-256 of a file in hexadecimal.
    ///
    /// # Errors
    /// [`AccessError`] if the file can't be read.
    pub fn hash(&self, file: &CaptureFile) -> Result<String, AccessError> {
        let (mut reader, notes) = self.open(file, true)?;
        let unreadable = |error: io::Error| AccessError::Read { name: file.name.clone(), reason: error.to_string() };
        io::copy(&mut reader, &mut io::sink()).map_err(unreadable)?;
        Ok(notes.sha256().unwrap_or_default().1)
    }
}

/// The object store of a URL, and the path in the store.
///
/// # Errors
/// [`AccessError::Url`] if the runtime knows no such store.
pub fn locate(runtime: &RuntimeEnv, name: &str) -> Result<(Arc<dyn ObjectStore>, ObjectPath), AccessError> {
    let wrong = |reason: String| AccessError::Url { name: name.to_owned(), reason };
    let url = Url::parse(name).map_err(|error| wrong(error.to_string()))?;
    let store = runtime.object_store_registry.get_store(&url).map_err(|error| wrong(error.to_string()))?;
    let path = ObjectPath::from_url_path(url.path()).map_err(|error| wrong(error.to_string()))?;
    Ok((store, path))
}
