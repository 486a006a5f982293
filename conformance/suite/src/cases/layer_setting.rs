//! What all LSS and LMT cases need: messages out and in, and what is made of an answer.

use crate::bench::Bench;
use crate::verdict::{Allowed, Breach, Check, Stop, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{
    ConfigureCommand, Dialect, MASTER_CAN_ID, Request, Response, SLAVE_CAN_ID,
};
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// A dialect, and how reports tell what its slaves say.
pub trait Observed: Dialect {
    /// Whose breaches they are.
    const SERVICE: Service;
    /// What a response is that the standard does not have.
    const UNKNOWN: &'static str;
    /// A part of an address.
    fn part(value: Self::Value) -> Observation;
}

/// Sends a message that the slave has to answer, and waits for its response; a slave may take seconds to store.
pub fn exchange<D: Dialect>(bench: &mut Bench<'_>, request: Request<D>) -> Result<Option<Response<D>>, Stop> {
    exchange_within(bench, request, bench.timing().lss)
}

/// Sends a message that nobody has to answer, and gives a response all the same if there is one.
pub fn tell<D: Dialect>(bench: &mut Bench<'_>, request: Request<D>) -> Result<Option<Response<D>>, Stop> {
    exchange_within(bench, request, bench.timing().silence)
}

/// Sends a message, and waits that long for a response.
pub fn exchange_within<D: Dialect>(
    bench: &mut Bench<'_>,
    request: Request<D>,
    span: Duration,
) -> Result<Option<Response<D>>, Stop> {
    bench.drain()?;
    bench.send(&request.to_frame(MASTER_CAN_ID))?;
    hear(bench, span)
}

/// The next response.
pub fn hear<D: Dialect>(bench: &mut Bench<'_>, span: Duration) -> Result<Option<Response<D>>, Stop> {
    bench.wait_for(span, |record| {
        let is_slave = record.frame.cob_id() == Some(SLAVE_CAN_ID);
        is_slave.then(|| Response::read(record.frame.data()).ok()).flatten()
    })
}

pub fn shown<D: Dialect>(response: Option<Response<D>>) -> String {
    response.map_or_else(|| "no answer".to_owned(), |response| response.to_string())
}

/// What a slave answered, as an observation: the error code, the node-ID, the part of its address.
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

/// Demands a confirmation with an error code that is right.
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
        // A confirmation of another command says nothing by its error code.
        let actual = match found {
            Some(Response::Configured { .. }) if error.is_none() => {
                Observation::named("the confirmation of another command")
            }
            other => observed(other),
        };
        Breach::new(D::SERVICE, duty.into()).expected(expected).found(actual).told(shown(found))
    })
}

/// Demands silence.
pub fn expect_silence<D: Observed>(duty: String, found: Option<Response<D>>) -> Check {
    demand(found.is_none(), || {
        let breach = Breach::new(D::SERVICE, duty).expected(Observation::Silence);
        breach.found(observed(found)).told(shown(found))
    })
}
