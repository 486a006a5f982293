//! Heartbeat consumer (1016h).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Verdict};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;

/// The entry that watches a node for that time.
pub const fn entry(node: u8, milliseconds: u16) -> [u8; 4] {
    ((node as u32) << 16 | milliseconds as u32).to_le_bytes()
}

/// A second entry for a node that another entry watches already is refused with abort 0604 0043h.
#[case(id = "301/heartbeat-consumer/duplicate", clause = "CiA 301 7.5.2.19", confidence = Derived, level = Must,
       needs = [HeartbeatConsumer], catches = [HeartbeatConsumerDoubleAccepted], cct = "7.104")]
fn duplicate(bench: &mut Bench<'_>) -> Judged {
    let Some(node) = bench.vacant_neighbour() else { return Ok(Verdict::Pass) };
    bench.write(Multiplexer::new(0x1016, 1), &entry(node, 500))?;
    let attempt = bench.download(Multiplexer::new(0x1016, 2), &entry(node, 1_000))?;
    if attempt.abort() == Some(AbortCode::NO_SUB_INDEX) {
        let reason = crate::verdict::Reason::new("two nodes can be watched", "1016h:02", attempt.outcome.to_string());
        return Err(Verdict::NotApplicable(reason));
    }
    attempt.expect_abort(&[AbortCode::PARAMETER_INCOMPATIBLE], &[AbortCode::GENERAL])
}
