//! The JSON Schemas of all results, made from their types.

use super::{
    AloneSelftestResult, CompareResult, Contract, DecodeLine, DiagnoseResult, EdsCheckResult, FuzzResult,
    FuzzSelftestResult, HistoryResult, NullSelftestResult, QualityResult, SelftestResult, TestResult,
    WireSelftestResult,
};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

/// The schema of each result, with the name and version of its contract. A member that is always written is required.
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        of::<AloneSelftestResult>(),
        of::<CompareResult>(),
        of::<DecodeLine>(),
        of::<DiagnoseResult>(),
        of::<EdsCheckResult>(),
        of::<FuzzResult>(),
        of::<FuzzSelftestResult>(),
        of::<HistoryResult>(),
        of::<NullSelftestResult>(),
        of::<QualityResult>(),
        of::<SelftestResult>(),
        of::<TestResult>(),
        of::<WireSelftestResult>(),
    ]
}

/// The file name of a contract's schema: `test-1.json` for `canvass/test/1`.
pub fn file_name(contract: &str) -> String {
    format!("{}.json", contract.trim_start_matches("canvass/").replace('/', "-"))
}

fn of<T: Contract + JsonSchema>() -> (&'static str, Schema) {
    (T::SCHEMA, SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>())
}
