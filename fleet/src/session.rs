//! A session: the query engine with our tables.

use crate::scan::{FileTables, Options, register};
use crate::stores;
use datafusion::catalog::{DynamicFileCatalog, UrlTableFactory};
use datafusion::error::Result;
use datafusion::execution::runtime_env::RuntimeEnv;
use datafusion::execution::session_state::SessionStateBuilder;
use datafusion::prelude::{SessionConfig, SessionContext};
use std::sync::Arc;

/// The settings of a session.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The options of scans.
    pub scan: Options,
    /// Number of parts of a query that run at a time; `None`: number of processors.
    pub partitions: Option<usize>,
    /// Number of bytes of memory that queries may take before they use the disk; `None`: no limit.
    pub memory: Option<usize>,
}

impl Settings {
    /// The settings in the engine's form.
    pub fn config(&self) -> SessionConfig {
        let mut config = SessionConfig::new().with_information_schema(true).with_option_extension(self.scan.clone());
        if let Some(partitions) = self.partitions {
            config = config.with_target_partitions(partitions);
        }
        // Without this option the engine would read texts as view types. The schema has dictionaries and plain texts.
        config.options_mut().execution.parquet.schema_force_view_types = false;
        config
    }
}

/// A session in this process.
///
/// # Errors
/// If no folder for temporary files can be made.
pub fn local(settings: &Settings) -> Result<SessionContext> {
    Ok(with_tables(settings.config(), stores::runtime(settings.memory)?))
}

/// A session with our table functions, and files as tables.
pub fn with_tables(config: SessionConfig, runtime: Arc<RuntimeEnv>) -> SessionContext {
    let builder = SessionStateBuilder::new().with_config(config).with_runtime_env(runtime).with_default_features();
    complete(SessionContext::new_with_state(builder.build()))
}

/// Adds our tables to a session, such as a session of a cluster.
pub fn complete(context: SessionContext) -> SessionContext {
    let factory = Arc::new(FileTables::default());
    let known = Arc::clone(context.state_ref().read().catalog_list());
    let catalogs = Arc::new(DynamicFileCatalog::new(known, Arc::clone(&factory) as Arc<dyn UrlTableFactory>));
    let id = context.session_id();
    let state = context.into_state_builder().with_session_id(id).with_catalog_list(catalogs).build();
    let context = SessionContext::new_with_state(state);
    factory.session_store().with_state(context.state_weak_ref());
    register(&context);
    context
}
