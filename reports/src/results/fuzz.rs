//! `canvass fuzz`.

use super::test::MovedZeroPoint;
use super::{Contract, Provenance, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The result of `canvass fuzz`. On the simulated bus two runs with the same seed give the same bytes.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FuzzResult {
    /// The words of `--allow`.
    pub allow: Vec<Word>,
    /// The bit rate in bit/s.
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
    /// Number of frames after which the answer, or the silence, was judged, including those of shortening.
    pub executions: u64,
    /// Number of frames sent, including frames after which the standard leaves everything open.
    pub frames: u64,
    /// The interruptions of the bus; `null` if there were none.
    pub interruptions: Option<Interruptions>,
    /// The settings after the run; `null` on the simulated bus, and if the device does not answer any more.
    pub left: Option<SettingsLeft>,
    /// The model or description of the device.
    pub model: Option<String>,
    pub node: u8,
    pub provenance: Provenance,
    /// The command that repeats the run.
    pub repeat: String,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    pub seed: u64,
    /// Number of sequences that were run.
    pub sequences: u64,
    /// The services: `all`, or names with commas between them.
    pub target: String,
    /// Number of sequences without a result, because frames were lost here or the bus was interrupted.
    pub unjudged: u64,
    /// The version of canvass: with the seed it makes the run repeatable.
    pub version: Word,
    /// The violations, each once.
    pub violations: Vec<Violation>,
    /// The zero point of a live device, if it has moved during the run; otherwise `null`.
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
    /// Number of answers by class: `none`, `abort`, `data`, `confirmation` or `block`.
    pub answers: BTreeMap<Word, u64>,
    pub command: Word,
    pub state: Word,
}

/// The interruptions of the connection to the bus.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Interruptions {
    pub count: u64,
    /// The duration of all interruptions together.
    pub duration_ns: u64,
    /// The last interruption in words.
    pub last: Option<String>,
    /// Whether the connection is back.
    pub over: bool,
}

/// The settings of a live device after the run.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SettingsLeft {
    /// Number of settings that were read before and after the run.
    pub compared: usize,
    /// The settings that have another value and do not change by themselves.
    pub different: Vec<Kept>,
    /// Number of settings that were read before the run.
    pub settings: usize,
}

/// An object that does not have its power-on value.
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
    /// The clause of the standard.
    #[serde(default)]
    pub clause: String,
    /// Whether the violation came again in each repetition from the same start.
    pub confirmed: bool,
    /// Whether the bus was lost before the sequence could be repeated.
    #[serde(default)]
    pub cut_off: bool,
    /// The state of the device according to the reference models.
    #[serde(default)]
    pub device_state: String,
    /// All frames on the bus during the sequence; if the violation did not come back, those of its only occurrence.
    pub evidence: Vec<SeenFrame>,
    pub expected: String,
    /// The shortest sequence found that shows the violation.
    pub frames: Vec<SentFrame>,
    /// The id of the defect, the same in each run: property, rule, and what is wrong with the answer.
    #[serde(default)]
    pub id: String,
    /// The time after which an answer came that had been missing; `null` if it did not come.
    #[serde(default)]
    pub late_ns: Option<u64>,
    /// The sequence as a candump log, with the frames of the device as comments.
    pub log: String,
    /// Whether the violation came back only when all frames since a reset were sent again: these are the sequence.
    #[serde(default)]
    pub needs_earlier: bool,
    /// The violated property, such as `PROP-02`.
    pub property: Word,
    /// The violation as a test for pytest, with python-canopen.
    #[serde(default)]
    pub pytest: String,
    /// The repetitions of the sequence, each from a start.
    #[serde(default)]
    pub repetitions: Vec<Repetition>,
    /// The violated rule of the property.
    pub rule: Word,
    /// The state at the beginning of the sequence: `configured` or `without-node-id`.
    pub start: Word,
    /// Objects without their power-on values when the violation was seen: no reset and no write had restored them.
    pub state: Vec<Kept>,
    /// The time on the clock of the bus.
    pub t: u64,
    /// The violation as a Rust test.
    pub test: String,
    /// Number of sequences that have shown the violation, without its repetitions.
    #[serde(default)]
    pub times: u64,
    pub title: Word,
}

/// A repetition of the sequence of a violation.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Repetition {
    /// The behaviour of the device: the wrong answer, or `no violation`.
    pub came: String,
    /// When the next frame was sent: after the `answers` of the device, or at the `times` of the log.
    pub replay: Word,
    /// Whether the violation came.
    pub shows: bool,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SentFrame {
    pub data: String,
    /// For a remote frame: the requested length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dlc: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<bool>,
    pub id: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote: Option<bool>,
    pub text: String,
    /// The wait after the frame: `settle` (as long as the device needs), `at-once`, or `pause` with `wait_ns`.
    pub then: Word,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wait_ns: Option<u64>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SeenFrame {
    pub data: String,
    /// `rx` or `tx`.
    pub direction: Word,
    /// For a remote frame: the requested length.
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
