//! `canvass-fleet scheduler`: the process that gives work to executors.

use super::server;
use crate::output::diagnostic;
use crate::status::{Failure, Status};
use canvass_fleet::cluster::scheduler;

/// Run the scheduler of a cluster
///
/// The scheduler finds the captures of a query and distributes them to executors. Ctrl-C ends it.
#[derive(clap::Args)]
pub struct Args {
    /// The address for clients and executors
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:50050")]
    bind: String,
    #[command(flatten)]
    logging: server::Logging,
}

impl Args {
    pub async fn run(self) -> Result<Status, Failure> {
        self.logging.begin()?;
        scheduler::run(&self.bind, |address| diagnostic(&format!("canvass-fleet: scheduler at {address}"))).await?;
        Ok(Status::Good)
    }
}
