//! Shared functions of the LSS and LMT cases: sending and receiving messages, and the observations of answers.

pub mod bit_rate;

use crate::bench::Bench;
use crate::verdict::{Allowed, Breach, Check, Judged, Stop, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{
    ConfigureCommand, Dialect, MASTER_CAN_ID, Request, Response, SLAVE_CAN_ID,
};
use canvass_bus::observation::Observation;
use canvass_traces::{Direction, Duration, Record};

/// Maximum time until a device that activates its node-ID or bit rate by itself at the end of configuration has done so.
pub const RESTART: Duration = Duration::from_millis(500);

/// A dialect of layer setting, and the words for its responses in reports.
pub trait Observed: Dialect {
    /// The service that breaches of this dialect name.
    const SERVICE: Service;
    /// The name of a response that the standard does not define.
    const UNKNOWN: &'static str;
    /// A part of an address as an observation.
    fn part(value: Self::Value) -> Observation;
}

/// Sends a message that the slave must answer, and waits for its response; a slave may take seconds to store.
pub fn exchange<D: Dialect>(bench: &mut Bench<'_>, request: Request<D>) -> Result<Option<Response<D>>, Stop> {
    exchange_within(bench, request, bench.timing().lss)
}

/// Sends a message that need not be answered, and returns the response, if any.
pub fn tell<D: Dialect>(bench: &mut Bench<'_>, request: Request<D>) -> Result<Option<Response<D>>, Stop> {
    exchange_within(bench, request, bench.timing().silence)
}

/// Sends a message, and waits for a response for at most `span`.
pub(crate) fn exchange_within<D: Dialect>(
    bench: &mut Bench<'_>,
    request: Request<D>,
    span: Duration,
) -> Result<Option<Response<D>>, Stop> {
    bench.drain()?;
    bench.send(&request.to_frame(MASTER_CAN_ID))?;
    hear(bench, span)
}

/// The next response within `span`.
pub fn hear<D: Dialect>(bench: &mut Bench<'_>, span: Duration) -> Result<Option<Response<D>>, Stop> {
    bench.wait_for(span, |record| {
        let is_slave = record.frame.cob_id() == Some(SLAVE_CAN_ID);
        is_slave.then(|| Response::read(record.frame.data()).ok()).flatten()
    })
}

pub fn shown<D: Dialect>(response: Option<Response<D>>) -> String {
    response.map_or_else(|| "no answer".to_owned(), |response| response.to_string())
}

/// A response as an observation: the error code, the node-ID, the part of its address.
pub fn observed<D: Observed>(response: Option<Response<D>>) -> Observation {
    let Some(response) = response else { return Observation::Silence };
    match response {
        Response::Configured { error, .. } => Observation::ErrorCode(error),
        Response::NodeId(node) => Observation::Number(node.into()),
        Response::Part { value, .. } => D::part(value),
        Response::Switched | Response::Identified | Response::NonConfigured => {
            Observation::Named(format!("{:02X}h", response.to_frame(SLAVE_CAN_ID).bytes()[0]).into())
        }
        Response::Unknown { .. } => Observation::named(D::UNKNOWN),
    }
}

/// Requires a confirmation with an allowed error code.
pub fn expect_error<D: Observed>(
    duty: impl Into<String>,
    expected: impl Into<Allowed>,
    of: ConfigureCommand,
    found: Option<Response<D>>,
    right: impl FnOnce(u8) -> bool,
) -> Check {
    let error = match found {
        Some(Response::Configured { command, error, .. }) if command == of => Some(error),
        _ => None,
    };
    demand(error.is_some_and(right), || {
        // The error code in a confirmation of another command has no meaning here.
        let actual = match found {
            Some(Response::Configured { .. }) if error.is_none() => {
                Observation::named("the confirmation of another command")
            }
            other => observed(other),
        };
        Breach::new(D::SERVICE, duty.into()).expected(expected).found(actual).told(shown(found))
    })
}

/// Requires silence.
pub(crate) fn expect_silence<D: Observed>(duty: String, found: Option<Response<D>>) -> Check {
    demand(found.is_none(), || {
        let breach = Breach::new(D::SERVICE, duty).expected(Observation::Silence);
        breach.found(observed(found)).told(shown(found))
    })
}

/// Requires of the whole dialogue of the case, its preparation included, that each response answers a request, once,
/// and has eight bytes, the unused ones 0.
pub fn expect_dialogue<D: Observed>(bench: &mut Bench<'_>) -> Judged {
    // The response to the last request may be followed by another one.
    bench.listen(bench.timing().silence)?;
    if !bench.others().is_empty() {
        // Another slave may have answered, too: responses name no sender.
        return Ok(());
    }
    let evidence = bench.evidence();
    // Long evidence keeps only its first and last frames: requests are missing in the gap.
    let gap = (evidence.omitted() > 0).then(|| evidence.gap());
    let records: Vec<&Record> = evidence.frames().map(|exhibit| &exhibit.record).collect();
    let parts = records.split_at_checked(gap.unwrap_or(records.len()));
    let (head, tail) = parts.unwrap_or((&records, &[]));
    let wrong = wrong_response::<D>(head).or_else(|| wrong_response::<D>(tail));
    bench.check(wrong.map_or(Ok(()), |breach| Err(Box::new(breach))))
}

/// The first response that answers no request, or that has a wrong form.
fn wrong_response<D: Observed>(records: &[&Record]) -> Option<Breach> {
    let mut open: Option<Vec<Request<D>>> = None;
    for record in records {
        match (record.direction, record.frame.cob_id()) {
            (Direction::Tx, Some(MASTER_CAN_ID)) => {
                open.get_or_insert_default().extend(Request::read(record.frame.data()));
            }
            // Another master: its slaves answer it.
            (_, Some(MASTER_CAN_ID)) => open = None,
            (Direction::Rx, Some(SLAVE_CAN_ID)) => {
                // Without a request of the tester the response belongs to another dialogue.
                let Some(open) = &mut open else { continue };
                if let Some(breach) = judged(open, record) {
                    return Some(breach);
                }
            }
            _ => {}
        }
    }
    None
}

/// Judges a response to one of these unanswered requests. The response answers the oldest request that it fits; earlier
/// requests get no response any more.
fn judged<D: Observed>(open: &mut Vec<Request<D>>, record: &Record) -> Option<Breach> {
    let breach = |duty: String| {
        let breach = Breach::new(D::SERVICE, duty).found(Observation::Frame(record.frame));
        Breach { seen: Some(record.timestamp), ..breach }
    };
    let response = Response::<D>::read(record.frame.data()).ok();
    let told = format!("{}: {}", record.frame, shown(response));
    let place = response.and_then(|response| open.iter().position(|request| response.answers(*request)));
    let (Some(response), Some(place)) = (response, place) else {
        let duty = match open.last() {
            Some(request) => format!("a response to \"{request}\" is the one that belongs to it"),
            None => "a request is answered once".to_owned(),
        };
        return Some(breach(duty).expected("no other response").told(told));
    };
    let request = open.drain(..=place).next_back()?;
    let is_clean = response.to_frame(SLAVE_CAN_ID) == record.frame && !response.says_too_much();
    (!is_clean).then(|| {
        let breach = breach(format!("the response to \"{request}\" has eight bytes, and unused bytes are 0"));
        breach.expected("eight bytes, the unused ones 0").told(told)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::frame;
    use canvass_analyzer::wire::lss::Lss;
    use canvass_traces::{ChannelId, Timestamp};

    /// The breach in these frames; `>` marks a frame of the tester.
    fn found(frames: &[&str]) -> Option<String> {
        let records = frames.iter().map(|text| {
            let direction = if text.starts_with('>') { Direction::Tx } else { Direction::Rx };
            Record::new(Timestamp::ZERO, ChannelId(0), frame(&text[1..])).with_direction(direction)
        });
        let records: Vec<Record> = records.collect();
        wrong_response::<Lss>(&records.iter().collect::<Vec<_>>()).map(|breach| breach.to_string())
    }

    const ASKED: &str = ">7E5#5E00000000000000";
    const ANSWERED: &str = "<7E4#5E3F000000000000";

    #[test]
    fn a_response_answers_a_request_once() {
        assert_eq!(found(&[ASKED, ANSWERED, ASKED, ANSWERED]), None);
        assert_eq!(found(&[ASKED, ASKED, ANSWERED, ANSWERED]), None, "the first answer comes late");
        assert!(found(&[ASKED, ANSWERED, ANSWERED]).is_some_and(|told| told.contains("is answered once")));
        assert!(found(&[ASKED, "<7E4#5A00000000000000"]).is_some_and(|told| told.contains("belongs to it")));
        assert_eq!(found(&[ANSWERED, ANSWERED]), None, "without a request of the tester");
        assert_eq!(found(&[ASKED, ANSWERED, "<7E5#5E00000000000000", ANSWERED]), None, "another master");
    }

    #[test]
    fn a_response_has_eight_bytes_and_the_unused_ones_are_0() {
        let asked = ">7E5#113F000000000000";
        assert_eq!(found(&[asked, "<7E4#11FF070000000000"]), None, "a specific error");
        for wrong in ["1100070000000000", "1100000000000001", "11000000000000"] {
            let told = found(&[asked, &format!("<7E4#{wrong}")]).unwrap();
            assert!(told.contains("has eight bytes, and unused bytes are 0"), "{told}");
        }
    }
}
