//! Which mappings are accepted, and what they do (1600h, 1A00h).

use crate::bench::Bench;
use crate::bench::pdo::{Mapped, Pdo, RPDO, TPDO};
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::sdo::Bytes;
use canvass_traces::Duration;

/// Codes for a mapping that may not be changed now.
const NOT_NOW: [AbortCode; 4] =
    [AbortCode::UNSUPPORTED_ACCESS, AbortCode::NOT_MAPPABLE, AbortCode::INVALID_VALUE, AbortCode::DEVICE_STATE];

/// Writes an entry into an open mapping and switches it on: one of both must be refused with one of the codes.
fn refused(bench: &mut Bench<'_>, pdo: Pdo, entry: u32, strict: &[AbortCode], tolerated: &[AbortCode]) -> Judged {
    bench.open_mapping(pdo)?;
    let attempt = bench.download(pdo.entry(1), &entry.to_le_bytes())?;
    if attempt.abort().is_some() {
        return bench.check(attempt.refused_with(strict, tolerated));
    }
    // Some check the entries only when the mapping is switched on.
    let mut attempt = bench.download(pdo.entry(0), &[1])?;
    attempt.what = format!("mapping of {entry:08X}h");
    bench.check(attempt.refused_with(strict, tolerated))
}

/// The mapping as delivered names objects that exist, are for PDOs, have the length that it says, and fit into 8 bytes.
#[case(id = "301/pdo/mapping/default", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, Description], catches = [DefaultMappingWrong], cct = "3.21")]
fn default(bench: &mut Bench<'_>) -> Judged {
    for number in 1..=4_u16 {
        for pdo in [TPDO.numbered(number), RPDO.numbered(number)] {
            if bench.has(pdo.entry(0))? {
                well_mapped(bench, pdo)?;
            }
        }
    }
    Ok(())
}

fn well_mapped(bench: &mut Bench<'_>, pdo: Pdo) -> Judged {
    let mapping = bench.mapping(pdo)?;
    let bits: u32 = mapping.iter().map(|mapped| u32::from(mapped.bits)).sum();
    demand(bits <= 64, || {
        Reason::new(
            format!("{:04X}h maps what a frame can hold", pdo.mapping),
            "64 bits at most",
            format!("{bits} bits"),
        )
    })?;
    for mapped in mapping.into_iter().filter(|mapped| mapped.at.index.0 >= 0x20) {
        let described = bench.target().description.as_ref();
        let entry = described.and_then(|description| description.dictionary.entry(mapped.at).ok());
        let actual = match entry {
            None => Some("an object that the description does not name".to_owned()),
            Some(entry) if !entry.pdo_mappable => Some("an object that is not for PDOs".to_owned()),
            Some(entry) if entry.data_type.bits().is_some_and(|bits| bits != u32::from(mapped.bits)) => {
                Some(format!("{} bits of {}", mapped.bits, entry.data_type))
            }
            Some(_) => None,
        };
        demand(actual.is_none(), || {
            let duty = format!("{:04X}h maps {} as described", pdo.mapping, mapped.at);
            Reason::new(duty, "an object for PDOs with its length", actual.unwrap_or_default())
        })?;
    }
    Ok(())
}

/// The mapping that a PDO has can be written again, in the five steps of CiA 301.
#[case(id = "301/pdo/mapping/procedure", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MappingProcedureRefused], cct = "3.22")]
fn procedure(bench: &mut Bench<'_>) -> Judged {
    let before = bench.mapping(TPDO)?;
    let own = bench.pdo_cob_id(TPDO)?;
    let steps: Vec<(Multiplexer, Vec<u8>)> =
        std::iter::once((TPDO.parameter(1), (own.0 | 1 << 31).to_le_bytes().to_vec()))
            .chain([(TPDO.entry(0), vec![0])])
            .chain(
                (1..=u8::MAX)
                    .zip(&before)
                    .map(|(sub, mapped)| (TPDO.entry(sub), mapped.entry().to_le_bytes().to_vec())),
            )
            .chain([(TPDO.entry(0), vec![u8::try_from(before.len()).unwrap_or(u8::MAX)])])
            .chain([(TPDO.parameter(1), own.0.to_le_bytes().to_vec())])
            .collect();
    for (multiplexer, value) in steps {
        bench.download(multiplexer, &value)?.expect_confirmation()?;
    }
    let after = bench.mapping(TPDO)?;
    bench.check(demand(after == before, || {
        Reason::new("the mapping is as it was written", format!("{before:?}"), format!("{after:?}"))
    }))
}

