//! Accepted mappings and their effects (1600h, 1A00h).

use super::pdo_mapping::refused;
use crate::bench::Bench;
use crate::bench::pdo::{Mapped, Pdo, RPDO, TPDO};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// Each default mapping entry names an object that exists, can be mapped and has the given length, and the entries fit
/// into 8 bytes.
#[case(id = "301/pdo/mapping/default", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Tpdo, Description], catches = [DefaultMappingWrong], cct = "3.21")]
fn default(bench: &mut Bench<'_>) -> Judged {
    let pdos = (1..=4_u16).flat_map(|number| [TPDO.numbered(number), RPDO.numbered(number)]);
    bench.each(pdos, |bench, pdo| {
        // FEh and FFh are multiplex PDOs, which map nothing.
        let maps = bench.has(pdo.entry(0))? && bench.read_number(pdo.entry(0))? <= 64;
        if maps { well_mapped(bench, pdo) } else { Ok(()) }
    })
}

fn well_mapped(bench: &mut Bench<'_>, pdo: Pdo) -> Judged {
    let mapping = bench.mapping(pdo)?;
    let bits: u32 = mapping.iter().map(|mapped| u32::from(mapped.bits)).sum();
    bench.check(demand(bits <= 64, || {
        let breach = Breach::new(pdo.entry(0), "the objects of a PDO fit into a frame").expected("64 bits at most");
        breach.found(Observation::Number(u64::from(bits)))
    }))?;
    let entries = (1..=u8::MAX).zip(mapping).filter(|(_, mapped)| mapped.at.index.0 >= 0x20);
    bench.each(entries, |bench, (sub, mapped)| {
        let described = bench.target().description.as_ref();
        let entry = described.and_then(|description| description.dictionary.entry(mapped.at).ok());
        let found = match entry {
            None => Observation::named("an object that is missing in the description"),
            Some(entry) if !entry.pdo_mappable => Observation::named("an object that is not PDO-mappable"),
            Some(entry) if entry.data_type.bits().is_some_and(|bits| bits != u32::from(mapped.bits)) => {
                Observation::Number(u64::from(mapped.bits))
            }
            Some(_) => return Ok(()),
        };
        let duty = format!("{} is PDO-mappable, and mapped with its length in bits", mapped.at);
        let expected = entry.and_then(|entry| entry.data_type.bits()).map(|bits| Observation::Number(u64::from(bits)));
        let breach = Breach::new(pdo.entry(sub), duty).expected("a PDO-mappable object").found(found);
        let breach = expected.into_iter().fold(breach, Breach::expected);
        bench.check(Err(Box::new(breach)))
    })
}

/// The current mapping of a PDO can be written again in the five steps of CiA 301. A PDO that maps nothing as delivered
/// accepts an object that the description allows in it.
#[case(id = "301/pdo/mapping/procedure", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [DynamicMapping], catches = [MappingProcedureRefused, SameCobIdRefused, PdoOffRefused], cct = "3.22")]
fn procedure(bench: &mut Bench<'_>) -> Judged {
    let mut before = bench.mapping(TPDO)?;
    if before.is_empty() {
        before.extend(bench.tpdo_candidate());
        bench.require_one(TPDO, &before)?;
    }
    let own = bench.pdo_cob_id(TPDO)?;
    bench.remap(TPDO, &before, own)?;
    if !own.is_valid() {
        // A PDO that is delivered off is on now, so only the second procedure switches it off.
        bench.remap(TPDO, &before, own)?;
    }
    let after = bench.mapping(TPDO)?;
    bench.check(demand(after.len() == before.len(), || {
        let breach = Breach::new(TPDO.entry(0), "the mapping has the number of entries that was written");
        breach.expected(Observation::Number(before.len() as u64)).found(Observation::Number(after.len() as u64))
    }))?;
    bench.each((1..=u8::MAX).zip(before.into_iter().zip(after)), |bench, (sub, (written, now))| {
        bench.check(demand(written == now, || {
            let value = |mapped: Mapped| Observation::Value(mapped.entry().to_le_bytes().to_vec());
            let breach = Breach::new(TPDO.entry(sub), "the mapping reads back as written");
            breach.expected(value(written)).found(value(now))
        }))
    })
}

