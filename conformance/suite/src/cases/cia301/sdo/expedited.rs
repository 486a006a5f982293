//! Expedited transfers (CiA 301, 7.2.4.3.3 and 7.2.4.3.6).

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Check, Judged, demand, observed, tried};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{Payload, Request, Response};
use canvass_bus::client::Outcome;
use canvass_bus::client::sdo::Bytes;
use canvass_bus::observation::Observation;
use canvass_traces::Frame;

/// Objects that every device has, and their lengths.
const SHORT: [(Multiplexer, usize); 4] = [
    (Multiplexer::new(object::DEVICE_TYPE, 0), 4),
    (Multiplexer::new(object::ERROR_REGISTER, 0), 1),
    (Multiplexer::new(object::IDENTITY, 0), 1),
    (Multiplexer::new(object::IDENTITY, 1), 4),
];

/// Objects of up to four bytes are read in one response. Its command byte gives the number of valid bytes (4Fh, 4Bh,
/// 47h or 43h), or leaves the number to the data type of the object (42h). Each response belongs to the request before
/// it, also in the preparation of the case and right after a start.
#[case(id = "301/sdo/upload/expedited", clause = "CiA 301 7.2.4.3.6", confidence = Cited, level = Must,
       catches = [SdoShortResponse], cct = "2.1")]
fn upload(bench: &mut Bench<'_>) -> Judged {
    let mut read = 0;
    bench.each(SHORT, |bench, (multiplexer, length)| {
        // DS-301 V3.0 had no 1018h: the cases on identity judge whether it is missing.
        if bench.described(multiplexer) == Some(false) {
            return Ok(());
        }
        let attempt = bench.upload(multiplexer)?;
        if attempt.abort().is_some() {
            return Ok(());
        }
        read += 1;
        let first = attempt.responses.first().copied();
        bench.check(is_expedited(multiplexer, &attempt.outcome, first, length))
    })?;
    tried(read, "one of the objects that every device has")?;
    let scratches = bench.scratch_objects()?;
    bench
        .each(scratches, |bench, scratch| bench.upload(scratch.multiplexer)?.value().map(|_| ()).map_err(Into::into))?;
    // An object of one byte, and one of four.
    bench.each([SHORT[2], SHORT[0]], first_after_start)?;
    bench.expect_tidy()?;
    bench.expect_dialogue()
}

/// Requires that the first answer after a start equals the answers at other times.
fn first_after_start(bench: &mut Bench<'_>, (multiplexer, length): (Multiplexer, usize)) -> Judged {
    let Outcome::Uploaded(usual) = bench.upload(multiplexer)?.outcome else { return Ok(()) };
    bench.reset(Command::RESET_NODE)?;
    let attempt = bench.upload(multiplexer)?.under("after a start");
    if attempt.is_silent() && !bench.answers()? {
        // A device that stops itself when it starts serves no SDO.
        return Ok(());
    }
    let first = attempt.responses.first().copied();
    bench.check(is_expedited(multiplexer, &attempt.outcome, first, length))?;
    let Outcome::Uploaded(value) = attempt.outcome else { return Ok(()) };
    // A response that does not state its length carries further bytes, too.
    bench.check(demand(value.get(..length) == usual.get(..length), || {
        let breach =
            Breach::new(multiplexer, format!("the first upload of {multiplexer} after a start gives its value"));
        breach.expected(Observation::Value(usual)).found(Observation::Value(value))
    }))
}

