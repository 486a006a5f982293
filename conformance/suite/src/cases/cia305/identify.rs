//! Identification of slaves (CiA 305, 6.6).

use super::dialogue::{address, exchange, expect, expect_silence};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
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

/// Gives the six bounds; returns what came.
fn identify(bench: &mut Bench<'_>, bounds: [u32; 6]) -> Result<Vec<Response>, Stop> {
    let mut heard = Vec::new();
    for (bound, value) in Bound::ALL.into_iter().zip(bounds) {
        heard.extend(exchange(bench, Request::IdentifyRemote { bound, value })?);
    }
    Ok(heard)
}

/// A slave within the six bounds answers the last of them by one 4Fh.
#[case(id = "305/identify/within", clause = "CiA 305 6.6.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssIdentifyUnanswered])]
fn within(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let heard = identify(bench, bounds(address, 10))?;
    bench.check(demand(heard == [Response::Identified], || {
        Reason::new("a slave within the bounds answers", "one 4Fh", format!("{heard:?}"))
    }))
}

/// Bounds belong to the range: a slave whose numbers equal them answers.
#[case(id = "305/identify/at-bounds", clause = "CiA 305 6.6.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssIdentifyRangeExclusive, LssIdentifyUnanswered])]
fn at_bounds(bench: &mut Bench<'_>) -> Judged {
    let address = address(bench)?;
    let heard = identify(bench, bounds(address, 0))?;
    bench.check(demand(heard == [Response::Identified], || {
        Reason::new("a slave at the bounds answers", "one 4Fh", format!("{heard:?}"))
    }))
}

/// A slave outside of one of the bounds does not answer.
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
    for (place, value) in outside {
        let mut wrong = right;
        if let Some(bound) = wrong.get_mut(place) {
            // A number that has no neighbour on that side can't be outside there.
            if *bound == value || value == address[place / 2 + 1] {
                continue;
            }
            *bound = value;
        }
        let heard = identify(bench, wrong)?;
        demand(heard.is_empty(), || {
            let duty = format!("a slave outside of the {} does not answer", Bound::ALL[place].name());
            Reason::new(duty, "silence", format!("{heard:?}"))
        })?;
    }
    Ok(())
}

/// A slave with a node-ID does not answer the search for slaves without one.
#[case(id = "305/identify/configured", clause = "CiA 305 6.6.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssNonConfiguredAnswered])]
fn configured(bench: &mut Bench<'_>) -> Judged {
    let answer = exchange(bench, Request::IdentifyNonConfigured)?;
    expect_silence("the search for slaves without node-ID", answer)?;
    // Silence means something only if the slave is there.
    super::configure(bench)?;
    let answer = exchange(bench, Request::InquireNodeId)?;
    super::dialogue::wait(bench)?;
    expect("the inquiry of the node-ID", "the node-ID", answer, |answer| matches!(answer, Response::NodeId(_)))
        .or_inconclusive()
}
