//! Shared functions of the LSS cases: requirements on answers, and reaching and proving states.

use super::needs::LSS_INQUIRY;
use crate::bench::Bench;
use crate::bench::Found;
use crate::cases::layer_setting::{self, Observed, exchange_within};
pub use crate::cases::layer_setting::{exchange, observed, shown, tell};
use crate::verdict::{Allowed, Breach, Check, Judged, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::SLAVE_CAN_ID;
use canvass_analyzer::wire::lss::{ConfigureCommand, Lss, Part, Request, Response};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Timestamp};

impl Observed for Lss {
    const SERVICE: Service = Service::Lss;
    const UNKNOWN: &'static str = "an unknown LSS response";

    fn part(value: u32) -> Observation {
        Observation::Number(value.into())
    }
}

/// A breach of a requirement on LSS.
pub fn breach(duty: impl Into<String>) -> Breach {
    Breach::new(Service::Lss, duty.into())
}

/// Requires a response.
pub fn expect(
    what: &str,
    expected: impl Into<Allowed>,
    found: Option<Response>,
    right: impl FnOnce(Response) -> bool,
) -> Check {
    demand(found.is_some_and(right), || {
        breach(format!("{what} is answered")).expected(expected).found(observed(found)).told(shown(found))
    })
}

/// Requires the confirmation of a configuration with one of these error codes; the best one first.
pub fn expect_error(what: &str, command: ConfigureCommand, allowed: &[u8], found: Option<Response>) -> Check {
    let expected = Allowed::OneOf(allowed.iter().copied().map(Observation::ErrorCode).collect());
    layer_setting::expect_error(format!("{what} is answered"), expected, command, found, |error| {
        allowed.contains(&error)
    })
}

/// Requires that a confirmation without specific error has no specific error code.
pub(crate) fn expect_plain(what: &str, found: Option<Response>) -> Check {
    demand(!found.is_some_and(Response::says_too_much), || {
        let breach = breach(format!("the response to {what} has a specific error code with error code 255 only"));
        breach.expected(Observation::named("specific error code 0")).found(observed(found)).told(shown(found))
    })
}

/// Requires silence.
pub(crate) fn expect_silence(what: &str, found: Option<Response>) -> Check {
    layer_setting::expect_silence(format!("{what} is not answered"), found)
}

/// Sets the pending node-ID of the device.
pub(crate) fn set_node_id(bench: &mut Bench<'_>, node_id: u8) -> Result<Option<Response>, Stop> {
    bench.gives_node_id(node_id);
    exchange(bench, Request::ConfigureNodeId { node_id })
}

/// The node-ID that the slave reports; `None` if it reports none.
pub fn node_id(bench: &mut Bench<'_>) -> Result<Option<u8>, Stop> {
    Ok(match exchange(bench, Request::InquireNodeId)? {
        Some(Response::NodeId(node)) => Some(node),
        _ => None,
    })
}

/// The node-IDs that the slave has reported since `begun`.
pub fn node_ids(bench: &Bench<'_>, begun: Timestamp) -> Vec<u8> {
    let heard = bench.heard_since(begun);
    let responses = heard.iter().filter(|record| record.frame.cob_id() == Some(SLAVE_CAN_ID));
    let responses = responses.filter_map(|record| Response::read(record.frame.data()).ok());
    responses.filter_map(|response| if let Response::NodeId(node) = response { Some(node) } else { None }).collect()
}

/// Brings the slave into configuration and checks it.
pub fn configure(bench: &mut Bench<'_>) -> Result<(), Stop> {
    tell(bench, Request::SwitchGlobal { mode: 1 })?;
    if is_configuring(bench, bench.timing().lss)? {
        return Ok(());
    }
    let duty = "switch state global switches the slave to configuration";
    Err(Stop::Inconclusive(Reason::new(duty, "an answer to an inquiry or to configure node-ID", "neither")))
}

