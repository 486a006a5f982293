//! Options of scans, set by `SET canvass.… = …` or on the command line.

use crate::devices::{Devices, Rule};
use datafusion::common::config::ConfigExtension;
use datafusion::common::extensions_options;
use datafusion::config::ConfigOptions;
use datafusion::error::Result;

extensions_options! {
    /// How captures are scanned.
    pub struct Options {
        /// Whether filters and limits are applied before rows are made. Otherwise every row is made, and the query
        /// engine filters the rows: the answer is the same, but comes later.
        pub push_down: bool, default = true
        /// The rules that tell which device a node is, one rule a line: `5=motor.eds`, `product:0x2011=encoder.eds`.
        pub devices: String, default = String::new()
    }
}

impl ConfigExtension for Options {
    const PREFIX: &'static str = "canvass";
}

impl Options {
    /// The options of a session.
    pub fn of(config: &ConfigOptions) -> Self {
        config.extensions.get::<Self>().cloned().unwrap_or_default()
    }

    /// The rules, with the contents of the files that they name.
    ///
    /// # Errors
    /// If the syntax of a rule is wrong, or its file can't be read.
    pub fn devices(&self) -> Result<Devices> {
        let rules = self.devices.lines().filter(|line| !line.trim().is_empty());
        let read: Result<Vec<Rule>, _> = rules.map(|rule| rule.trim().parse::<Rule>()).collect();
        Ok(Devices::new(read.map_err(super::ScanError::from)?))
    }
}
