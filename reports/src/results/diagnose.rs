//! `canvass diagnose`.

use super::quality::QualityResult;
use super::{Contract, Device, Provenance, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const SCHEMA: &str = "canvass/diagnose/1";

/// A value for each service of the frames.
pub(crate) type ByService<T> = BTreeMap<Word, T>;

/// The result of `canvass diagnose`. `Findings` and `Nodes` may be sequences that are made while they are written.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "DiagnoseResult")]
pub struct DiagnoseResult<Findings = Vec<Finding>, Nodes = Vec<Node>> {
    pub buses: Vec<Bus>,
    /// Number of frames on all buses, by service.
    pub counts: ByService<u64>,
    pub findings: Findings,
    /// Number of findings that are not listed, by rule.
    pub findings_omitted: BTreeMap<Word, u64>,
    pub frames: u64,
    pub frames_of_unwatched_channels: u64,
    pub nodes: Nodes,
    pub provenance: Provenance,
    pub quality: QualityResult,
    #[schemars(extend("const" = SCHEMA))]
    pub schema: Word,
    /// The stories: findings that have one cause, and their consequences.
    pub stories: Vec<Story>,
    /// Number of findings by severity.
    pub summary: BTreeMap<Word, usize>,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Bus {
    /// The bit rate in bit/s.
    pub bit_rate: Option<u32>,
    /// Whether the bit rate was inferred from the times of frames.
    pub bit_rate_inferred: bool,
    pub bits: u64,
    pub channel: String,
    /// Number of frames that another channel contains, too.
    pub copies: u64,
    pub counts: ByService<u64>,
    pub first_t: u64,
    pub frames: u64,
    pub last_t: u64,
    pub load_by_service: ByService<Load>,
    pub load_over_time: LoadOverTime,
    pub load_percent: Option<f64>,
    pub peak: Option<Peak>,
    /// Number of frames per second, by service.
    pub rates: ByService<Option<f64>>,
    /// The cases of a conformance run whose marks are in the capture.
    pub test_run: Vec<TestCase>,
    pub test_run_omitted: u64,
}

/// The bus load that frames cause.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Load {
    pub bits: u64,
    pub peak: Option<Peak>,
    pub percent: Option<f64>,
}

/// The tenth of a second with the highest load.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Peak {
    pub percent: f64,
    pub t: u64,
}

/// Number of bits in consecutive spans of equal length.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct LoadOverTime {
    pub bits: Vec<u64>,
    pub start_t: Option<u64>,
    pub width_ns: u64,
}

/// A case of a conformance run.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct TestCase {
    /// For a case of CiA's test tool: the number of the case in its group.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<u8>,
    pub frames: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// The line or packet at which the case begins.
    pub number: u64,
    pub number_last: u64,
    pub t: u64,
    pub t_last: u64,
    /// The verdict; `null` if the end of the case is missing.
    pub verdict: Option<String>,
}

/// A story. Its findings and consequences are given by their positions in the list of findings, from 0.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Story {
    pub consequences: Vec<Consequence>,
    pub findings: Vec<usize>,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Consequence {
    pub findings: Vec<usize>,
    pub of: usize,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    pub advice: Word,
    /// The case of a conformance run during which the finding first occurred.
    pub case: Option<CaseName>,
    pub channel: Option<String>,
    /// Number of occurrences.
    pub count: u64,
    /// The frames that prove the finding.
    pub evidence: Vec<Exhibit>,
    pub message: String,
    pub node: Option<u8>,
    /// The object, such as `1017h:00`.
    pub object: Option<String>,
    /// The node that causes the finding, if it is not the concerned node.
    pub origin: Option<u8>,
    pub rule: Word,
    pub severity: Word,
    /// The capture that the finding is about.
    pub source: Option<String>,
    /// The time of the first occurrence.
    pub t: u64,
    pub t_last: u64,
    pub title: Word,
}

/// A case: its `id`, or its `group` and `case` if CiA's test tool has marked it.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct CaseName {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
}

/// A frame, or only a place in a capture.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Exhibit {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<u32>,
    /// The number of the line or packet.
    pub number: u64,
    /// The offset in bytes.
    pub offset: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote: Option<bool>,
    pub t: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Node {
    pub bits: u64,
    pub boot_ups: u64,
    pub channel: String,
    pub counts: ByService<u64>,
    pub emcy: Vec<Emcy>,
    pub errors: Vec<ErrorEpisode>,
    pub errors_omitted: u64,
    pub first_t: u64,
    pub frames: u64,
    pub identity: Device,
    pub last_t: u64,
    pub load_percent: Option<f64>,
    pub node: u8,
    pub peak: Option<Peak>,
    pub present: bool,
    /// Number of frames per second, by service.
    pub rates: ByService<Option<f64>>,
    pub sdo: SdoFigures,
    pub states: Vec<StateChange>,
    pub states_omitted: u64,
}

/// The EMCY messages with one error code.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Emcy {
    pub code: u16,
    pub count: u64,
    pub first_t: u64,
    pub last_t: u64,
}

/// An error from its first EMCY to its end.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ErrorEpisode {
    pub code: u16,
    pub duration_ns: Option<u64>,
    /// How the error ended: `reported` or `boot-up`.
    pub end: Option<Word>,
    pub register: Option<u8>,
    pub t: u64,
    pub t_end: Option<u64>,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SdoFigures {
    pub aborted: u64,
    pub completed: u64,
    pub response_ns: ResponseTimes,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ResponseTimes {
    pub count: u64,
    pub max: Option<u64>,
    pub min: Option<u64>,
    pub p50: Option<u64>,
    pub p95: Option<u64>,
    pub p99: Option<u64>,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct StateChange {
    pub cause: Word,
    pub state: String,
    pub t: u64,
}

impl<Findings: Serialize, Nodes: Serialize> Contract for DiagnoseResult<Findings, Nodes> {
    const SCHEMA: &'static str = SCHEMA;
    const COMMAND: &'static str = "canvass diagnose";
}
