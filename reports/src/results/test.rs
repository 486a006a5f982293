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
    /// The bit rate in bit/s.
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
    /// Number of times that the device was told to write its non-volatile memory.
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
    /// The object dictionary before and after the run; `null` if no case has run.
    pub comparison: Option<Compared>,
    /// The number of cases by verdict.
    #[serde(default)]
    pub summary: BTreeMap<Word, usize>,
    /// What is wrong with the device: failed cases in which it did the same in the same situation show one defect.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub defects: Vec<Defect>,
    /// The timing of the tester's machine; only on a live bus, so that simulated runs give the same bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host: Option<HostTiming>,
    /// The messages of other clients; only if others used the device.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_clients: Vec<OtherClient>,
    /// The cases, in the order in which they ran.
    pub cases: Vec<Case>,
}

/// A defect of the device.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Defect {
    /// What came in the first case.
    pub reason: Option<Reason>,
    /// The cases that failed, in the order in which they ran.
    pub cases: Vec<Word>,
}

/// The timing of the tester's own machine. Each time is an upper bound: at most twice the measured time.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HostTiming {
    /// 99 % of the frames reached the tester within this time after their time on the bus.
    pub receive_p99_ns: u64,
    pub receive_max_ns: u64,
    /// 99 % of the tester's frames were on the bus within this time.
    pub transmit_p99_ns: u64,
    pub transmit_max_ns: u64,
    /// Number of frames that the machine lost.
    pub lost: u64,
    /// Number of interruptions of the bus.
    pub interruptions: u64,
    /// The duration of all interruptions together.
    #[serde(default)]
    pub interrupted_ns: u64,
    /// The fault of the adapter's time stamps; only if they can't be trusted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_stamps: Option<Word>,
}

/// Messages that other clients sent to the device or in its name.
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
    /// Whether the device is known to be as it was before the run.
    pub as_found: bool,
    /// Whether the device answered after the run.
    pub complete: bool,
    /// Number of objects that could be read.
    pub objects: usize,
    pub changes: Vec<ObjectChange>,
    /// The commands that restore the settings, in their order.
    pub commands: Vec<String>,
    /// Settings that the next start loads with another value than before the run.
    pub stored: Vec<ObjectChange>,
    pub zero_points: Vec<MovedZeroPoint>,
    /// Differences in the behaviour of the device after a start: errors, state, PDOs.
    pub behaviour: Vec<String>,
}

/// A position whose zero point has moved.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MovedZeroPoint {
    pub steps: i64,
    /// Whether the shaft may have been turned instead.
    pub uncertain: bool,
    /// Whether the moved zero point is stored, so that the next start loads it.
    pub stored: bool,
    pub text: String,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ObjectChange {
    pub index: u16,
    pub sub: u8,
    pub name: Option<String>,
    pub r#type: Option<Word>,
    /// The nature of the object: `setting`, `constant`, `own` (the device sets it) or `acting` (a write acts).
    pub nature: Word,
    /// The value before the run; `null` if it can't be read.
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
    /// The result that CiA's test tool would give: `pass` or `fail`.
    pub cct_forecast: Option<Word>,
    pub verdict: Verdict,
    pub reason: Option<Reason>,
    #[serde(default)]
    pub breaches: Vec<Breach>,
    /// The statement of the device's manual or of a waiver.
    pub documented: Option<String>,
    /// The line at which the waiver begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waiver_line: Option<usize>,
    /// The verdict of each repetition.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repetitions: Vec<Verdict>,
    /// Whether the repetitions differ.
    #[serde(default)]
    pub flaky: bool,
    /// The quarantine of the case; only if its failure does not count yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quarantine: Option<Quarantine>,
    #[serde(default)]
    pub measurements: Vec<Measurement>,
    /// Objects that the case used, where others would also have served.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uses: Vec<Use>,
    #[serde(default)]
    pub notes: Vec<String>,
    /// The messages of other clients during the case; only if others used the device.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_clients: Vec<OtherClient>,
    /// The first and the last frame of the case in the recording; only if the run was recorded.
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
    /// The unit of the value: `ns` or `count`.
    pub unit: Word,
    pub value: u64,
}

/// The quarantine of a case, whose failure does not count yet.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Quarantine {
    pub until: String,
    pub owner: String,
    #[serde(default)]
    pub reason: String,
}

/// An object that a case used.
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
    /// The subject of the breach, as a waiver names it in `object`.
    pub subject: String,
    /// The actual answer, as a waiver names it in `does`.
    pub observation: String,
    /// The situation, as a waiver names it; only if it is one of the table of allowed answers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub situation: Option<Word>,
    pub verdict: Verdict,
    pub duty: String,
    pub expected: String,
    pub actual: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t: Option<u64>,
    /// The statement that excuses the breach; only if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub documented: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waiver_line: Option<usize>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Frame {
    /// The number of the frame in the recording, from 1; only if the run was recorded.
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
    /// The cases that failed or could not be judged.
    pub fn failed(&self) -> impl Iterator<Item = &str> {
        self.verdicts().filter(|(_, kind)| kind.badness() >= Kind::Inconclusive.badness()).map(|(id, _)| id)
    }

    /// The cases with their verdicts.
    pub fn verdicts(&self) -> impl Iterator<Item = (&str, Kind)> {
        self.cases.iter().map(|case| (&*case.id, case.verdict.0))
    }

    /// The user's note with this name.
    pub fn note(&self, name: &str) -> Option<&str> {
        self.provenance.notes.get(name).map(String::as_str)
    }

    /// The identity that the device reports.
    pub fn identity(&self) -> DeviceIdentity {
        (&self.device).into()
    }
}