/// A TPDO carries its objects in the order of its mapping.
#[case(id = "301/pdo/mapping/layout", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
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
        true => bench.set_pdo(TPDO, &[(2, &[255]), (5, &100_u16.to_le_bytes())])?,
        false => bench.set_pdo(TPDO, &[(2, &[1])])?,
    }
    bench.write(changeable.at, &other)?;
    let can_id = (bench.pdo_cob_id(TPDO)?.can_id() & 0x7FF) as u16;
    let sync_id = bench.sync_id()?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    if !has_timer {
        bench.send_bytes(sync_id, &[])?;
    }
    let heard = bench.frames_of(can_id, Duration::from_millis(300))?;
    let length = usize::from((second.bits + changeable.bits) / 8);
    let Some(last) = heard.last() else {
        let reason = Reason::new("TPDO 1 is sent", "one every 100 ms, or with SYNC", "none in 300 ms");
        return Err(Stop::Inconclusive(reason));
    };
    let found = last.data().get(usize::from(second.bits / 8)..).unwrap_or_default();
    bench.check(demand(last.data().len() == length && found == other, || {
        let duty = format!("{} comes behind {}, as mapped", changeable.at, second.at);
        let expected = format!("{length} bytes that end in {}", Bytes(&other));
        Reason::new(duty, expected, Bytes(last.data()).to_string())
    }))
}

/// The entries of a mapping can't be changed while sub-index 0 counts them.
#[case(id = "301/pdo/mapping/entry-in-use", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MappingChangeWhileValid], cct = "3.23")]
fn entry_in_use(bench: &mut Bench<'_>) -> Judged {
    bench.pdo_off(TPDO)?;
    let before = bench.read(TPDO.entry(1))?;
    let attempt = bench.download(TPDO.entry(1), &0_u32.to_le_bytes())?;
    bench.check(attempt.refused_with(&NOT_NOW, &[AbortCode::GENERAL]))?;
    bench.expect_unchanged(TPDO.entry(1), &before)?;
    Ok(())
}

/// More objects than the mapping has entries are refused with abort 0604 0042h.
#[case(id = "301/pdo/mapping/count", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MappingCountUnchecked], cct = "3.25")]
fn count(bench: &mut Bench<'_>) -> Judged {
    bench.open_mapping(TPDO)?;
    // FEh and FFh are MPDOs, which a device without them refuses as well.
    for wrong in [65_u8, 0xFE, 0xFF] {
        let attempt = bench.download(TPDO.entry(0), &[wrong])?;
        let _also = [
            AbortCode::NO_OBJECT,
            AbortCode::NOT_MAPPABLE,
            AbortCode::UNSUPPORTED_ACCESS,
            AbortCode::INVALID_VALUE,
            AbortCode::VALUE_TOO_HIGH,
            AbortCode::GENERAL,
        ];
        bench.check(attempt.refused(Situation::MappingRefused))?;
    }
    Ok(())
}

/// An object that does not exist can't be mapped: abort 0602 0000h or 0604 0041h.
#[case(id = "301/pdo/mapping/missing", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MissingObjectMapped, SdoNoObjectSilent])]
fn missing(bench: &mut Bench<'_>) -> Judged {
    refused(bench, TPDO, 0xFFFF_0020, &[AbortCode::NO_OBJECT, AbortCode::NOT_MAPPABLE], &[AbortCode::GENERAL])
}

/// A sub-index that an object does not have can't be mapped: abort 0609 0011h, 0602 0000h or 0604 0041h.
#[case(id = "301/pdo/mapping/missing-sub-index", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping], catches = [MissingObjectMapped, SdoNoObjectSilent])]
fn missing_sub_index(bench: &mut Bench<'_>) -> Judged {
    let before = bench.mapping(TPDO)?;
    let Some(first) = before.first() else {
        let reason = Reason::new("TPDO 1 maps an object", "one", "none");
        return Err(Stop::Inconclusive(reason));
    };
    let entry = u32::from(first.at.index.0) << 16 | 0xFD00 | u32::from(first.bits);
    let strict = [AbortCode::NO_SUB_INDEX, AbortCode::NO_OBJECT, AbortCode::NOT_MAPPABLE];
    refused(bench, TPDO, entry, &strict, &[AbortCode::GENERAL])
}

/// Dummy entries, which fill gaps in RPDOs, can't be mapped into a TPDO: abort 0604 0041h.
#[case(id = "301/pdo/mapping/dummy-in-tpdo", clause = "CiA 301 7.4.7.1", confidence = Attested, level = Should,
       needs = [Tpdo, DynamicMapping], catches = [DummyMappedIntoTpdo])]
fn dummy_in_tpdo(bench: &mut Bench<'_>) -> Judged {
    let tolerated = [AbortCode::NO_OBJECT, AbortCode::GENERAL];
    refused(bench, TPDO, 0x0005_0008, &[AbortCode::NOT_MAPPABLE], &tolerated)
}

/// Dummy entries that the description allows can be mapped into an RPDO, others can't.
#[case(id = "301/pdo/mapping/dummy-in-rpdo", clause = "CiA 301 7.4.7.1", confidence = Attested, level = Should,
       needs = [RpdoMapping, Description], catches = [DummyRefused], cct = "3.33")]
