//! Remote frames for TPDOs (CiA 301, 7.2.2.3 and 7.2.2.5.2).

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::Outcome;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{CanId, Duration, Frame};

/// Time without a TPDO before the tester requests it.
const QUIET: Duration = Duration::from_millis(300);

/// The valid TPDOs that allow remote frames: their numbers and CAN-IDs.
fn candidates(bench: &mut Bench<'_>) -> Result<Vec<(u16, u16)>, Stop> {
    let mut found = Vec::new();
    for number in 1..=4_u16 {
        let cob_id = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER + number - 1, 1);
        let Outcome::Uploaded(value) = bench.upload(cob_id)?.outcome else { continue };
        let cob_id = CobId(crate::bench::sdo::number(&value));
        let carries = bench.read_number(Multiplexer::new(object::TPDO_MAPPING_PARAMETER + number - 1, 0))? > 0;
        if carries && cob_id.is_valid() && cob_id.allows_rtr() && !cob_id.is_extended() {
            found.push((number, (cob_id.can_id() & 0x7FF) as u16));
        }
    }
    Ok(found)
}

/// A TPDO whose COB-ID allows remote frames (bit 30 is 0) is sent in answer to a remote frame in operational.
///
/// CiA recommends not to use remote frames; a device that does not answer them indicates this in bit 30.
#[case(id = "301/tpdo/remote", clause = "CiA 301 7.2.2.5.2", confidence = Cited, level = Should,
       catches = [TpdoRemoteUnanswered, SecondTpdoMissing], cct = "3.8")]
fn remote(bench: &mut Bench<'_>) -> Judged {
    let mut candidates = candidates(bench)?;
    if candidates.is_empty() && bench.unjudged(Bench::provide_tpdo)?.is_ok() {
        candidates = self::candidates(bench)?;
    }
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let mut spontaneous = Vec::new();
    bench.wait_for(QUIET, |record| {
        let is_one = candidates.iter().any(|(_, id)| record.frame.cob_id() == Some(*id));
        spontaneous.extend(is_one.then(|| record.clone()));
        None::<()>
    })?;
    let mut asked = 0;
    bench.each(candidates, |bench, (number, cob_id)| {
        if spontaneous.iter().any(|record| record.frame.cob_id() == Some(cob_id)) {
            return Ok(());
        }
        asked += 1;
        if let Some(request) = Frame::remote(CanId::standard_masked(u32::from(cob_id)), 8) {
            bench.send(&request)?;
        }
        let answer = bench.wait_for(bench.timing().silence, |record| {
            let is_answer = record.frame.cob_id() == Some(cob_id) && !record.frame.is_remote();
            is_answer.then_some(())
        })?;
        bench.check(demand(answer.is_some(), || {
            let duty = format!("the TPDO on {cob_id:03X}h, whose bit 30 is 0, answers a remote frame");
            let breach = Breach::new(Subject::Pdo { transmit: true, number }, duty).expected("the TPDO");
            breach.found(Observation::Silence)
        }))
    })?;
    if asked == 0 {
        let reason = Reason::new(
            "a TPDO allows remote frames",
            "bit 30 of 180xh:01 is 0",
            "none that is silent without a remote frame",
        );
        return Err(Stop::NotApplicable(reason));
    }
    Ok(())
}
