//! `canvass test`.

use super::{Contract, Device, Provenance, Verdict, Word};
use canvass_suite::runner::DeviceIdentity;
use canvass_suite::verdict::Kind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The result of `canvass test`. On the simulated bus two runs give the same bytes: only `provenance` has a date.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct TestResult {
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    /// The bus as the user addressed it.
    #[serde(default)]
    pub bus: String,
    /// In bit/s.
    pub bit_rate: Option<u32>,
    #[serde(default)]
    pub node: u8,
    /// The model or description of the device.
    pub model: Option<String>,
    pub device: Device,
    #[serde(default)]
    pub seed: u64,
    /// The seed of the order of the cases, only where they ran in a random one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shuffle: Option<u64>,
    /// Whether the user ended the run before all cases had run.
    #[serde(default)]
    pub cancelled: bool,
    #[serde(default)]
    pub duration_ns: u64,
    /// How often the device was told to write its non-volatile memory.
    #[serde(default)]
    pub stores: u32,
    /// Sentences about the run as a whole.
    #[serde(default)]
    pub notices: Vec<String>,
    #[serde(default)]
    pub provenance: Provenance,
    /// The objects before the first case.
    #[serde(default)]
    pub dictionary: Vec<ObjectRead>,
    /// `null` where no case has run.
    pub comparison: Option<Compared>,
    /// The number of cases by verdict.
    #[serde(default)]
    pub summary: BTreeMap<Word, usize>,
    /// Only of a live bus, so that runs on the simulated one stay the same to the byte.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host: Option<HostTiming>,
    /// Only where others used the device.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_clients: Vec<OtherClient>,
    /// In the order in which they ran.
    pub cases: Vec<Case>,
}

/// How well the tester's own machine kept up: each time is at most twice what was measured.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HostTiming {
    /// 99 % of the frames reached the tester within this time after their time on the bus.
    pub receive_p99_ns: u64,
    pub receive_max_ns: u64,
    /// 99 % of the tester's frames were on the bus within this time.
    pub transmit_p99_ns: u64,
    pub transmit_max_ns: u64,
    /// Frames that the machine lost.
    pub lost: u64,
    /// How often the bus was interrupted.
    pub interruptions: u64,
    /// All interruptions together.
    #[serde(default)]
    pub interrupted_ns: u64,
    /// What is wrong with the time stamps of the adapter; only where they can't be trusted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_stamps: Option<Word>,
}

/// What others sent to the device or for it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct OtherClient {
    pub kind: Word,
    pub id: u16,
    pub count: u64,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ObjectRead {
    pub index: u16,
    pub sub: u8,
    pub data: String,
}

/// The object dictionary before and after the run.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Compared {
    /// Whether the device is known to be as it was.
    pub as_found: bool,
    /// Whether the device answered after the run.
    pub complete: bool,
    /// The number of objects that could be read.
    pub objects: usize,
    pub changes: Vec<ObjectChange>,
    /// What puts the settings back, in their order.
    pub commands: Vec<String>,
    /// Settings that a start brings with another value than before.
    pub stored: Vec<ObjectChange>,
    pub zero_points: Vec<MovedZeroPoint>,
    /// What the device does otherwise than before after a start: errors, state, PDOs.
    pub behaviour: Vec<String>,
}

/// A position whose zero point is not where it was.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MovedZeroPoint {
    pub steps: i64,
    /// Whether the shaft may have been turned instead.
    pub uncertain: bool,
    /// Whether the next start brings it.
    pub stored: bool,
    pub text: String,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ObjectChange {
    pub index: u16,
    pub sub: u8,
    pub name: Option<String>,
    pub r#type: Option<Word>,
    /// `setting`, `constant`, `own` of what the device sets itself, or `acting` of an object that acts when it is written.
    pub nature: Word,
    /// `null` where it can't be read.
    pub before: Option<String>,
    pub after: Option<String>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Case {
    pub id: Word,
    #[serde(default)]
    pub requirement: Word,
    #[serde(default)]
    pub clause: String,
    #[serde(default)]
    pub clause_confidence: Word,
    #[serde(default)]
    pub level: Word,
    /// The case of CiA's test tool.
    pub cct: Option<Word>,
    /// `pass` or `fail`: what CiA's tool would say.
    pub cct_forecast: Option<Word>,
    pub verdict: Verdict,
    pub reason: Option<Reason>,
    #[serde(default)]
    pub breaches: Vec<Breach>,
    /// What the device's manual or a waiver says.
    pub documented: Option<String>,
    /// Where the waiver begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waiver_line: Option<usize>,
    /// The verdict of each repetition.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repetitions: Vec<Verdict>,
    /// Whether the repetitions differ.
    #[serde(default)]
    pub flaky: bool,
    /// Only where the failure does not count yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quarantine: Option<Quarantine>,
    #[serde(default)]
    pub measurements: Vec<Measurement>,
    /// Objects that served the case where others could have.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uses: Vec<Use>,
    #[serde(default)]
    pub notes: Vec<String>,
    /// Only where others used the device meanwhile.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_clients: Vec<OtherClient>,
    /// Only where the run was recorded: the first and the last frame of the case in the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recorded: Option<[u64; 2]>,
    #[serde(default)]
    pub evidence: Vec<Frame>,
    #[serde(default)]
    pub evidence_omitted: u64,
    #[serde(default)]
    pub duration_ns: u64,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Measurement {
    pub name: String,
    /// `ns` or `count`.
    pub unit: Word,
    pub value: u64,
}

/// Why a failure does not count yet.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Quarantine {
    pub until: String,
    pub owner: String,
    #[serde(default)]
    pub reason: String,
}

/// An object that served a case.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Use {
    pub index: u16,
    pub sub: u8,
    pub purpose: Word,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Reason {
    pub duty: String,
    pub expected: String,
    pub actual: String,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Breach {
    /// What a waiver calls `object`.
    pub subject: String,
    /// What a waiver calls `does`.
    pub observation: String,
    pub verdict: Verdict,
    pub duty: String,
    pub expected: String,
    pub actual: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t: Option<u64>,
    /// Only where it is excused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub documented: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waiver_line: Option<usize>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Frame {
    /// Counted from 1, only where the run was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<u64>,
    pub t: u64,
    pub channel: String,
    pub id: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remote: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<bool>,
    /// `rx` or `tx`.
    pub direction: Word,
    pub data: String,
    pub text: String,
}

impl Contract for TestResult {
    const SCHEMA: &'static str = "canvass/test/1";
    const COMMAND: &'static str = "canvass test";
}

impl TestResult {
    /// The cases that failed, or about which nothing is known.
    pub fn failed(&self) -> impl Iterator<Item = &str> {
        self.verdicts().filter(|(_, kind)| kind.badness() >= Kind::Inconclusive.badness()).map(|(id, _)| id)
    }

    /// The cases with their verdicts.
    pub fn verdicts(&self) -> impl Iterator<Item = (&str, Kind)> {
        self.cases.iter().map(|case| (&*case.id, case.verdict.0))
    }

    /// What the user noted of the run by that name.
    pub fn note(&self, name: &str) -> Option<&str> {
        self.provenance.notes.get(name).map(String::as_str)
    }

    /// What the device said of itself.
    pub fn identity(&self) -> DeviceIdentity {
        (&self.device).into()
    }
}
