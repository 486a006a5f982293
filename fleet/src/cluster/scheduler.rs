//! Ballista's scheduler, which knows our tables.

use super::codec::{LogicalCodec, PhysicalCodec};
use super::{ClusterError, LONGEST_MESSAGE, config};
use crate::session::Settings;
use crate::stores;
use ballista_core::extension::{ballista_aggregate_functions, ballista_scalar_functions, ballista_window_functions};
use ballista_core::optimizer::ballista_default_optimizer_rules;
use ballista_scheduler::cluster::BallistaCluster;
use ballista_scheduler::config::{SchedulerConfig, TaskDistributionPolicy};
use ballista_scheduler::scheduler_process::{create_scheduler, start_grpc_service_with_listener};
use datafusion::error::Result;
use datafusion::execution::SessionState;
use datafusion::execution::session_state::SessionStateBuilder;
use datafusion::prelude::SessionConfig;
use datafusion_proto::protobuf::{LogicalPlanNode, PhysicalPlanNode};
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::TcpListener;

/// Seconds of silence after which an executor counts as dead, and other executors get its work.
const SILENT_SECONDS: u64 = 15;

/// Runs the scheduler until the process is asked to end; `ready` gets the address.
///
/// # Errors
/// [`ClusterError`] if the port can't be opened or the scheduler stops on its own.
pub async fn run(bind: &str, ready: impl FnOnce(SocketAddr)) -> Result<(), ClusterError> {
    let unbound = |source| ClusterError::Bind { address: bind.to_owned(), source };
    let listener = TcpListener::bind(bind).await.map_err(unbound)?;
    let address = listener.local_addr().map_err(unbound)?;
    let config = Arc::new(scheduler_config(address));
    let stopped = |error: ballista_core::error::BallistaError| ClusterError::Stopped {
        process: "scheduler",
        reason: error.to_string(),
    };
    let cluster = BallistaCluster::new_from_config(&config).await.map_err(stopped)?;
    let scheduler = create_scheduler::<LogicalPlanNode, PhysicalPlanNode>(cluster, config).await.map_err(stopped)?;
    ready(address);
    tokio::select! {
        served = start_grpc_service_with_listener(listener, scheduler) => served.map_err(stopped),
        () = told_to_end() => Ok(()),
    }
}

fn scheduler_config(address: SocketAddr) -> SchedulerConfig {
    SchedulerConfig {
        bind_host: address.ip().to_string(),
        bind_port: address.port(),
        // Executors get tasks in turn, so that all of them have work.
        task_distribution: TaskDistributionPolicy::RoundRobin,
        executor_timeout_seconds: SILENT_SECONDS,
        expire_dead_executor_interval_seconds: 2,
        no_executors_grace_period_seconds: SILENT_SECONDS,
        grpc_server_max_decoding_message_size: LONGEST_MESSAGE,
        grpc_server_max_encoding_message_size: LONGEST_MESSAGE,
        grpc_client_max_message_size: LONGEST_MESSAGE,
        override_config_producer: Some(Arc::new(|| config(&Settings::default()))),
        override_session_builder: Some(Arc::new(session)),
        override_logical_codec: Some(Arc::new(LogicalCodec::default())),
        override_physical_codec: Some(Arc::new(PhysicalCodec::default())),
        ..SchedulerConfig::default()
    }
}

/// A session in which queries are planned: files are found through our stores.
fn session(config: SessionConfig) -> Result<SessionState> {
    let builder = SessionStateBuilder::new()
        .with_default_features()
        .with_config(config)
        .with_runtime_env(stores::runtime(None)?)
        .with_optimizer_rules(ballista_default_optimizer_rules())
        .with_scalar_functions(ballista_scalar_functions())
        .with_aggregate_functions(ballista_aggregate_functions())
        .with_window_functions(ballista_window_functions());
    Ok(builder.build())
}

/// Returns when the process is asked to end: Ctrl-C, or SIGTERM as service managers send it.
async fn told_to_end() {
    let interrupted = async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    #[cfg(unix)]
    let terminated = async {
        match tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()) {
            Ok(mut signal) => drop(signal.recv().await),
            Err(_) => std::future::pending::<()>().await,
        }
    };
    #[cfg(not(unix))]
    let terminated = std::future::pending::<()>();
    tokio::select! {
        () = interrupted => {}
        () = terminated => {}
    }
}
