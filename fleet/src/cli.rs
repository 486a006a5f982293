//! The command line.

use crate::commands::{executor, export, ingest, report, scheduler, schema, sql};
use crate::status::{Failure, Status};
use canvass_fleet::cluster::codec::absolute;
use canvass_fleet::cluster::{ClusterError, client};
use canvass_fleet::devices::{Devices, Rule};
use canvass_fleet::scan::Options;
use canvass_fleet::session::{self, Settings};
use clap::Parser;
use datafusion::prelude::SessionContext;

/// Query thousands of captures and test results in SQL
///
/// Captures of any format that canvass reads are tables: events('field/**/*.log'), messages(...), signals(...) and so
/// on. `canvass-fleet schema` shows all tables and columns.
#[derive(Parser)]
#[command(name = "canvass-fleet", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Sql(sql::Args),
    Decode(export::Decode),
    Signals(export::Signals),
    Diagnose(export::Diagnose),
    Ingest(ingest::Args),
    Report(report::Args),
    Schema(schema::Args),
    Scheduler(scheduler::Args),
    Executor(executor::Args),
}

impl Cli {
    /// Runs the typed command.
    pub async fn run(self) -> Result<Status, Failure> {
        match self.command {
            Command::Sql(args) => args.run().await,
            Command::Decode(args) => args.run().await,
            Command::Signals(args) => args.run().await,
            Command::Diagnose(args) => args.run().await,
            Command::Ingest(args) => args.run().await,
            Command::Report(args) => args.run().await,
            Command::Schema(args) => args.run(),
            Command::Scheduler(args) => args.run().await,
            Command::Executor(args) => args.run().await,
        }
    }
}

/// Options of the query engine.
#[derive(clap::Args)]
pub struct Engine {
    /// Files or built-in models of the nodes, by node-ID or by the identity that the captures show: 5=motor.eds,
    /// product:0x2011=encoder.eds, vendor:19,product:0x2011=encoder.eds
    #[arg(long, value_name = "WHO=FILE")]
    device: Vec<String>,
    /// Number of parts of a query that run in parallel (default: number of processors)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Memory limit above which queries use the disk, such as 512M or 4G
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    memory: Option<usize>,
    /// Run queries on the cluster of this scheduler; all its computers must be able to reach the captures
    #[arg(long, value_name = "df://HOST:PORT", env = "CANVASS_CLUSTER")]
    cluster: Option<String>,
}

impl Engine {
    /// The rules that tell which device a node is.
    pub fn devices(&self) -> Result<Devices, Failure> {
        let rules: Result<Vec<Rule>, _> = self.device.iter().map(|rule| rule.parse::<Rule>()).collect();
        Ok(Devices::new(rules?))
    }

    /// A session in which queries run.
    pub async fn session(&self) -> Result<SessionContext, Failure> {
        // An error in a rule is reported before any file is read.
        self.devices()?;
        let mut scan = Options::default();
        scan.devices = self.device.join("\n");
        let settings = Settings { scan, partitions: self.jobs.map(usize::from), memory: self.memory };
        match &self.cluster {
            None => Ok(session::local(&settings)?),
            Some(address) => Ok(client::connect(address, &settings).await.map_err(|error| match error {
                ClusterError::Unreachable { .. } => Failure::unreachable(error),
                other => other.into(),
            })?),
        }
    }

    /// The sources, with paths that mean the same on all computers of a cluster.
    pub fn sources(&self, given: Vec<String>) -> Result<Vec<String>, Failure> {
        match &self.cluster {
            None => Ok(given),
            Some(_) => Ok(given.iter().map(|name| absolute(name)).collect::<Result<_, _>>()?),
        }
    }
}

/// Parses a number of bytes with an optional K, M, G or T.
pub fn parse_size(text: &str) -> Result<usize, String> {
    let (digits, shift) = match text.char_indices().last() {
        Some((at, 'k' | 'K')) => (&text[..at], 10),
        Some((at, 'm' | 'M')) => (&text[..at], 20),
        Some((at, 'g' | 'G')) => (&text[..at], 30),
        Some((at, 't' | 'T')) => (&text[..at], 40),
        _ => (text, 0),
    };
    let size = digits.parse::<usize>().ok().and_then(|number| number.checked_mul(1 << shift));
    size.filter(|size| *size >= 16 << 20).ok_or_else(|| "expected at least 16M, such as 512M or 4G".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        <Cli as clap::CommandFactory>::command().debug_assert();
    }

    #[test]
    fn sizes_as_typed() {
        assert_eq!(parse_size("512M"), Ok(512 << 20));
        assert_eq!(parse_size("33554432"), Ok(32 << 20));
        for wrong in ["", "M", "1K", "x", "-1G", "99999999999T"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }
}
