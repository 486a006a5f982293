//! `canvass-fleet executor`: the process that decodes captures and computes with their rows.

use super::server;
use crate::cli::parse_size;
use crate::status::{Failure, Status};
use canvass_fleet::cluster::client::PORT;
use canvass_fleet::cluster::executor::Executor;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Run an executor of a cluster
///
/// The executor needs the captures under the same paths as the scheduler, in a shared folder or an object store. After
/// Ctrl-C it completes the tasks in progress and ends.
#[derive(clap::Args)]
pub struct Args {
    /// The scheduler
    #[arg(long, value_name = "HOST:PORT", value_parser = parse_scheduler)]
    scheduler: (String, u16),
    /// The address at which other computers fetch the results of tasks. The next port receives the tasks; with port 0,
    /// two free ports are chosen
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:50051")]
    bind: SocketAddr,
    /// The name by which other computers reach this executor (default: its address in the connection to the scheduler)
    #[arg(long, value_name = "HOST")]
    advertise: Option<String>,
    /// The folder for the results of tasks (default: a temporary folder, removed at the end)
    #[arg(long, value_name = "DIR")]
    work_dir: Option<PathBuf>,
    /// Number of tasks that run in parallel (default: number of processors)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    tasks: Option<u16>,
    /// Memory limit of all tasks together, such as 4G (default: 70 % of the machine's memory)
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    memory: Option<usize>,
    #[command(flatten)]
    logging: server::Logging,
}

impl Args {
    pub async fn run(self) -> Result<Status, Failure> {
        self.logging.begin()?;
        let Self { scheduler, bind, advertise, work_dir, tasks, memory, .. } = self;
        let tasks = tasks.map(usize::from);
        Executor { scheduler, bind, advertise, work_dir, tasks, memory }.run().await?;
        Ok(Status::Good)
    }
}

fn parse_scheduler(text: &str) -> Result<(String, u16), String> {
    let text = text.strip_prefix("df://").unwrap_or(text).trim_end_matches('/');
    let (host, port) = match text.rsplit_once(':') {
        Some((host, port)) => (host, port.parse().map_err(|_| "expected HOST:PORT, such as localhost:50050")?),
        None => (text, PORT),
    };
    match host {
        "" => Err("expected HOST:PORT, such as localhost:50050".to_owned()),
        host => Ok((host.to_owned(), port)),
    }
}
