//! `canvass selftest`.

use super::{Contract, Verdict, Word};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The result of `canvass selftest`: the cases that failed on each fault.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SelftestResult {
    /// Liberties taken together.
    pub combinations: Vec<Liberties>,
    /// Liberties on which the fuzzer found violations.
    pub fuzzed_not_spared: Vec<FuzzedLiberties>,
    /// Each liberty alone.
    pub liberties: Vec<Liberties>,
    /// Faults that a deviation of the model hides.
    pub masked: Vec<Masked>,
    /// One row for each fault.
    pub matrix: Vec<FaultRow>,
    pub missed_beside_liberties: Vec<FaultBesideLiberties>,
    /// Faults that no case finds on a device whose measured value trembles.
    pub missed_trembling: Vec<Word>,
    /// One row for each model without fault.
    pub models: Vec<ModelRow>,
    /// One row for each model without fault in each motion.
    pub motions: Vec<Motion>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    pub summary: Summary,
    /// The cases that failed on no fault.
    pub vacuous_cases: Vec<Word>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Summary {
    pub beside_deviations: usize,
    pub beside_liberties: usize,
    pub cases: usize,
    pub combinations: usize,
    pub combinations_spared: usize,
    pub detected: usize,
    pub false_alarms: usize,
    pub faults: usize,
    /// Number of firmwares that the fuzzer tried, with liberties alone and combined.
    pub fuzzed: usize,
    pub fuzzed_exchanges: u64,
    /// Number of firmwares among `fuzzed` on which the fuzzer found no violation.
    pub fuzzed_spared: usize,
    pub liberties: usize,
    pub masked: usize,
    pub missed_beside_liberties: usize,
    pub missed_trembling: usize,
    pub models: usize,
    pub motions: usize,
    /// Number of models and motions on which no case failed.
    pub motions_spared: usize,
    pub put_beside_liberties: usize,
    pub spared: usize,
    /// Number of faults that were looked for on devices whose measured value trembles.
    pub trembling: usize,
    pub vacuous_cases: usize,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FaultRow {
    pub detected: bool,
    /// The cases that failed.
    pub failed: Vec<Word>,
    pub fault: Word,
    /// Cases that name the fault and did not fail.
    pub missed: Vec<MissedCase>,
    pub model: Word,
    /// Cases that failed although they do not name the fault.
    pub unrelated: Vec<Word>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MissedCase {
    pub case: Word,
    pub verdict: Verdict,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Masked {
    pub case: Word,
    pub fault: Word,
    pub model: Word,
    pub verdict: Verdict,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FaultBesideLiberties {
    pub fault: Word,
    pub liberties: Vec<Word>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Liberties {
    /// The number of cases that were executed.
    pub executed: usize,
    pub false_alarms: Vec<FalseAlarm>,
    pub liberties: Vec<Word>,
    pub model: Word,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ModelRow {
    /// The number of cases that were executed.
    pub executed: usize,
    pub false_alarms: Vec<FalseAlarm>,
    pub model: Word,
}

/// The cases on a model whose measured value moves.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Motion {
    /// The number of cases that were executed.
    pub executed: usize,
    pub false_alarms: Vec<FalseAlarm>,
    pub model: Word,
    pub motion: Word,
    /// The position at the beginning, in steps of the physical resolution; the range ends before step 0.
    pub start: i64,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FalseAlarm {
    pub case: Word,
    pub reason: String,
    pub verdict: Verdict,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FuzzedLiberties {
    pub liberties: Vec<Word>,
    pub model: Word,
    pub violations: Vec<FuzzedViolation>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FuzzedViolation {
    pub actual: String,
    pub expected: String,
    /// The sequence as a candump log.
    pub log: String,
    pub property: Word,
    pub rule: Word,
}

impl Contract for SelftestResult {
    const SCHEMA: &'static str = "canvass/selftest/1";
    const COMMAND: &'static str = "canvass selftest";
}

/// The result of `canvass selftest --fuzz`: how fast the fuzzer finds each fault.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FuzzSelftestResult {
    pub faults: Vec<FuzzedFault>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    pub summary: FuzzSummary,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FuzzSummary {
    pub detected: usize,
    pub faults: usize,
    pub median_frames: Option<usize>,
    pub median_ns: Option<u64>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FuzzedFault {
    /// The touch that was allowed so that the fuzzer finds the fault.
    pub allow: Option<Word>,
    pub fault: Word,
    /// Whether every seed found the fault in time.
    pub good: bool,
    pub model: Word,
    pub trials: Vec<Trial>,
}

/// A trial with one seed. Members are `null` if no violation was found.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Trial {
    /// Whether the same sequence shows nothing without the fault.
    pub caused: Option<bool>,
    pub confirmed: Option<bool>,
    pub elapsed_ns: Option<u64>,
    pub exchanges: u64,
    pub frames: Option<usize>,
    pub property: Option<Word>,
    pub rule: Option<Word>,
    pub seed: u64,
}

impl Contract for FuzzSelftestResult {
    const SCHEMA: &'static str = "canvass/selftest-fuzz/1";
    const COMMAND: &'static str = "canvass selftest --fuzz";
}

/// The result of `canvass selftest --null`: which cases pass on devices that do nothing right.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct NullSelftestResult {
    pub devices: Vec<NullRow>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct NullRow {
    /// Number of cases by verdict.
    pub counts: BTreeMap<Word, usize>,
    pub device: Word,
    /// The cases that failed or could not be judged on a correct device.
    pub false_alarms: Vec<FalseAlarm>,
    /// The cases that pass, each with the reason why that is right.
    pub reviewed: Vec<ReviewedPass>,
    /// Cases of the reviewed list that do not pass.
    pub stale: Vec<String>,
    /// The cases that pass, and are not in the reviewed list.
    pub unexplained: Vec<Word>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ReviewedPass {
    pub case: Word,
    pub reason: String,
}

impl Contract for NullSelftestResult {
    const SCHEMA: &'static str = "canvass/selftest-null/1";
    const COMMAND: &'static str = "canvass selftest --null";
}

/// The result of `canvass selftest --alone`: the cases whose verdict depends on the cases before them.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct AloneSelftestResult {
    pub firmwares: Vec<AloneFirmware>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct AloneFirmware {
    /// Number of cases, each of which ran alone and in two whole runs.
    pub cases: usize,
    /// Verdicts that differ because of a defect that outlives the reset between two cases.
    pub explained: Vec<AloneDifference>,
    /// The model and its faults.
    pub firmware: String,
    /// Verdicts that differ for no known reason.
    pub unexplained: Vec<AloneDifference>,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct AloneDifference {
    pub alone: Verdict,
    pub case: Word,
    /// The defect that explains the difference.
    pub explanation: Option<String>,
    /// The reasons of both verdicts, alone and together; empty for a pass.
    pub reasons: Vec<String>,
    /// Whether the whole run had a random order.
    pub shuffled: bool,
    /// The verdict in the whole run; `null` if that ended before.
    pub together: Option<Verdict>,
}

impl Contract for AloneSelftestResult {
    const SCHEMA: &'static str = "canvass/selftest-alone/1";
    const COMMAND: &'static str = "canvass selftest --alone";
}

/// The result of `canvass selftest --wire`: which wrong fields of messages the cases find.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct WireSelftestResult {
    /// Mutants whose first failed case belongs to another service.
    pub misnamed: Vec<WireSurvivor>,
    pub primitives: Vec<WirePrimitive>,
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: Word,
    pub summary: WireCounts,
    /// Mutants that changed the traffic and failed no case.
    pub survivors: Vec<WireSurvivor>,
    /// Messages that no model sends in any case.
    pub unsent: Vec<String>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct WireCounts {
    /// Number of mutants that changed a frame.
    pub changed: usize,
    /// Number of mutants on which a case failed.
    pub found: usize,
    /// Number of mutants on which no case failed, but some cases were inconclusive.
    pub inconclusive: usize,
    pub made: usize,
    /// Number of mutants whose first failed case belongs to their own service.
    pub named: usize,
    /// Number of mutants on which no case has to fail, as the standard leaves the change open.
    pub open: usize,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct WirePrimitive {
    #[serde(flatten)]
    pub counts: WireCounts,
    pub primitive: String,
}

#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct WireSurvivor {
    pub breach: Option<String>,
    /// The first case that failed, or that could not be judged.
    pub case: Option<Word>,
    pub model: Word,
    pub mutant: String,
}

impl Contract for WireSelftestResult {
    const SCHEMA: &'static str = "canvass/selftest-wire/1";
    const COMMAND: &'static str = "canvass selftest --wire";
}
