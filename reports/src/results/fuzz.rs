//! `canvass fuzz`.

use super::test::MovedZeroPoint;
use super::{Contract, Provenance, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The result of `canvass fuzz`. On the simulated bus two runs of one seed give the same bytes.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FuzzResult {
    /// What `--allow` named.
    pub allow: Vec<Word>,
    /// In bit/s.
    pub bit_rate: Option<u32>,
    /// The bus as the user addressed it.
    pub bus: String,
    /// Whether the run was interrupted.
    pub cancelled: bool,
    pub coverage: Coverage,
    /// Whether the device did not come back after a reset, and the run ended.
    pub dead: bool,
    /// Why the run ended early: the bus did not come back, or failed in another way.
    pub ended_by: Option<String>,
    /// Exchanges: frames that were sent and after which the answer, or the silence, was judged; those of shrinking included.
    pub executions: u64,
    /// Frames that were sent: with those after which anything may come.
    pub frames: u64,
    /// `null` where the bus was not interrupted.
    pub interruptions: Option<Interruptions>,
    /// `null` on the simulated bus and where the device does not answer any more.
    pub left: Option<SettingsLeft>,
    /// The model or description of the device.
    pub model: Option<String>,
    pub node: u8,
    pub provenance: Provenance,
    /// The command that does the same again.
    pub repeat: String,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    pub seed: u64,
    /// Sequences that were tried.
    pub sequences: u64,
    /// The services: `all`, or names with commas between them.
    pub target: String,
    /// Sequences that say nothing: frames were lost on this machine, or the bus was interrupted.
    pub unjudged: u64,
    /// The version of canvass: with the seed it makes the run repeatable.
    pub version: Word,
    /// Each once.
    pub violations: Vec<Violation>,
    /// The zero point of a device on a bus that goes on, where it is not where it was before the run; else `null`.
    pub zero_point: Option<MovedZeroPoint>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Coverage {
    pub lss: Share<LssPair>,
    pub sdo: Share<SdoPair>,
}

/// Combinations of state and command.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Share<Pair> {
    pub pairs: Vec<Pair>,
    pub reachable: usize,
    pub reached: usize,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct LssPair {
    pub answered: bool,
    pub command: Word,
    pub count: u64,
    pub state: Word,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SdoPair {
    /// How often which class of answer came: `none`, `abort`, `data`, `confirmation`, `block`.
    pub answers: BTreeMap<Word, u64>,
    pub command: Word,
    pub state: Word,
}

/// How the way to the bus was interrupted.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Interruptions {
    pub count: u64,
    /// All of them together.
    pub duration_ns: u64,
    /// What the last one was.
    pub last: Option<String>,
    /// Whether the way is there again.
    pub over: bool,
}

/// What the settings of a device on a bus hold at the end.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SettingsLeft {
    /// The number of those that were read before the run and after it.
    pub compared: usize,
    /// Those that hold another value and do not move by themselves.
    pub different: Vec<Kept>,
    /// The number of those that were read before the run.
    pub settings: usize,
}

/// An object that has not its value of power-on.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Kept {
    pub index: u16,
    pub power_on: u64,
    pub sub: u8,
    pub value: u64,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Violation {
    pub actual: String,
    /// Whether it came again when the sequence was repeated from power-on.
    pub confirmed: bool,
    /// Whether the bus was lost before it could be repeated.
    #[serde(default)]
    pub cut_off: bool,
    /// All frames of the sequence on the bus; of a violation that did not come back, those of the one time.
    pub evidence: Vec<SeenFrame>,
    pub expected: String,
    /// The shortest sequence that shows it.
    pub frames: Vec<SentFrame>,
    /// The sequence as candump log.
    pub log: String,
    /// `PROP-02`.
    pub property: Word,
    /// What of the property.
    pub rule: Word,
    /// `configured` or `without-node-id`.
    pub start: Word,
    /// The objects that neither a reset nor a write had brought back when it was seen.
    pub state: Vec<Kept>,
    /// On the clock of the bus.
    pub t: u64,
    /// The violation as a Rust test.
    pub test: String,
    pub title: Word,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SentFrame {
    pub data: String,
    /// Of a remote frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dlc: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<bool>,
    pub id: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote: Option<bool>,
    pub text: String,
    /// `settle` (the device gets the time that it needs), `at-once`, or `pause` with `wait_ns`.
    pub then: Word,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wait_ns: Option<u64>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SeenFrame {
    pub data: String,
    /// `rx` or `tx`.
    pub direction: Word,
    /// Of a remote frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dlc: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<bool>,
    pub id: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote: Option<bool>,
    pub t: u64,
    pub text: String,
}

impl Contract for FuzzResult {
    const SCHEMA: &'static str = "canvass/fuzz/1";
    const COMMAND: &'static str = "canvass fuzz";
}
