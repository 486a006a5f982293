//! Ballista's executor, which decodes captures on the computer where it runs.

use super::codec::{LogicalCodec, PhysicalCodec};
use super::{ClusterError, LONGEST_MESSAGE, config};
use crate::session::Settings;
use crate::stores;
use ballista_executor::executor_process::{ExecutorProcessConfig, start_executor_process};
use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;

/// The settings of an executor.
#[derive(Clone, Debug)]
pub struct Executor {
    /// Host and port of the scheduler.
    pub scheduler: (String, u16),
    /// The address at which others fetch the results of tasks; tasks arrive at the next port. Port 0 chooses two free
    /// ports.
    pub bind: SocketAddr,
    /// The name by which others reach the executor; `None`: the address from which it calls the scheduler.
    pub advertise: Option<String>,
    /// The folder for the results of tasks; `None`: a temporary folder, removed at the end.
    pub work_dir: Option<PathBuf>,
    /// Number of tasks that run at a time; `None`: number of processors.
    pub tasks: Option<usize>,
    /// Number of bytes of memory that all tasks together may take.
    pub memory: Option<usize>,
}

/// Seconds between two heartbeats of the executor to the scheduler.
const HEARTBEAT_SECONDS: u64 = 3;

/// Seconds during which the executor tries to reach its scheduler, which may be started at the same time.
const PATIENCE_SECONDS: u16 = 30;

impl Executor {
    /// Runs until the process is asked to end.
    ///
    /// # Errors
    /// [`ClusterError`] if a port can't be opened or the scheduler can't be reached.
    pub async fn run(self) -> Result<(), ClusterError> {
        let (port, grpc_port) = self.ports()?;
        let temporary = tempfile::Builder::new().prefix("canvass-fleet-").tempdir().map_err(ClusterError::Folder)?;
        let work_dir = self.work_dir.clone().unwrap_or_else(|| temporary.path().to_owned());
        std::fs::create_dir_all(&work_dir).map_err(ClusterError::Folder)?;
        let host = self.host();
        let config = ExecutorProcessConfig {
            bind_host: self.bind.ip().to_string(),
            external_host: self.advertise,
            port,
            grpc_port,
            scheduler_host: self.scheduler.0,
            scheduler_port: self.scheduler.1,
            scheduler_connect_timeout_seconds: PATIENCE_SECONDS,
            vcores: self.tasks.unwrap_or(0),
            work_dir: Some(work_dir.display().to_string()),
            memory_pool_size: self.memory.map(|bytes| bytes as u64),
            grpc_max_decoding_message_size: LONGEST_MESSAGE,
            grpc_max_encoding_message_size: LONGEST_MESSAGE,
            executor_heartbeat_interval_seconds: HEARTBEAT_SECONDS,
            override_runtime_producer: Some(Arc::new(|_| stores::runtime(None))),
            override_config_producer: Some(Arc::new(|| config(&Settings::default()))),
            override_logical_codec: Some(Arc::new(LogicalCodec::default())),
            override_physical_codec: Some(Arc::new(PhysicalCodec::at(&format!("executor {host}:{port}")))),
            ..ExecutorProcessConfig::default()
        };
        let ended = start_executor_process(Arc::new(config)).await;
        ended.map_err(|error| ClusterError::Stopped { process: "executor", reason: error.to_string() })
    }

    /// The name of this computer in error messages.
    fn host(&self) -> String {
        let named = || computer_name().filter(|_| self.bind.ip().is_unspecified());
        self.advertise.clone().or_else(named).unwrap_or_else(|| self.bind.ip().to_string())
    }

    /// The two ports. Both are opened once beforehand, so that the reason is reported if a port can't be opened.
    fn ports(&self) -> Result<(u16, u16), ClusterError> {
        let open = |port: u16| {
            let address = SocketAddr::new(self.bind.ip(), port);
            let opened = TcpListener::bind(address).and_then(|listener| Ok((listener.local_addr()?.port(), listener)));
            opened.map_err(|source| ClusterError::Bind { address: address.to_string(), source })
        };
        let second = match self.bind.port() {
            0 => 0,
            port => port.checked_add(1).unwrap_or(port - 1),
        };
        // Both ports are open at the same time, so that they differ.
        let (one, other) = (open(self.bind.port())?, open(second)?);
        Ok((one.0, other.0))
    }
}

/// The name of this computer, if the system offers it in a file or the environment.
fn computer_name() -> Option<String> {
    let told = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let variable = || ["HOSTNAME", "COMPUTERNAME"].into_iter().find_map(|name| std::env::var(name).ok());
    told.map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).or_else(variable)
}