/// Whether the slave is in configuration: it answers an inquiry or, without inquiry service, accepts its own node-ID.
fn is_configuring(bench: &mut Bench<'_>, patience: Duration) -> Result<bool, Stop> {
    let inquires = match bench.knowledge.known(LSS_INQUIRY.id) {
        Some(Found::Known(met)) => Some(met.is_ok()),
        _ => None,
    };
    if inquires != Some(false) {
        let answer = exchange_within(bench, Request::InquireNodeId, patience)?;
        if matches!(answer, Some(Response::NodeId(node)) if node != 0) {
            bench.knowledge.learned(LSS_INQUIRY.id, Found::Known(Ok(())));
            return Ok(true);
        }
        if inquires == Some(true) {
            return Ok(false);
        }
    }
    let own = Request::ConfigureNodeId { node_id: bench.node().raw() };
    let answer = exchange_within(bench, own, patience)?;
    let takes = match answer {
        Some(Response::Configured { command: of @ ConfigureCommand::NodeId, error, .. }) => {
            of.error_name::<Lss>(error).is_some()
        }
        _ => false,
    };
    if takes && inquires.is_none() {
        let why = "in configuration the slave confirms its node-ID (11h) and does not answer an inquiry of it (5Eh)";
        bench.knowledge.learned(LSS_INQUIRY.id, Found::Known(Err(why.to_owned())));
    }
    Ok(takes)
}

/// Ends configuration. Pending values may make the device restart.
pub fn wait(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.watch_restart();
    tell(bench, Request::SwitchGlobal { mode: 0 }).map(|_| ())
}

/// Requires that the slave is in configuration.
pub(crate) fn expect_configuration(bench: &mut Bench<'_>, after: &str) -> Judged {
    let there = is_configuring(bench, bench.timing().lss)?;
    bench.check(demand(there, || {
        let breach = breach(format!("the slave is in configuration after {after}"));
        breach.expected("an answer to an inquiry").found(Observation::Silence)
    }))
}

/// Requires that the slave is in waiting.
pub(crate) fn expect_waiting(bench: &mut Bench<'_>, after: &str) -> Judged {
    let there = is_configuring(bench, bench.timing().silence)?;
    bench.check(demand(!there, || {
        let breach = breach(format!("the slave is in waiting after {after}"));
        breach.expected(Observation::Silence).found(Observation::named("an answer of the configuration state"))
    }))
}

/// The LSS address read by SDO: 1018h:01 to 04.
pub fn address(bench: &mut Bench<'_>) -> Result<[u32; 4], Stop> {
    let mut address = [0; 4];
    for (sub, part) in (1..).zip(&mut address) {
        *part = bench.read_number(Multiplexer::new(object::IDENTITY, sub))?;
    }
    Ok(address)
}

/// Sends the four parts in this order; returns the responses, the last of them within `patience`.
pub fn select(bench: &mut Bench<'_>, parts: &[(Part, u32)], patience: Duration) -> Result<Vec<Response>, Stop> {
    let mut heard = Vec::new();
    for (n, &(part, value)) in parts.iter().enumerate() {
        let span = if n + 1 == parts.len() { patience } else { bench.timing().silence };
        heard.extend(exchange_within(bench, Request::SwitchSelective { part, value }, span)?);
    }
    Ok(heard)
}

/// Requires exactly this response, or none.
pub(crate) fn expect_heard(duty: String, expected: Option<Response>, heard: &[Response]) -> Check {
    demand(heard == expected.as_slice(), || {
        let actual = match heard {
            [] => Observation::Silence,
            [one] => observed(Some(*one)),
            more => Observation::Count(more.len() as u64),
        };
        let told = heard.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let breach = breach(duty).expected(observed(expected)).found(actual);
        if heard.is_empty() { breach } else { breach.told(told) }
    })
}

/// The four parts of the address in their order.
pub fn parts(address: [u32; 4]) -> Vec<(Part, u32)> {
    Part::ALL.into_iter().zip(address).collect()
}
