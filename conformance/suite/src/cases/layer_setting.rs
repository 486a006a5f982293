//! Shared functions of the LSS and LMT cases: sending and receiving messages, and the observations of answers.

use crate::bench::Bench;
use crate::verdict::{Allowed, Breach, Check, Stop, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{
    ConfigureCommand, Dialect, MASTER_CAN_ID, Request, Response, SLAVE_CAN_ID,
};
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// A dialect of layer setting, and the words for its responses in reports.
pub trait Observed: Dialect {
    /// The service of its breaches.
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
