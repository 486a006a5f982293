//! Node guarding (CiA 301, 7.2.8.3.2.1).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl};
use canvass_traces::{CanId, Frame};

/// The answers to guarding requests alternate in bit 7, which is 0 in the first answer after a reset.
#[case(id = "301/guarding/toggle", clause = "CiA 301 7.2.8.3.2.1", confidence = Attested, level = Must,
       needs = [Guarding], catches = [GuardingToggleStuck], cct = "7.3")]
fn toggle(bench: &mut Bench<'_>) -> Judged {
    let cob_id = error_control::CAN_ID_BASE + u16::from(bench.node().raw());
    let mut toggles = Vec::new();
    for _ in 0..5 {
        bench.drain()?;
        if let Some(request) = Frame::remote(CanId::standard_masked(u32::from(cob_id)), 1) {
            bench.send(&request)?;
        }
        let answer = bench.wait_for(bench.timing().silence, |record| {
            let is_ours = record.frame.cob_id() == Some(cob_id);
            is_ours.then(|| ErrorControl::read(record.frame.data()).ok()).flatten()
        })?;
        toggles.push(answer.map_or('-', |answer| if answer.toggle { '1' } else { '0' }));
    }
    let toggles: String = toggles.into_iter().collect();
    demand(toggles == "01010", || Reason::new("the toggle bit of five answers alternates from 0", "01010", toggles))
}
