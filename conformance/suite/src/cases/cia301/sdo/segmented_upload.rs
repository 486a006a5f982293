//! Segmented upload (CiA 301, 7.2.4.3.5 to 7.2.4.3.7).

use super::by_hand::long_object;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Precondition, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::{AbortCode, Request};

/// A segmented upload returns the announced number of bytes, and its toggle bits alternate beginning with 0. A string
/// returns the same value when it is read again.
#[case(id = "301/sdo/upload/segmented", clause = "CiA 301 7.2.4.3.7", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoSegmentLengthWrong, SdoShortResponse, SdoUploadToggleStuck, SdoUploadEndMissing, SdoAnnouncedSizeWrong], cct = "2.16")]
fn segmented(bench: &mut Bench<'_>) -> Judged {
    // The first segmented upload of the case, before the tester looks for long objects.
    let name = Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0);
    let first = bench.upload(name)?.value().ok();
    let objects = bench.long_objects(5, 8)?;
    bench.each(objects, |bench, multiplexer| {
        let value = bench.upload(multiplexer)?.value()?;
        bench.expect_value(multiplexer, &value, format!("{multiplexer} returns the same value again"))
    })?;
    if let Some(first) = first {
        bench.expect_value(name, &first, format!("{name} returns the same value as at first"))?;
    }
    bench.expect_tidy()
}

/// The last segment ends an upload: a request for one more segment is refused with abort 0504 0001h.
#[case(id = "301/sdo/upload/over-after-end", clause = "CiA 301 7.2.4.3.5", confidence = Cited, level = Must,
       needs = [SegmentedUpload], catches = [SdoSegmentAfterEndAnswered, SdoCommandWrongCode])]
fn over_after_end(bench: &mut Bench<'_>) -> Judged {
    let multiplexer = long_object(bench)?;
    let value = bench.upload(multiplexer)?.value().or_inconclusive()?;
    // The next expected toggle bit.
    let toggle = value.len().div_ceil(7) % 2 == 1;
    let reply = bench.exchange(&Request::UploadSegment { toggle }, "request for a segment after the last one")?;
    bench.check(reply.refused(Situation::UnknownCommand))?;
    bench.expect_again(multiplexer, &value, "a new upload returns the same value")?;
    bench.expect_tidy()
}

/// An empty value is read as an announcement of 0 bytes and one empty segment, or refused with abort 0800 0024h.
#[case(id = "301/sdo/upload/empty", clause = "CiA 301 7.2.4.3.6", confidence = Cited, level = Should,
       needs = [EmptyValue], catches = [SdoEmptyValueSilent])]
fn empty(bench: &mut Bench<'_>) -> Judged {
    let Some(multiplexer) = bench.empty_object()? else {
        let reason = Reason::new("an object is empty", "a string without characters", "none");
        return Err(Stop::NotApplicable(reason));
    };
    if bench.upload(multiplexer)?.abort() != Some(AbortCode::NO_DATA) {
        bench.expect_value(multiplexer, &[], format!("{multiplexer} is empty, as described"))?;
    }
    bench.expect_tidy()
}
