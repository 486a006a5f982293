//! Log messages of cluster processes while they run: lines on standard error.

use crate::output::diagnostic;
use crate::status::Failure;
use log::{LevelFilter, Log, Metadata, Record};

/// Options for log messages.
#[derive(clap::Args)]
pub struct Logging {
    /// Level of the log messages on standard error: off, error, warn, info, debug or trace
    #[arg(long, value_name = "LEVEL", default_value = "info", value_parser = parse_level)]
    log: LevelFilter,
}

fn parse_level(text: &str) -> Result<LevelFilter, String> {
    text.parse().map_err(|_| "expected off, error, warn, info, debug or trace".to_owned())
}

struct Lines;

impl Log for Lines {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        // Other libraries log each frame of each connection.
        let is_engine = ["ballista", "datafusion", "canvass"].iter().any(|name| metadata.target().starts_with(name));
        is_engine || metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let now = jiff::Timestamp::now();
            diagnostic(&format!("{now:.3} {:5} {}", record.level(), record.args()));
        }
    }

    fn flush(&self) {}
}

impl Logging {
    /// Starts logging.
    pub fn begin(&self) -> Result<(), Failure> {
        log::set_logger(&Lines).map_err(|error| anyhow::anyhow!("{error}"))?;
        log::set_max_level(self.log);
        Ok(())
    }
}
