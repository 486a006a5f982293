//! Expedited transfers (CiA 301, 7.2.4.3.3 and 7.2.4.3.6).

use super::expect_form;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{Payload, Request};
use canvass_bus::client::sdo::Bytes;

/// Objects of up to four bytes are read in one message, whose command byte says how many bytes count: 4Fh, 4Bh, 47h or
/// 43h; the others are 0.
#[case(id = "301/sdo/upload/expedited", clause = "CiA 301 7.2.4.3.6", confidence = Known, level = Must,
       catches = [SdoUnusedBytesNotZero, SdoShortResponse], cct = "2.1")]
fn upload(bench: &mut Bench<'_>) -> Judged {
    for (index, sub, length) in [(0x1000, 0, 4), (0x1001, 0, 1), (0x1018, 0, 1), (0x1018, 1, 4)] {
        // DS-301 V3.0 had no 1018h: that it is missing is the matter of the cases on identity.
        if bench.described(Multiplexer::new(index, sub)) == Some(false) {
            continue;
        }
        let attempt = bench.upload(Multiplexer::new(index, sub))?;
        if attempt.abort().is_some() {
            // That it is missing is the matter of others.
            continue;
        }
        let value = attempt.clone().value()?;
        demand(value.len() == length && attempt.responses.len() == 1, || {
            let duty = format!("the {} is answered by one message", attempt.what);
            let expected = format!("command byte {:02X}h", 0x43 | (4 - length) << 2);
            Reason::new(
                duty,
                expected,
                attempt.responses.first().map_or_else(String::new, |f| Bytes(f.data()).to_string()),
            )
        })?;
        expect_form(&attempt)?;
    }
    for scratch in bench.scratch_objects()? {
        let attempt = bench.upload(scratch.multiplexer)?;
        expect_form(&attempt)?;
    }
    Ok(())
}

/// A download with the exact length is confirmed by 60h with the same index and sub-index, and the value can be read
/// back.
#[case(id = "301/sdo/download/expedited", clause = "CiA 301 7.2.4.3.3", confidence = Known, level = Must,
       needs = [ScratchObject], catches = [SdoUnusedBytesNotZero, SdoShortResponse, ErrorBehaviourAlwaysLeaves], cct = "2.2")]
fn download(bench: &mut Bench<'_>) -> Judged {
    for scratch in bench.scratch_objects()? {
        let attempt = bench.download(scratch.multiplexer, &scratch.other)?;
        attempt.expect_confirmation()?;
        expect_form(&attempt)?;
        let back = bench.upload(scratch.multiplexer)?.value()?;
        demand(back == scratch.other, || {
            let duty = format!("{} has the value that was written", scratch.multiplexer);
            Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&back).to_string())
        })?;
    }
    Ok(())
}

/// A download that does not say how many of its four bytes count (command byte 22h) is taken with the object's own
/// length, or refused because of its length.
#[case(id = "301/sdo/download/size-not-indicated", clause = "CiA 301 7.2.4.3.3", confidence = Known, level = Should,
       needs = [ScratchObject], catches = [SdoUnsizedDownloadSilent])]
fn size_not_indicated(bench: &mut Bench<'_>) -> Judged {
    use canvass_analyzer::wire::sdo::Response;
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    let mut bytes = [0; 4];
    bytes.iter_mut().zip(&scratch.other).for_each(|(to, from)| *to = *from);
    let multiplexer = scratch.multiplexer;
    let request = Request::InitiateDownload { multiplexer, payload: Payload::ExpeditedUnsized(bytes) };
    let reply = bench.exchange(&request, format!("download of no stated length to {multiplexer}"))?;
    if reply.response == Some(Response::InitiateDownload { multiplexer }) {
        let back = bench.read(multiplexer)?;
        return bench.check(demand(back == scratch.other, || {
            let duty = format!("{multiplexer} takes as many bytes as it has");
            Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&back).to_string())
        }));
    }
    bench.check(reply.refused(Situation::TooLong))?;
    bench.expect_unchanged(multiplexer, &scratch.value)?;
    Ok(())
}
