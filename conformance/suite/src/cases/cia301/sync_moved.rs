//! SYNC with another CAN-ID in 1005h (CiA 301, 7.5.2.5).

use super::sync::{COB_ID, PRODUCES};
use super::sync_window::{count, counted, synchronous};
use crate::bench::Bench;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;

/// A CAN-ID outside the predefined connection set.
const FREE: u32 = 0x6B8;

/// With another CAN-ID in 1005h a synchronous TPDO follows SYNC with the new CAN-ID, and no longer SYNC with the old
/// one. After reset communication it follows SYNC with the CAN-ID that 1005h then holds.
#[case(id = "301/sync/moved", clause = "CiA 301 7.5.2.5", confidence = Cited, level = Must,
       needs = [Tpdo, Sync, DynamicMapping], catches = [SyncKeepsCanId])]
fn moved(bench: &mut Bench<'_>) -> Judged {
    if !bench.can_write(COB_ID)? {
        let reason = Reason::new("the CAN-ID of SYNC can be changed", COB_ID.to_string(), "absent or read-only");
        return Err(Stop::NotApplicable(reason));
    }
    bench.stop_sync_period()?;
    let own = bench.read_number(COB_ID)?;
    let old = (own & 0x7FF) as u16;
    if own & PRODUCES != 0 {
        bench.write(COB_ID, &(own & !PRODUCES).to_le_bytes())?;
    }
    let moved = own & !PRODUCES & !0x7FF | FREE;
    bench.write(COB_ID, &moved.to_le_bytes())?;
    let read = bench.read_number(COB_ID)?;
    bench.check(demand(read & 0x1FFF_FFFF == FREE, || {
        let breach = Breach::new(COB_ID, "1005h reads back the CAN-ID that was written");
        breach.expected(Observation::Number(moved.into())).found(Observation::Number(read.into()))
    }))?;
    follows(bench, FREE as u16, old)?;
    bench.reset(Command::RESET_COMMUNICATION)?;
    bench.stop_sync_period()?;
    if bench.read_number(TPDO.entry(0))? == 0 || !bench.pdo_cob_id(TPDO)?.is_valid() {
        // As delivered the device sends no TPDO that would show which SYNC it uses.
        return Ok(());
    }
    let now = bench.sync_id()?;
    follows(bench, now, if u32::from(now) == FREE { old } else { FREE as u16 })
}

/// Requires that TPDO 1 of type 1 follows SYNC with one CAN-ID, and not with the other.
fn follows(bench: &mut Bench<'_>, right: u16, wrong: u16) -> Judged {
    let tpdo = synchronous(bench)?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    bench.drain()?;
    bench.send_bytes(wrong, &[])?;
    let heard = bench.frames_of(tpdo, bench.shortly())?;
    let there = count(&heard, tpdo);
    bench.check(demand(there == 0, || {
        counted("a TPDO of type 1 follows no SYNC with another CAN-ID than that of 1005h", 0, there)
    }))?;
    bench.send_bytes(right, &[])?;
    let heard = bench.frames_of(tpdo, bench.shortly())?;
    let there = count(&heard, tpdo);
    bench.check(demand(there == 1, || counted("a TPDO of type 1 follows SYNC with the CAN-ID of 1005h", 1, there)))?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    Ok(())
}
