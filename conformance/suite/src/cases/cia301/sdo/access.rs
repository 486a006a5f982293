//! Transfers that the server must refuse, with their abort codes (CiA 301, 7.2.4.3.17).

use crate::bench::Bench;
use crate::bench::sdo::DEVICE_TYPE;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::Value;
use canvass_analyzer::object;

/// Reading an object that does not exist is refused with abort 0602 0000h.
#[case(id = "301/sdo/upload/no-object", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       catches = [SdoWrongCodeForNoObject, SdoNoObjectSilent], cct = "2.6")]
fn no_object(bench: &mut Bench<'_>) -> Judged {
    for (index, is_in_old_profiles) in [(object::NUMBER_OF_PDOS, true), (0x0000, false), (0xFFFF, false)] {
        let multiplexer = Multiplexer::new(index, 0);
        let described = bench.described(multiplexer);
        if described == Some(true) || is_in_old_profiles && described.is_none() {
            continue;
        }
        let attempt = bench.upload(multiplexer)?;
        bench.check(attempt.refused(Situation::MissingObject))?;
    }
    bench.expect_tidy()
}

/// Reading a sub-index that an object does not have is refused with abort 0609 0011h.
#[case(id = "301/sdo/upload/no-sub-index", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       catches = [SdoWrongCodeForNoSubIndex, SdoUnknownAbortCode], cct = "2.5")]
fn no_sub_index(bench: &mut Bench<'_>) -> Judged {
    let attempt = bench.upload(Multiplexer::new(object::DEVICE_TYPE, 1))?;
    bench.check(attempt.refused(Situation::MissingEntry))?;
    bench.expect_tidy()
}

/// Writing an object that does not exist is refused with abort 0602 0000h.
#[case(id = "301/sdo/download/no-object", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       catches = [SdoWrongCodeForNoObject, SdoNoObjectSilent])]
fn download_no_object(bench: &mut Bench<'_>) -> Judged {
    let attempt = bench.download(Multiplexer::new(0xFFFF, 0), &[0; 4])?;
    bench.check(attempt.refused(Situation::MissingObject))?;
    bench.expect_tidy()
}

/// Writing a read-only object is refused with abort 0601 0002h, and the object keeps its value.
#[case(id = "301/sdo/download/read-only", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       catches = [SdoReadOnlyWritable, SdoReadOnlyWrongCode], cct = "2.3")]
fn read_only(bench: &mut Bench<'_>) -> Judged {
    bench.each([DEVICE_TYPE, Multiplexer::new(object::IDENTITY, 1)], |bench, multiplexer| {
        if bench.described(multiplexer) == Some(false) {
            return Ok(());
        }
        let before = bench.read(multiplexer)?;
        let other: Vec<u8> = before.iter().map(|byte| !byte).collect();
        let attempt = bench.download(multiplexer, &other)?;
        bench.check(attempt.refused(Situation::ReadOnly))?;
        bench.expect_unchanged(multiplexer, &before)
    })?;
    bench.expect_tidy()
}

/// Writing more bytes than an object has is refused with abort 0607 0012h, and the object keeps its value.
#[case(id = "301/sdo/download/too-long", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [ScratchObject], catches = [SdoLengthUnchecked, SdoLengthWrongCode], cct = "2.8")]
fn too_long(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 1, 4])?;
    let mut longer = scratch.other.clone();
    longer.resize(4.max(longer.len() + 2), 0);
    let attempt = bench.download(scratch.multiplexer, &longer)?;
    bench.check(attempt.refused(Situation::TooLong))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// Writing fewer bytes than an object has is refused with abort 0607 0013h, and the object keeps its value.
#[case(id = "301/sdo/download/too-short", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [ScratchObject], catches = [SdoShortLengthUnchecked, SdoLengthWrongCode], cct = "2.9")]
fn too_short(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4])?;
    let shorter = scratch.other.get(..1).unwrap_or_default();
    let attempt = bench.download(scratch.multiplexer, shorter)?;
    bench.check(attempt.refused(Situation::TooShort))?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// Writing a value outside the limits of the description is refused, a value above the high limit with abort 0609 0031h
/// or 0609 0030h, and the object keeps its value.
#[case(id = "301/sdo/download/out-of-range", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Must,
       needs = [Description], catches = [SdoRangeUnchecked, SdoRangeWrongCode], cct = "2.10")]
fn out_of_range(bench: &mut Bench<'_>) -> Judged {
    let limited = limited_objects(bench);
    if limited.is_empty() {
        let reason = Reason::new("an object has limits", "a writable object with HighLimit", "none");
        return Err(Stop::NotApplicable(reason));
    }
    bench.each(limited, |bench, (multiplexer, beyond)| {
        let before = bench.read(multiplexer)?;
        let attempt = bench.download(multiplexer, &beyond)?;
        bench.check(attempt.refused(Situation::TooHigh))?;
        bench.expect_unchanged(multiplexer, &before)
    })
}

/// Communication and profile objects with a limit below the maximum of their type, each with the value just above the
/// limit. Manufacturer objects are left out: among them are node-ID and bit rate.
fn limited_objects(bench: &Bench<'_>) -> Vec<(Multiplexer, Vec<u8>)> {
    let node = bench.node();
    let Some(description) = &bench.target().description else { return Vec::new() };
    let entries = description.dictionary.entries().filter(|(multiplexer, entry)| {
        let is_standard = matches!(multiplexer.index.0, object::COB_ID_TIME..=object::ERROR_BEHAVIOR | 0x6000..=0x9FFF);
        let is_plain = !entry.flags.refuses_write_on_download() && entry.access.is_readable();
        is_standard
            && is_plain
            && entry.access.is_writable()
            && !bench.acts(*multiplexer)
            && bench.may_write(*multiplexer)
    });
    let beyond = entries.filter_map(|(multiplexer, entry)| {
        let limit = entry.high_limit.as_ref()?.resolve(entry.data_type, node).as_number()?;
        let length = entry.data_type.bytes().filter(|&length| length <= 4)?;
        let beyond = Value::Unsigned(u64::try_from(limit + 1).ok()?);
        let bytes = beyond.encode(entry.data_type).ok().filter(|bytes| bytes.len() == length)?;
        Some((multiplexer, bytes))
    });
    beyond.collect()
}
