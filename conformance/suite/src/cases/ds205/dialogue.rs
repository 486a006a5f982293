//! What all LMT cases need: messages out and in, modes reached and proven.

use crate::bench::Bench;
use crate::verdict::{Breach, Check, Judged, Stop, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lmt::{self, ConfigureCommand, Part, Request, Response, Seven};
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// Sends a message that the slave has to answer, and waits for its response; a slave may take seconds to store.
pub fn exchange(bench: &mut Bench<'_>, request: Request) -> Result<Option<Response>, Stop> {
    exchange_within(bench, request, bench.timing().lss)
}

/// Sends a message that nobody has to answer, and gives a response all the same if there is one.
pub fn tell(bench: &mut Bench<'_>, request: Request) -> Result<Option<Response>, Stop> {
    exchange_within(bench, request, bench.timing().silence)
}

fn exchange_within(bench: &mut Bench<'_>, request: Request, span: Duration) -> Result<Option<Response>, Stop> {
    bench.drain()?;
    bench.send(&request.to_frame(lmt::MASTER_CAN_ID))?;
    bench.wait_for(span, |record| {
        let is_slave = record.frame.cob_id() == Some(lmt::SLAVE_CAN_ID);
        is_slave.then(|| Response::read(record.frame.data()).ok()).flatten()
    })
}

pub fn shown(response: Option<Response>) -> String {
    response.map_or_else(|| "no answer".to_owned(), |response| response.to_string())
}

/// What a slave answered, as an observation: the error code, the part of its address.
pub fn observed(response: Option<Response>) -> Observation {
    match response {
        None => Observation::Silence,
        Some(Response::Identified) => Observation::named("09h"),
        Some(Response::Configured { error, .. }) => Observation::ErrorCode(error),
        Some(Response::Part { value: Seven(bytes), .. }) => Observation::Value(bytes.to_vec()),
        Some(Response::Unknown { .. }) => Observation::named("an unknown LMT response"),
    }
}

/// A breach of what LMT demands.
pub fn breach(duty: impl Into<String>) -> Breach {
    Breach::new(Service::Lmt, duty.into())
}

/// The error code of the answer to a configuration; `None` for any other answer.
pub fn error_of(response: Option<Response>, of: ConfigureCommand) -> Option<u8> {
    match response {
        Some(Response::Configured { command, error, .. }) if command == of => Some(error),
        _ => None,
    }
}

/// Demands a confirmation with an error code that is right.
pub fn expect_error(
    duty: impl Into<String>,
    expected: &'static str,
    of: ConfigureCommand,
    found: Option<Response>,
    right: impl FnOnce(u8) -> bool,
) -> Check {
    let error = error_of(found, of);
    demand(error.is_some_and(right), || {
        // A confirmation of another command says nothing by its error code.
        let actual = match found {
            Some(Response::Configured { .. }) if error.is_none() => {
                Observation::named("the confirmation of another command")
            }
            other => observed(other),
        };
        breach(duty).expected(expected).found(actual).told(shown(found))
    })
}

/// Demands that a message is not answered.
pub fn expect_silence(bench: &mut Bench<'_>, request: Request, when: &str) -> Judged {
    let response = tell(bench, request)?;
    bench.check(demand(response.is_none(), || {
        let breach = breach(format!("\"{request}\" is not answered {when}"));
        breach.expected(Observation::Silence).found(observed(response)).told(shown(response))
    }))
}

/// Whether the slave is in configuration: only then it answers inquiries.
pub fn is_configuring(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    let response = tell(bench, Request::Inquire { part: Part::ManufacturerName })?;
    Ok(matches!(response, Some(Response::Part { .. })))
}

/// Demands that inquiries are answered, or that they are not.
pub fn expect_configuring(bench: &mut Bench<'_>, configuring: bool, duty: impl Into<String>) -> Judged {
    let found = is_configuring(bench)?;
    bench.check(demand(found == configuring, || {
        let shown = |answers: bool| match answers {
            true => Observation::named("an answer to an inquiry"),
            false => Observation::Silence,
        };
        breach(duty).expected(shown(configuring)).found(shown(found))
    }))
}

/// Runs `judge` while the slave is in configuration, and leads it back to operation whatever comes of that.
pub fn in_configuration(bench: &mut Bench<'_>, judge: impl FnOnce(&mut Bench<'_>) -> Judged) -> Judged {
    tell(bench, Request::SwitchGlobal { mode: 1 })?;
    let judged = judge(bench);
    tell(bench, Request::SwitchGlobal { mode: 0 })?;
    judged
}

/// A part of the slave's address. Only in configuration.
pub fn inquire(bench: &mut Bench<'_>, part: Part) -> Result<Seven, Stop> {
    let response = exchange(bench, Request::Inquire { part })?;
    match response {
        Some(Response::Part { part: found, value }) if found == part => Ok(value),
        response => {
            let actual = match response {
                Some(Response::Part { .. }) => Observation::named("another part of the address"),
                other => observed(other),
            };
            let breach = breach(format!("in configuration the slave says its {}", part.name()));
            Err(Stop::from(Box::new(breach.expected("seven bytes").found(actual).told(shown(response)))))
        }
    }
}

/// The three parts of the slave's address, asked for in configuration; the slave is in operation afterwards.
pub fn address(bench: &mut Bench<'_>) -> Result<[Seven; 3], Stop> {
    let mut address = [Seven([0; 7]); 3];
    in_configuration(bench, |bench| {
        for (value, part) in address.iter_mut().zip(Part::ALL) {
            *value = inquire(bench, part).map_err(Stop::unreached)?;
        }
        Ok(())
    })?;
    Ok(address)
}

/// Another part of the same kind: the last byte differs, and is two decimal digits if it was.
pub fn other(value: Seven) -> Seven {
    let [a, b, c, d, e, f, last] = value.0;
    let last = if last & 0x0F == 0 { last | 1 } else { last & 0xF0 };
    Seven([a, b, c, d, e, f, last])
}
