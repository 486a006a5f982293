//! A violation as a Rust test, for the tests of a firmware or of a stack.

use super::log;
use crate::campaign::Found;
use canvass_analyzer::NodeId;
use std::fmt::Write;

/// A file for the `tests` folder of a crate that depends on `canvass-conformance`. The test fails as long as the device
/// shows the violation. It uses the bus of the run, or the bus in the environment variable `CANVASS_BUS`.
pub fn rust_test(found: &Found, bus: &str, node: NodeId, seed: u64) -> String {
    let violation = &found.violation;
    let (property, rule) = (violation.property, violation.rule);
    let log = log(found).lines().fold(String::new(), |mut lines, line| {
        // Writing to a string can't fail.
        let _ = writeln!(lines, "{line}");
        lines
    });
    let version = env!("CARGO_PKG_VERSION");
    let words = |text: &str| text.replace(['\n', '\r'], " ");
    format!(
        r##"//! {property}: {title} ({rule}).
//!
//! Expected: {expected}
//! Found: {actual}
//! By canvass {version} with seed {seed}.

use canvass_fuzzer::reproducer::replay;

const LOG: &str = "\
{log}";

#[test]
fn {name}() {{
    let bus = std::env::var("CANVASS_BUS").unwrap_or_else(|_| {bus:?}.to_owned());
    let node = canvass_analyzer::NodeId::new({node});
    let violation = replay(&bus, node, None, LOG.as_bytes()).unwrap();
    assert!(violation.is_none(), "{{violation:#?}}");
}}
"##,
        title = property.title(),
        expected = words(&violation.expected),
        actual = words(&violation.actual),
        name = identifier(&format!("{property} {rule}")),
        node = node.raw(),
    )
}

/// A text as an identifier: `PROP-02 initiate upload` becomes `prop_02_initiate_upload`.
pub(super) fn identifier(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect()
}
