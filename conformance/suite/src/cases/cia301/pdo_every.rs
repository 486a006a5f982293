//! Rules for a single PDO hold for every PDO in the description.

use crate::bench::Bench;
use crate::bench::pdo::{Pdo, RPDO, TPDO};
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop, tried};
use canvass_analyzer::CobId;

/// A CAN-ID that no predefined object has and CiA 301 does not restrict.
const FREE: u32 = 0x6A0;
/// Maximum number of PDOs in each direction.
const MOST: u16 = 512;

/// The PDOs whose COB-ID is writable according to the description, each with its current COB-ID.
fn writable_pdos(bench: &mut Bench<'_>) -> Result<Vec<(Pdo, CobId)>, Stop> {
    let mut found = Vec::new();
    for pdo in (1..=MOST).flat_map(|number| [RPDO.numbered(number), TPDO.numbered(number)]) {
        let is_there = bench.described(pdo.parameter(1)) == Some(true);
        if is_there && bench.can_write(pdo.parameter(1))? {
            found.push((pdo, bench.pdo_cob_id(pdo)?));
        }
    }
    Ok(found)
}

/// The PDOs with a writable COB-ID that are valid.
fn valid_pdos(bench: &mut Bench<'_>) -> Result<Vec<Pdo>, Stop> {
    let is_valid = |(pdo, cob_id): (Pdo, CobId)| cob_id.is_valid().then_some(pdo);
    let found: Vec<Pdo> = writable_pdos(bench)?.into_iter().filter_map(is_valid).collect();
    match found.is_empty() {
        true => {
            let reason = Reason::new("a PDO is valid and can be changed", "one in the description", "none");
            Err(Stop::NotApplicable(reason))
        }
        false => Ok(found),
    }
}

/// The CAN-IDs of all valid PDOs do not change: the device refuses each write, and the COB-IDs keep their values.
#[case(id = "301/pdo/cob-id/every-valid", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Description], catches = [CobIdChangeWhileValid, PdoRulesFirstOnly])]
fn every_cob_id(bench: &mut Bench<'_>) -> Judged {
    let pdos = valid_pdos(bench)?;
    bench.each(pdos, |bench, pdo| {
        let at = pdo.parameter(1);
        let before = bench.read(at)?;
        let attempt = bench.download(at, &(number(&before) & !0x7FF | FREE).to_le_bytes())?;
        bench.check(attempt.refused(Situation::ValidCobIdChanged))?;
        bench.expect_unchanged(at, &before)
    })
}

/// The mappings of all valid PDOs do not change.
///
/// CiA 301 prescribes the order in which a PDO is remapped; the device decides which out-of-order step it refuses.
#[case(id = "301/pdo/mapping/every-valid", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Should,
       needs = [Description], catches = [MappingChangeWhileValid, PdoRulesFirstOnly])]
fn every_mapping(bench: &mut Bench<'_>) -> Judged {
    let pdos = valid_pdos(bench)?;
    bench.each(pdos, |bench, pdo| {
        let at = pdo.entry(0);
        if !bench.can_write(at)? {
            return Ok(());
        }
        let before = bench.read(at)?;
        let other = if number(&before) == 0 { 1 } else { 0 };
        let attempt = bench.download(at, &[other])?;
        bench.check(attempt.refused(Situation::MappingInUseChanged))?;
        bench.expect_unchanged(at, &before)
    })
}

/// Inhibit time, event timer and SYNC start value of a TPDO can be changed while the TPDO is switched off, and read
/// back as written. The case tries each of them that the description calls writable, within the limits of the
/// description.
#[case(id = "301/pdo/parameters-while-off", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Must,
       needs = [Description], catches = [PdoTimesRefused])]
fn parameters_while_off(bench: &mut Bench<'_>) -> Judged {
    let is_tpdo = |(pdo, _): &(Pdo, CobId)| pdo.communication >= TPDO.communication;
    let pdos: Vec<_> = writable_pdos(bench)?.into_iter().filter(is_tpdo).collect();
    if pdos.is_empty() {
        let reason = Reason::new("a TPDO can be switched off", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let mut off = 0;
    bench.each(pdos, |bench, (pdo, own)| {
        if bench.download(pdo.parameter(1), &(own.0 | CobId::INVALID).to_le_bytes())?.abort().is_some() {
            return Ok(());
        }
        off += 1;
        bench.each([(3, 1_000_u16), (5, 500), (6, 1), (6, 240)], |bench, (sub, value)| {
            let at = pdo.parameter(sub);
            if bench.described(at) != Some(true) || !bench.can_write(at)? || !bench.is_within_limits(at, value.into()) {
                return Ok(());
            }
            let value: Vec<u8> = value.to_le_bytes().into_iter().take(if sub == 6 { 1 } else { 2 }).collect();
            let before = bench.read(at)?;
            bench.download(at, &value)?.under("while the PDO is off").refused(Situation::Confirmed)?;
            bench.expect_unchanged(at, &value)?;
            bench.download(at, &before).map(|_| ())
        })?;
        bench.download(pdo.parameter(1), &own.0.to_le_bytes()).map(|_| ())
    })?;
    tried(off, "a TPDO that can be switched off")
}