/// A TPDO carries its objects in the order of its mapping, from the first one after a start on.
#[case(id = "301/pdo/mapping/layout", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Changeable], catches = [TpdoBytesReversed])]
fn layout(bench: &mut Bench<'_>) -> Judged {
    let (changeable, other) = bench.changeable()?;
    let second = bench
        .tpdo_objects()
        .into_iter()
        .find(|mapped| mapped.at != changeable.at && u32::from(mapped.bits) + u32::from(changeable.bits) <= 64);
    let Some(second) = second else {
        let reason = Reason::new("a TPDO can carry two objects", "two in the description", "one");
        return Err(Stop::NotApplicable(reason));
    };
    bench.set_mapping(TPDO, &[second, changeable])?;
    let has_timer = bench.has(TPDO.parameter(5))?;
    match has_timer {
        true => bench.set_pdo(TPDO, &[(2, &[255]), (3, &[0, 0]), (5, &100_u16.to_le_bytes())])?,
        false => {
            bench.expect_plain_sync()?;
            bench.set_pdo(TPDO, &[(2, &[1])])?;
        }
    }
    bench.write(changeable.at, &other)?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    let sync_id = bench.sync_id()?;
    // The application may take over the value a little later.
    bench.listen(bench.timing().reaction)?;
    let begun = bench.now();
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    if !has_timer {
        bench.send_bytes(sync_id, &[])?;
    }
    let mut heard = bench.heard_since(begun);
    heard.retain(|record| record.frame.cob_id() == Some(can_id));
    heard.extend(bench.frames_of(can_id, Duration::from_millis(300))?);
    if heard.is_empty() {
        let reason = Reason::new("TPDO 1 is sent", "one every 100 ms, or with SYNC", "none in 300 ms");
        return Err(Stop::Inconclusive(reason));
    }
    let length = usize::from((second.bits + changeable.bits) / 8);
    let is_right = |data: &[u8]| data.len() == length && data.get(usize::from(second.bits / 8)..) == Some(&other[..]);
    let wrong = heard.iter().find(|record| !is_right(record.data()));
    bench.check(wrong.map_or(Ok(()), |wrong| {
        let duty = format!("{} follows {} in each TPDO 1, as mapped", changeable.at, second.at);
        let expected = format!("{length} bytes that end in {}", Bytes(&other));
        let found = Observation::Value(wrong.data().to_vec());
        Err(Box::new(Breach::new(TPDO.subject(), duty).expected(expected).found(found)))
    }))
}

/// A mapping entry can't be changed while sub-index 0 counts it.
///
/// CiA 301 prescribes the order in which a PDO is remapped; the device decides which out-of-order step it refuses.
#[case(id = "301/pdo/mapping/entry-in-use", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Should,
       needs = [Tpdo, DynamicMapping], catches = [MappingChangeWhileValid], cct = "3.23")]
fn entry_in_use(bench: &mut Bench<'_>) -> Judged {
    bench.require_mapped(TPDO)?;
    bench.pdo_off(TPDO)?;
    let before = bench.read(TPDO.entry(1))?;
    let attempt = bench.download(TPDO.entry(1), &0_u32.to_le_bytes())?;
    bench.check(attempt.refused(Situation::MappingInUseChanged))?;
    bench.expect_unchanged(TPDO.entry(1), &before)
}

/// The device refuses the reserved numbers of mapped objects, 65 to 253, with abort 0602 0000h or 0604 0042h.
#[case(id = "301/pdo/mapping/count", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MappingCountUnchecked], cct = "3.25")]
fn count(bench: &mut Bench<'_>) -> Judged {
    bench.open_mapping(TPDO)?;
    bench.each([65_u8, 128, 253], |bench, wrong| {
        let attempt = bench.download(TPDO.entry(0), &[wrong])?;
        bench.check(attempt.refused(Situation::MappingCount))
    })
}

/// Mapping an object that does not exist is refused with abort 0602 0000h or 0604 0041h.
#[case(id = "301/pdo/mapping/missing", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MissingObjectMapped, SdoNoObjectSilent],
       answers = [MappingRefused])]
