//! Identification of slaves (CiA 305, 6.6).

use super::dialogue::{address, configure, exchange, expect_heard, expect_silence, tell, wait};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Stop, tried};
use canvass_analyzer::wire::lss::{Bound, Request, Response};

/// The six bounds around an address: exact vendor and product, ranges of revision and serial number.
fn bounds(address: [u32; 4], margin: u32) -> [u32; 6] {
    let [vendor, product, revision, serial] = address;
    [
        vendor,
        product,
        revision.saturating_sub(margin),
        revision.saturating_add(margin),
        serial.saturating_sub(margin),
        serial.saturating_add(margin),
    ]
}

/// Sends the six bounds; returns the responses. Only a slave within all bounds must answer, after the last one.
fn identify(bench: &mut Bench<'_>, bounds: [u32; 6], within: bool) -> Result<Vec<Response>, Stop> {
    let mut heard = Vec::new();
    for (n, (bound, value)) in Bound::ALL.into_iter().zip(bounds).enumerate() {
        let request = Request::IdentifyRemote { bound, value };
        let is_last = n + 1 == Bound::ALL.len();
        heard.extend(if within && is_last { exchange(bench, request)? } else { tell(bench, request)? });
    }
    Ok(heard)
}

/// A slave within the six bounds sends one 4Fh in answer to the last bound.
#[case(id = "305/identify/within", clause = "CiA 305 6.6.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssIdentifyUnanswered])]
fn within(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let heard = identify(bench, bounds(address, 10), true)?;
    let duty = "a slave within the bounds answers the last of them".to_owned();
    bench.check(expect_heard(duty, Some(Response::Identified), &heard))
}

/// The bounds belong to the range: a slave whose numbers equal them answers.
#[case(id = "305/identify/at-bounds", clause = "CiA 305 6.6.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssIdentifyRangeExclusive, LssIdentifyUnanswered])]
fn at_bounds(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let heard = identify(bench, bounds(address, 0), true)?;
    let duty = "a slave at the bounds answers the last of them".to_owned();
    bench.check(expect_heard(duty, Some(Response::Identified), &heard))
}

/// A slave that is outside one of the bounds does not answer.
#[case(id = "305/identify/outside", clause = "CiA 305 6.6.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssIdentifyUnchecked])]
fn outside(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let right = bounds(address, 10);
    let outside = [
        (0, right[0] ^ 1),
        (1, right[1] ^ 1),
        (2, address[2].saturating_add(1)),
        (3, address[2].saturating_sub(1)),
        (4, address[3].saturating_add(1)),
        (5, address[3].saturating_sub(1)),
    ];
    bench.each(outside, |bench, (place, value)| {
        let mut wrong = right;
        let (Some(bound), Some(own)) =
            (wrong.get_mut(place), address.get(if place < 2 { place } else { place / 2 + 1 }))
        else {
            return Ok(());
        };
        // A number that has no neighbour on this side can't be out of bounds there.
        if *bound == value || value == *own {
            return Ok(());
        }
        *bound = value;
        let heard = identify(bench, wrong, false)?;
        let duty = format!("a slave outside of the {} does not answer", Bound::ALL[place].name());
        bench.check(expect_heard(duty, None, &heard))
    })?;
    // Silence proves something only if the slave answers within its bounds.
    tried(identify(bench, right, true)?.len(), "an answer to the bounds of its own address")
}

/// A slave with a node-ID does not answer identify non-configured remote slave.
#[case(id = "305/identify/configured", clause = "CiA 305 6.6.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssNonConfiguredAnswered])]
fn configured(bench: &mut Bench<'_>) -> Judged {
    let answer = tell(bench, Request::IdentifyNonConfigured)?;
    bench.check(expect_silence("the search for slaves without node-ID", answer))?;
    // Silence proves something only if the slave is present.
    configure(bench)?;
    wait(bench)
}
