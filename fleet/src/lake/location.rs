//! Where a lake is: a folder of this computer, or of an object store.

use super::LakeError;
use crate::capture::is_url;
use datafusion::execution::object_store::ObjectStoreUrl;
use datafusion::execution::runtime_env::RuntimeEnv;
use object_store::ObjectStore;
use object_store::path::Path as ObjectPath;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use url::Url;

/// The place of a lake.
#[derive(Clone, Debug)]
pub struct Location {
    /// As a URL, with a slash at its end.
    pub url: Url,
    /// The store that it is in.
    pub store: Arc<dyn ObjectStore>,
    /// Its folder in the store.
    pub root: ObjectPath,
}

impl Location {
    /// The place that a path or URL means.
    ///
    /// # Errors
    /// [`LakeError::Place`] if there is no such store.
    pub fn of(text: &str, runtime: &RuntimeEnv) -> Result<Self, LakeError> {
        let wrong = |reason: String| LakeError::Place { place: text.to_owned(), reason };
        let url = if is_url(text) {
            Url::parse(&format!("{}/", text.trim_end_matches('/'))).map_err(|error| wrong(error.to_string()))?
        } else {
            let path = std::path::absolute(Path::new(text)).map_err(|error| wrong(error.to_string()))?;
            Url::from_directory_path(path).map_err(|()| wrong("expected a folder".to_owned()))?
        };
        let store = runtime.object_store_registry.get_store(&url).map_err(|error| wrong(error.to_string()))?;
        let root = ObjectPath::from_url_path(url.path()).map_err(|error| wrong(error.to_string()))?;
        Ok(Self { url, store, root })
    }

    /// Its folder, where it is one of this computer.
    pub fn folder(&self) -> Option<PathBuf> {
        if self.url.scheme() == "file" { self.url.to_file_path().ok() } else { None }
    }

    /// A path in the lake.
    pub fn path(&self, relative: &str) -> ObjectPath {
        relative.split('/').fold(self.root.clone(), |path, part| path.join(part))
    }

    /// The store as the query engine knows it.
    ///
    /// # Errors
    /// [`LakeError::Place`] if the URL is of no kind that the engine knows.
    pub fn store_url(&self) -> Result<ObjectStoreUrl, LakeError> {
        let base = &self.url[url::Position::BeforeScheme..url::Position::BeforePath];
        let wrong = |reason: String| LakeError::Place { place: self.url.to_string(), reason };
        ObjectStoreUrl::parse(base).map_err(|error| wrong(error.to_string()))
    }
}