fn missing(bench: &mut Bench<'_>) -> Judged {
    refused(bench, TPDO, 0xFFFF_0020, Situation::Unmappable)
}

/// Mapping a sub-index that does not exist is refused with abort 0602 0000h or 0604 0041h.
#[case(id = "301/pdo/mapping/missing-sub-index", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MissingObjectMapped, SdoNoObjectSilent],
       answers = [MappingRefused])]
fn missing_sub_index(bench: &mut Bench<'_>) -> Judged {
    let before = bench.mapping(TPDO)?;
    let Some(first) = before.first() else {
        let reason = Reason::new("TPDO 1 maps an object", "one", "none");
        return Err(Stop::Inconclusive(reason));
    };
    let entry = u32::from(first.at.index.0) << 16 | 0xFD00 | u32::from(first.bits);
    refused(bench, TPDO, entry, Situation::UnmappableEntry)
}

/// Mapping a dummy entry, which fills a gap in an RPDO, into a TPDO is refused with abort 0602 0000h or 0604 0041h.
///
/// CiA 301 describes dummy entries for RPDOs only.
#[case(id = "301/pdo/mapping/dummy-in-tpdo", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Should,
       needs = [Tpdo, DynamicMapping], catches = [DummyMappedIntoTpdo],
       answers = [MappingRefused])]
fn dummy_in_tpdo(bench: &mut Bench<'_>) -> Judged {
    refused(bench, TPDO, 0x0005_0008, Situation::Unmappable)
}

/// An RPDO accepts the dummy entries that the description allows, and refuses all others.
#[case(id = "301/pdo/mapping/dummy-in-rpdo", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Should,
       needs = [RpdoMapping, Description], catches = [DummyRefused], cct = "3.33",
       answers = [MappingRefused])]
fn dummy_in_rpdo(bench: &mut Bench<'_>) -> Judged {
    let usage = bench.target().description.as_ref().map(|description| description.dummy_usage.clone());
    let lengths = [(0x0002_u16, 8_u32), (0x0003, 16), (0x0004, 32), (0x0005, 8), (0x0006, 16), (0x0007, 32)];
    bench.each(lengths, |bench, (index, bits)| {
        let allowed = usage.as_ref().and_then(|usage| usage.get(&index)).copied().unwrap_or(false);
        let entry = u32::from(index) << 16 | bits;
        if !allowed {
            return refused(bench, RPDO, entry, Situation::Unmappable);
        }
        bench.open_mapping(RPDO)?;
        bench.download(RPDO.entry(1), &entry.to_le_bytes())?.expect_confirmation()?;
        bench.download(RPDO.entry(0), &[1])?.expect_confirmation()?;
        Ok(())
    })
}

/// An object that the description excludes from PDOs can't be mapped into an RPDO, even if SDO downloads can write it.
#[case(id = "301/pdo/mapping/unmappable-in-rpdo", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Must,
       needs = [RpdoMapping, Description], catches = [UnmappableObjectMapped], answers = [MappingRefused])]
fn unmappable_in_rpdo(bench: &mut Bench<'_>) -> Judged {
    let entries = bench.target().description.iter().flat_map(|description| description.dictionary.entries());
    // Commands are left out: a device that accepts the entry would obey the PDO.
    let is_command = |at: Multiplexer| {
        matches!(
            at.index.0,
            object::PREDEFINED_ERROR_FIELD | object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS
        )
    };
    let mut unmappable =
        entries.filter(|(at, entry)| entry.access.is_writable() && !entry.pdo_mappable && !is_command(*at));
    let found = unmappable.find_map(|(at, entry)| {
        let bits = entry.data_type.bits().filter(|bits| [8, 16, 32].contains(bits))?;
        Some(u32::from(at.index.0) << 16 | u32::from(at.sub.0) << 8 | bits)
    });
    match found {
        Some(entry) => refused(bench, RPDO, entry, Situation::Unmappable),
        None => {
            let reason =
                Reason::new("the description has a writable object that can't be mapped", "at least one", "none");
            Err(Stop::NotApplicable(reason))
        }
    }
}