fn is_expedited(multiplexer: Multiplexer, outcome: &Outcome, first: Option<Frame>, length: usize) -> Check {
    let payload = first.and_then(|frame| match Response::read(frame.data()) {
        Ok(Response::InitiateUpload { payload, .. }) => Some(payload),
        _ => None,
    });
    let is_right = match payload {
        Some(Payload::Expedited(value)) => value.data().len() == length,
        Some(Payload::ExpeditedUnsized(_)) => matches!(outcome, Outcome::Uploaded(_)),
        _ => false,
    };
    demand(is_right, || {
        let breach = Breach::new(multiplexer, "an object of up to four bytes is read in one message, with its length");
        let breach = breach.expected(format!("command byte {:02X}h", 0x43 | (4 - length) << 2));
        let told = first.map_or_else(|| outcome.to_string(), |frame| Bytes(frame.data()).to_string());
        match payload {
            Some(Payload::Segmented(_) | Payload::SegmentedUnsized) => {
                breach.found(Observation::named("a segmented upload")).told(told)
            }
            _ => breach.found(observed(outcome)).told(told),
        }
    })
}

/// Bytes of an upload response that hold no data are 0. The standard says only that they contain no data, so a server
/// may leave old values in them.
#[case(id = "301/sdo/upload/padding", clause = "CiA 301 7.2.4.3.6", confidence = Cited, level = Open,
       catches = [SdoUnusedBytesNotZero])]
fn padding(bench: &mut Bench<'_>) -> Judged {
    let mut read = 0;
    let objects = SHORT.into_iter().map(|(multiplexer, _)| multiplexer).chain(bench.long_objects(5, 2)?);
    bench.each(objects, |bench, multiplexer| {
        let attempt = bench.upload(multiplexer)?;
        read += usize::from(matches!(attempt.outcome, Outcome::Uploaded(_)));
        let dirty = attempt.responses.iter().find(|frame| {
            let clean = Response::read(frame.data()).map(|clean| clean.to_frame(frame.cob_id().unwrap_or_default()));
            frame.len() == 8 && clean.is_ok_and(|clean| clean.data() != frame.data())
        });
        bench.check(demand(dirty.is_none(), || {
            let told = dirty.map(|frame| Bytes(frame.data()).to_string()).unwrap_or_default();
            let breach = Breach::new(multiplexer, "bytes that hold no data are 0").expected("00h in these bytes");
            breach.found(Observation::named("bytes without data are not 0")).told(told)
        }))
    })?;
    tried(read, "an object that can be read")
}

/// An expedited download with the correct length is confirmed by 60h with the same index and sub-index, and the value
/// can be read back.
#[case(id = "301/sdo/download/expedited", clause = "CiA 301 7.2.4.3.3", confidence = Cited, level = Must,
       needs = [ScratchObject],
       catches = [SdoUnusedBytesNotZero, SdoShortResponse, ErrorBehaviourAlwaysLeaves], cct = "2.2")]
fn download(bench: &mut Bench<'_>) -> Judged {
    let scratches = bench.scratch_objects()?;
    bench.each(scratches, |bench, scratch| {
        let multiplexer = scratch.multiplexer;
        bench.download(multiplexer, &scratch.other)?.expect_confirmation()?;
        bench.expect_value(multiplexer, &scratch.other, format!("{multiplexer} has the value that was written"))
    })?;
    bench.expect_tidy()
}

/// An expedited download that does not indicate its number of valid bytes (command byte 22h) is accepted with the
/// length of the object, or refused because of its length.
#[case(id = "301/sdo/download/size-not-indicated", clause = "CiA 301 7.2.4.3.3", confidence = Cited, level = Should,
       needs = [ScratchObject], catches = [SdoUnsizedDownloadSilent])]
fn size_not_indicated(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    let mut bytes = [0; 4];
    bytes.iter_mut().zip(&scratch.other).for_each(|(to, from)| *to = *from);
    let multiplexer = scratch.multiplexer;
    let request = Request::InitiateDownload { multiplexer, payload: Payload::ExpeditedUnsized(bytes) };
    let reply = bench.exchange(&request, format!("download without stated length to {multiplexer}"))?;
    if reply.response == Some(Response::InitiateDownload { multiplexer }) {
        return bench.expect_value(
            multiplexer,
            &scratch.other,
            format!("{multiplexer} accepts a value of its own length"),
        );
    }
    bench.check(reply.refused(Situation::TooLong))?;
    bench.expect_unchanged(multiplexer, &scratch.value)
}
