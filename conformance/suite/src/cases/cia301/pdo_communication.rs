//! PDO communication parameters (1800h).

use crate::bench::Bench;
use crate::bench::objects::{TPDO_COB_ID, TRANSMISSION_TYPE};
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::Judged;
use canvass_analyzer::object;
use canvass_analyzer::{CobId, Multiplexer};

/// A CAN-ID that belongs to no predefined object and that CiA 301 does not restrict.
const FREE: u32 = 0x6A0;

/// The CAN-ID of a valid PDO does not change: the device refuses the write, and the COB-ID keeps its value.
#[case(id = "301/pdo/cob-id/valid", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [CobIdChangeWhileValid])]
fn valid(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(TPDO_COB_ID)?;
    let other = number(&before) & !0x7FF | FREE;
    let attempt = bench.download(TPDO_COB_ID, &other.to_le_bytes())?;
    bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
    bench.expect_unchanged(TPDO_COB_ID, &before)
}

/// The device refuses restricted CAN-IDs for PDOs and SYNC.
///
/// The case writes a sample of the 797 restricted CAN-IDs, and all of them in an exhaustive run.
#[case(id = "301/pdo/cob-id/restricted", clause = "CiA 301 7.3.5", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [RestrictedCanIdAccepted], cct = "8.10")]
fn restricted(bench: &mut Bench<'_>) -> Judged {
    let own = bench.read_number(TPDO_COB_ID)?;
    bench.write(TPDO_COB_ID, &(own | CobId::INVALID).to_le_bytes())?;
    let sample = vec![0x000_u32, 0x001, 0x07F, 0x101, 0x17F, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7FF];
    let all = || (0..=0x7FF).filter(|&id| CobId(id).is_restricted()).collect();
    bench.each(if bench.options().exhaustive { all() } else { sample }, |bench, can_id| {
        let value = own & !(0x7FF | CobId::INVALID) | can_id;
        let attempt = bench.download(TPDO_COB_ID, &value.to_le_bytes())?;
        let is_accepted = attempt.abort().is_none();
        bench.check(attempt.refused(Situation::RestrictedCanId))?;
        // A device that has accepted one CAN-ID refuses the next for another reason: the PDO is valid now.
        if is_accepted {
            bench.write(TPDO_COB_ID, &(own | CobId::INVALID).to_le_bytes())?;
        }
        Ok(())
    })?;
    let sync = Multiplexer::new(object::COB_ID_SYNC, 0);
    // A COB-ID that can't be changed at all is refused regardless of the CAN-ID.
    if !bench.can_write(sync)? {
        return Ok(());
    }
    bench.each([0x001_u32, 0x101, 0x601, 0x701], |bench, can_id| {
        let attempt = bench.download(sync, &can_id.to_le_bytes())?;
        bench.check(attempt.refused(Situation::RestrictedCanId))
    })
}

/// The reserved transmission types 241 to 251 are refused with abort 0609 0030h.
#[case(id = "301/pdo/transmission-type/reserved", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [ReservedTransmissionTypeAccepted])]
fn reserved_type(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(TRANSMISSION_TYPE)?;
    let own = bench.read_number(TPDO_COB_ID)?;
    bench.write(TPDO_COB_ID, &(own | CobId::INVALID).to_le_bytes())?;
    bench.each([241_u8, 246, 251], |bench, reserved| {
        let attempt = bench.download(TRANSMISSION_TYPE, &[reserved])?;
        bench.check(attempt.refused(Situation::TransmissionType))
    })?;
    bench.expect_unchanged(TRANSMISSION_TYPE, &before)
}
