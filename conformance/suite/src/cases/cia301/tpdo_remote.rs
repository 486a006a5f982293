//! Remote frames for TPDOs (CiA 301, 7.2.2.3).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::Outcome;
use canvass_traces::{CanId, Duration, Frame};

/// How long a TPDO must be quiet before it is asked for.
const QUIET: Duration = Duration::from_millis(300);

/// The COB-IDs of the TPDOs that are valid and let themselves be asked for.
fn candidates(bench: &mut Bench<'_>) -> Result<Vec<u16>, Stop> {
    let mut found = Vec::new();
    for index in 0x1800..0x1804 {
        let Outcome::Uploaded(value) = bench.upload(Multiplexer::new(index, 1))?.outcome else { continue };
        let cob_id = CobId(crate::bench::sdo::number(&value));
        if cob_id.is_valid() && cob_id.allows_rtr() && !cob_id.is_extended() {
            found.push((cob_id.can_id() & 0x7FF) as u16);
        }
    }
    Ok(found)
}

/// A TPDO whose COB-ID allows remote frames (bit 30 is 0) answers one in operational.
///
/// CiA recommends to do without remote frames; a device that does not answer them says so in bit 30.
#[case(id = "301/tpdo/remote", clause = "CiA 301 7.2.2.3", confidence = Known, level = Should,
       catches = [TpdoRemoteUnanswered, SecondTpdoMissing], cct = "3.8")]
fn remote(bench: &mut Bench<'_>) -> Judged {
    let candidates = candidates(bench)?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let spontaneous = bench.listen(QUIET)?;
    let mut asked = 0;
    for cob_id in candidates {
        if spontaneous.iter().any(|record| record.frame.cob_id() == Some(cob_id)) {
            continue;
        }
        asked += 1;
        if let Some(request) = Frame::remote(CanId::standard_masked(u32::from(cob_id)), 8) {
            bench.send(&request)?;
        }
        let answer = bench.wait_for(bench.timing().silence, |record| {
            let is_answer = record.frame.cob_id() == Some(cob_id) && !record.frame.is_remote();
            is_answer.then_some(())
        })?;
        demand(answer.is_some(), || {
            let duty = format!("the TPDO on {cob_id:03X}h, whose bit 30 is 0, answers a remote frame");
            Reason::new(duty, "the TPDO", format!("silence for {}", bench.timing().silence))
        })?;
    }
    if asked == 0 {
        let reason = Reason::new("a TPDO can be asked for", "bit 30 of 180xh:01 is 0", "none that is quiet by itself");
        return Err(Stop::NotApplicable(reason));
    }
    Ok(())
}