fn dummy_in_rpdo(bench: &mut Bench<'_>) -> Judged {
    let usage = bench.target().description.as_ref().map(|description| description.dummy_usage.clone());
    let lengths = [(0x0002_u16, 8_u32), (0x0003, 16), (0x0004, 32), (0x0005, 8), (0x0006, 16), (0x0007, 32)];
    for (index, bits) in lengths {
        let allowed = usage.as_ref().and_then(|usage| usage.get(&index)).copied().unwrap_or(false);
        let entry = u32::from(index) << 16 | bits;
        if allowed {
            bench.open_mapping(RPDO)?;
            bench.download(RPDO.entry(1), &entry.to_le_bytes())?.expect_confirmation()?;
            bench.download(RPDO.entry(0), &[1])?.expect_confirmation()?;
        } else {
            refused(bench, RPDO, entry, &[AbortCode::NOT_MAPPABLE, AbortCode::NO_OBJECT], &[AbortCode::GENERAL])?;
        }
    }
    Ok(())
}

/// An object that can only be read can't be mapped into an RPDO: abort 0604 0041h.
#[case(id = "301/pdo/mapping/read-only-in-rpdo", clause = "CiA 301 7.5.2.36", confidence = Attested, level = Must,
       needs = [RpdoMapping], catches = [MappingDirectionUnchecked], cct = "3.28")]
fn read_only_in_rpdo(bench: &mut Bench<'_>) -> Judged {
    let candidates: Vec<Mapped> = bench.tpdo_objects();
    let writable = bench.rpdo_objects();
    let Some(object) = candidates.into_iter().find(|mapped| !writable.contains(mapped)) else {
        let reason = Reason::new("an object is for TPDOs only", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let tolerated = [AbortCode::READ_ONLY, AbortCode::GENERAL];
    refused(bench, RPDO, object.entry(), &[AbortCode::NOT_MAPPABLE], &tolerated)
}

/// An object that is for RPDOs only can't be mapped into a TPDO: abort 0604 0041h.
#[case(id = "301/pdo/mapping/rpdo-object-in-tpdo", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [RpdoMapping, DynamicMapping], catches = [MappingDirectionUnchecked], cct = "3.31")]
fn rpdo_object_in_tpdo(bench: &mut Bench<'_>) -> Judged {
    let readable = bench.tpdo_objects();
    let Some(object) = bench.rpdo_objects().into_iter().find(|mapped| !readable.contains(mapped)) else {
        let reason = Reason::new("an object is for RPDOs only", "one in the description", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let tolerated = [AbortCode::WRITE_ONLY, AbortCode::GENERAL];
    refused(bench, TPDO, object.entry(), &[AbortCode::NOT_MAPPABLE], &tolerated)
}

/// Every object that the description lets a TPDO carry can be mapped.
#[case(id = "301/pdo/mapping/every-tpdo-object", clause = "CiA 301 7.5.2.38", confidence = Attested, level = Must,
       needs = [Tpdo, DynamicMapping, Description], catches = [MappingProcedureRefused], cct = "3.30")]
fn every_tpdo_object(bench: &mut Bench<'_>) -> Judged {
    let objects = bench.tpdo_objects();
    every_object(bench, TPDO, &objects)
}

/// Every object that the description lets an RPDO carry can be mapped.
#[case(id = "301/pdo/mapping/every-rpdo-object", clause = "CiA 301 7.5.2.36", confidence = Attested, level = Must,
       needs = [RpdoMapping, Description], catches = [MappingProcedureRefused], cct = "3.27")]
fn every_rpdo_object(bench: &mut Bench<'_>) -> Judged {
    let objects = bench.rpdo_objects();
    every_object(bench, RPDO, &objects)
}

fn every_object(bench: &mut Bench<'_>, pdo: Pdo, objects: &[Mapped]) -> Judged {
    const ENOUGH: usize = 40;
    bench.open_mapping(pdo)?;
    for mapped in objects.iter().take(ENOUGH) {
        let mut attempt = bench.download(pdo.entry(1), &mapped.entry().to_le_bytes())?;
        attempt.what = format!("mapping of {}, which the description allows,", mapped.at);
        attempt.expect_confirmation()?;
        let mut attempt = bench.download(pdo.entry(0), &[1])?;
        attempt.what = format!("mapping of {}, which the description allows,", mapped.at);
        attempt.expect_confirmation()?;
        bench.download(pdo.entry(0), &[0])?.expect_confirmation()?;
    }
    Ok(())
}

/// The mapping of an RPDO that is valid can't be changed, and stays as it is.
#[case(id = "301/rpdo/mapping/valid", clause = "CiA 301 7.5.2.36", confidence = Attested, level = Must,
       needs = [RpdoMapping], catches = [MappingChangeWhileValid], cct = "3.24")]
fn rpdo_valid(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read(RPDO.entry(0))?;
    if !bench.pdo_cob_id(RPDO)?.is_valid() {
        let cob_id = bench.pdo_cob_id(RPDO)?;
        bench.pdo_on(RPDO, cob_id)?;
    }
    let attempt = bench.download(RPDO.entry(0), &[0])?;
    bench.check(attempt.refused_with(&NOT_NOW, &[AbortCode::GENERAL]))?;
    bench.expect_unchanged(RPDO.entry(0), &before)?;
    Ok(())
}
