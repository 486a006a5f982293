//! `run.json`: the options and inputs of a run, from which its recording can be judged again.

use anyhow::{Context, Result, anyhow, bail};
use canvass_suite::bench::{Options, Timing};
use canvass_suite::touch::Touch;
use canvass_traces::Duration;
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
    allow: Vec<String>,
    repeat: u32,
    retries: u32,
    fail_fast: bool,
    exhaustive: bool,
    /// Programs before this option wrote no such field.
    #[serde(default)]
    zero_point_is_stored: bool,
    limit_ns: Option<u64>,
    timing: Times,
}

/// All waiting times in nanoseconds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Times {
    sdo_response_ns: u64,
    store_ns: u64,
    lss_ns: u64,
    boot_up_ns: u64,
    reaction_ns: u64,
    silence_ns: u64,
    period_tolerance: u32,
}

impl Setup {
    /// Records these options; the caller adds the bus, the device and the cases.
    pub fn new(options: &Options) -> Self {
        let of = &options.timing;
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
            allow: options.allow.iter().map(|touch| touch.name().to_owned()).collect(),
            repeat: options.repeat,
            retries: options.retries,
            fail_fast: options.fail_fast,
            exhaustive: options.exhaustive,
            zero_point_is_stored: options.zero_point_is_stored,
            limit_ns: options.limit.map(Duration::nanos),
            timing: Times {
                sdo_response_ns: of.sdo_response.nanos(),
                store_ns: of.store.nanos(),
                lss_ns: of.lss.nanos(),
                boot_up_ns: of.boot_up.nanos(),
                reaction_ns: of.reaction.nanos(),
                silence_ns: of.silence.nanos(),
                period_tolerance: of.period_tolerance,
            },
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
        if setup.repeat > MOST_RUNS || setup.retries > MOST_RUNS {
            bail!("run.json: expected at most {MOST_RUNS} runs of a case");
        }
        Ok(setup)
    }

    /// The text of `run.json`.
    pub fn text(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The options of the run, without its shell commands: a bundle from elsewhere must not start programs.
    pub fn options(&self) -> Result<Options> {
        let allow = self.allow.iter().map(|name| name.parse::<Touch>().map_err(|error| anyhow!("run.json: {error}")));
        let of = &self.timing;
        Ok(Options {
            allow: allow.collect::<Result<_>>()?,
            timing: Timing {
                sdo_response: Duration(of.sdo_response_ns),
                store: Duration(of.store_ns),
                lss: Duration(of.lss_ns),
                boot_up: Duration(of.boot_up_ns),
                reaction: Duration(of.reaction_ns),
                silence: Duration(of.silence_ns),
                period_tolerance: of.period_tolerance,
            },
            repeat: self.repeat,
            retries: self.retries,
            power_cycle: None,
            fail_fast: self.fail_fast,
            exhaustive: self.exhaustive,
            zero_point_is_stored: self.zero_point_is_stored,
            limit: self.limit_ns.map(Duration),
            journal: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let read = Setup::read(text.as_bytes()).unwrap().options().unwrap();
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
