//! The location of a lake: a folder of this computer or of an object store.

use super::LakeError;
use crate::capture::is_url;
use datafusion::execution::object_store::ObjectStoreUrl;
use datafusion::execution::runtime_env::RuntimeEnv;
use object_store::ObjectStore;
use object_store::path::Path as ObjectPath;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use url::Url;

/// The location of a lake.
#[derive(Clone, Debug)]
pub struct Location {
    /// The URL of the lake, with a slash at its end.
    pub url: Url,
    /// The store of the lake.
    pub store: Arc<dyn ObjectStore>,
    /// The lake's folder in the store.
    pub root: ObjectPath,
}

impl Location {
    /// The location of a path or URL.
    ///
    /// # Errors
    /// [`LakeError::Place`] if there is no such store.
    pub fn of(text: &str, runtime: &RuntimeEnv) -> Result<Self, LakeError> {
        let wrong = |reason: String| LakeError::Place { place: text.to_owned(), reason };
        let url = if is_url(text) {
            Url::parse(&format!("{}/", text.trim_end_matches('/'))).map_err(|error| wrong(error.to_string()))?
        } else {
            let path = std::path::absolute(Path::new(text)).map_err(|error| wrong(error.to_string()))?;
            let path = without_parents(&path);
            Url::from_directory_path(path).map_err(|()| wrong("expected a folder".to_owned()))?
        };
        let store = runtime.object_store_registry.get_store(&url).map_err(|error| wrong(error.to_string()))?;
        // The names of folders stay as they are, whatever characters they have.
        let decoded = percent_encoding::percent_decode_str(url.path()).decode_utf8();
        let decoded = decoded.map_err(|error| wrong(error.to_string()))?;
        let root = ObjectPath::parse(decoded.as_ref()).map_err(|error| wrong(error.to_string()))?;
        Ok(Self { url, store, root })
    }

    /// The lake's folder, if it is on this computer.
    pub fn folder(&self) -> Option<PathBuf> {
        if self.url.scheme() == "file" { self.url.to_file_path().ok() } else { None }
    }

    /// The path in the store of a path in the lake.
    pub fn path(&self, relative: &str) -> ObjectPath {
        relative.split('/').fold(self.root.clone(), |path, part| path.join(part))
    }

    /// The URL of the store, for the query engine.
    ///
    /// # Errors
    /// [`LakeError::Place`] if the engine does not know this kind of URL.
    pub fn store_url(&self) -> Result<ObjectStoreUrl, LakeError> {
        let base = &self.url[url::Position::BeforeScheme..url::Position::BeforePath];
        let wrong = |reason: String| LakeError::Place { place: self.url.to_string(), reason };
        ObjectStoreUrl::parse(base).map_err(|error| wrong(error.to_string()))
    }
}

/// The path without `..`. Of an existing folder it is the true path; otherwise `..` means the folder as it is written.
fn without_parents(path: &Path) -> PathBuf {
    let lexical = || {
        path.components().fold(PathBuf::new(), |mut made, part| {
            match part {
                Component::ParentDir => _ = made.pop(),
                other => made.push(other),
            }
            made
        })
    };
    path.canonicalize().unwrap_or_else(|_| lexical())
}
