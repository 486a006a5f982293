//! `run.json`: the options and inputs of a run, from which its recording can be judged again.

use anyhow::{Context, Result, bail};
use canvass_suite::bench::Options;
use serde::{Deserialize, Serialize};

/// Name of this file in the bundle.
pub const NAME: &str = "run.json";
const SCHEMA: &str = "canvass/bundle-run/1";
const MOST_RUNS: u32 = 1_000;

/// Options and inputs of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    schema: String,
    /// The bus, as the user addressed it.
    pub bus: String,
    /// The node-ID of the device under test.
    pub node: u8,
    /// The value of `--device`.
    pub device: Option<String>,
    /// Name of the description in the bundle, if the device has one.
    pub description: Option<String>,
    /// Whether the bundle holds waivers.
    pub waivers: bool,
    /// The day by which waivers were judged; empty without waivers.
    pub day: String,
    pub seed: u64,
    /// The cases in the order in which they ran.
    pub cases: Vec<String>,
    /// Why the run can't be repeated; `None` if it can.
    pub not_repeatable: Option<String>,
    /// The options of the run, without its shell commands: a bundle from elsewhere must not start programs.
    #[serde(flatten)]
    pub options: Options,
}

impl Setup {
    /// Records these options; the caller adds the bus, the device and the cases.
    pub fn new(options: &Options) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            bus: String::new(),
            node: 0,
            device: None,
            description: None,
            waivers: false,
            day: String::new(),
            seed: 0,
            cases: Vec::new(),
            not_repeatable: None,
            options: options.clone(),
        }
    }

    /// Reads `run.json` of a bundle.
    pub fn read(text: &[u8]) -> Result<Self> {
        let setup: Self =
            serde_json::from_slice(text).context("run.json does not have the form of a bundle's run.json")?;
        if setup.schema != SCHEMA {
            bail!("run.json: expected a document of schema {SCHEMA}, found \"{}\"", setup.schema);
        }
        // The same limits as on the command line: a forged bundle must not keep the program busy without end.
        if setup.options.repeat.max(setup.options.retries) > MOST_RUNS {
            bail!("run.json: expected at most {MOST_RUNS} runs of a case");
        }
        Ok(setup)
    }

    /// The text of `run.json`.
    pub fn text(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_suite::bench::Timing;
    use canvass_suite::touch::Touch;
    use canvass_traces::Duration;

    #[test]
    fn options_go_through_the_bundle_and_commands_do_not() {
        let options = Options {
            allow: [Touch::Nvm, Touch::NodeId].into(),
            timing: Timing { sdo_response: Duration(7), period_tolerance: 9, ..Timing::default() },
            repeat: 3,
            retries: 2,
            power_cycle: Some("rm -r /".to_owned()),
            fail_fast: true,
            exhaustive: true,
            zero_point_is_stored: true,
            limit: Some(Duration(5)),
            journal: None,
        };
        let text = Setup::new(&options).text().unwrap();
        let read = Setup::read(text.as_bytes()).unwrap().options;
        assert_eq!(read, Options { power_cycle: None, ..options });
        assert!(!text.contains("rm -r"));
    }

    #[test]
    fn what_would_never_end_is_refused() {
        let text = Setup::new(&Options::default()).text().unwrap();
        assert!(Setup::read(text.replace("\"repeat\": 0", "\"repeat\": 4000000000").as_bytes()).is_err());
        assert!(Setup::read(text.replace("bundle-run/1", "bundle-run/2").as_bytes()).is_err());
        assert!(Setup::read(b"{}").is_err());
    }
}