/// Mapping a read-only object into an RPDO is refused with abort 0602 0000h or 0604 0041h.
#[case(id = "301/pdo/mapping/read-only-in-rpdo", clause = "CiA 301 7.5.1", confidence = Cited, level = Must,
       needs = [RpdoMapping], catches = [MappingDirectionUnchecked], cct = "3.28",
       answers = [MappingRefused])]
fn read_only_in_rpdo(bench: &mut Bench<'_>) -> Judged {
    let candidates: Vec<Mapped> = bench.tpdo_objects();
    let writable = bench.rpdo_objects();
    let Some(object) = candidates.into_iter().find(|mapped| !writable.contains(mapped)) else {
        let reason = Reason::new("an object is for TPDOs only", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    };
    refused(bench, RPDO, object.entry(), Situation::WrongDirection)
}

/// Mapping an object that is for RPDOs only into a TPDO is refused with abort 0602 0000h or 0604 0041h.
#[case(id = "301/pdo/mapping/rpdo-object-in-tpdo", clause = "CiA 301 7.5.1", confidence = Cited, level = Must,
       needs = [RpdoMapping, DynamicMapping], catches = [MappingDirectionUnchecked], cct = "3.31",
       answers = [MappingRefused])]
fn rpdo_object_in_tpdo(bench: &mut Bench<'_>) -> Judged {
    let readable = bench.tpdo_objects();
    let Some(object) = bench.rpdo_objects().into_iter().find(|mapped| !readable.contains(mapped)) else {
        let reason = Reason::new("an object is for RPDOs only", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    };
    refused(bench, TPDO, object.entry(), Situation::WrongDirection)
}

/// Every object that the description allows in a TPDO can be mapped.
#[case(id = "301/pdo/mapping/every-tpdo-object", clause = "CiA 301 7.5.2.38", confidence = Cited, level = Must,
       needs = [Tpdo, DynamicMapping, Description], catches = [MappingProcedureRefused], cct = "3.30")]
fn every_tpdo_object(bench: &mut Bench<'_>) -> Judged {
    let objects = bench.tpdo_objects();
    every_object(bench, TPDO, &objects)
}

/// Every object that the description allows in an RPDO can be mapped.
#[case(id = "301/pdo/mapping/every-rpdo-object", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Must,
       needs = [RpdoMapping, Description], catches = [MappingProcedureRefused], cct = "3.27")]
fn every_rpdo_object(bench: &mut Bench<'_>) -> Judged {
    let objects = bench.rpdo_objects();
    every_object(bench, RPDO, &objects)
}

fn every_object(bench: &mut Bench<'_>, pdo: Pdo, objects: &[Mapped]) -> Judged {
    let granularity = bench.target().description.as_ref().map_or(0, |description| description.device.granularity);
    let objects = objects.iter().filter(|mapped| mapped.bits >= granularity);
    bench.open_mapping(pdo)?;
    bench.each(objects, |bench, mapped| {
        let entry = mapped.entry().to_le_bytes();
        for (at, value) in [(pdo.entry(1), &entry[..]), (pdo.entry(0), &[1]), (pdo.entry(0), &[0])] {
            let mut attempt = bench.download(at, value)?;
            // The breach names the mapped object, so that an excuse for one object does not cover the others.
            attempt.multiplexer = mapped.at;
            attempt.what = format!("mapping of {}, which the description allows,", mapped.at);
            attempt.expect_confirmation()?;
        }
        Ok(())
    })
}

/// The mapping of a valid RPDO can't be changed, and keeps its value.
///
/// CiA 301 prescribes the order in which a PDO is remapped; the device decides which out-of-order step it refuses.
#[case(id = "301/rpdo/mapping/valid", clause = "CiA 301 7.5.2.36", confidence = Cited, level = Should,
       needs = [RpdoMapping], catches = [MappingChangeWhileValid], cct = "3.24")]
fn rpdo_valid(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(RPDO.entry(0))?;
    let CobId(own) = bench.pdo_cob_id(RPDO)?;
    if own & CobId::INVALID != 0 {
        bench.pdo_on(RPDO, CobId(own))?;
    }
    let attempt = bench.download(RPDO.entry(0), &[0])?;
    bench.check(attempt.refused(Situation::MappingInUseChanged))?;
    bench.expect_unchanged(RPDO.entry(0), &before)
}
