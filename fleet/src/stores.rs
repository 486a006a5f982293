//! Object stores, found by their URL: `file:` is this computer, `s3:` is configured by the environment.
//!
//! Credentials and regions come from the same variables as for the command line tools of AWS (`AWS_ACCESS_KEY_ID`,
//! `AWS_SECRET_ACCESS_KEY`, `AWS_REGION`, `AWS_ENDPOINT`, `AWS_ALLOW_HTTP`, web identities, instance profiles).

use datafusion::error::{DataFusionError, Result};
use datafusion::execution::object_store::{DefaultObjectStoreRegistry, ObjectStoreRegistry};
use datafusion::execution::runtime_env::{RuntimeEnv, RuntimeEnvBuilder};
use object_store::ObjectStore;
use object_store::aws::AmazonS3Builder;
use std::sync::Arc;
use url::Url;

/// The registered stores; an S3 store is created at its first use.
#[derive(Debug, Default)]
pub struct Stores(DefaultObjectStoreRegistry);

impl ObjectStoreRegistry for Stores {
    fn register_store(&self, url: &Url, store: Arc<dyn ObjectStore>) -> Option<Arc<dyn ObjectStore>> {
        self.0.register_store(url, store)
    }

    fn deregister_store(&self, url: &Url) -> Result<Arc<dyn ObjectStore>> {
        self.0.deregister_store(url)
    }

    fn get_store(&self, url: &Url) -> Result<Arc<dyn ObjectStore>> {
        match self.0.get_store(url) {
            Err(_) if url.scheme() == "s3" => {
                let builder = AmazonS3Builder::from_env().with_url(url.as_str());
                let store: Arc<dyn ObjectStore> =
                    Arc::new(builder.build().map_err(|error| DataFusionError::ObjectStore(Box::new(error)))?);
                self.0.register_store(url, Arc::clone(&store));
                Ok(store)
            }
            known => known,
        }
    }
}

/// A runtime with these stores, in which queries may take `memory` bytes of memory before they use the disk.
///
/// # Errors
/// If no folder for temporary files can be made.
pub fn runtime(memory: Option<usize>) -> Result<Arc<RuntimeEnv>> {
    let mut builder = RuntimeEnvBuilder::new().with_object_store_registry(Arc::new(Stores::default()));
    if let Some(memory) = memory {
        builder = builder.with_memory_limit(memory, 1.0);
    }
    builder.build_arc()
}
