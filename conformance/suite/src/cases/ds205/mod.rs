//! CiA DS-205: layer management (LMT), the forerunner of LSS. The standard is withdrawn and not public: what is demanded
//! here is what the manuals of such devices agree on, so no section is cited.
//!
//! All of it addresses every LMT slave on the bus, so the device must be alone.

mod configuration;
mod inquiry;
mod mode;
pub(crate) mod needs;

use crate::bench::Bench;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lmt::{self, Part, Request, Response, Seven};

/// Sends a message and waits for the slave's response.
fn exchange(bench: &mut Bench<'_>, request: Request) -> Result<Option<Response>, Stop> {
    bench.drain()?;
    bench.send(&request.to_frame(lmt::MASTER_CAN_ID))?;
    bench.wait_for(bench.timing().silence, |record| {
        let is_slave = record.frame.cob_id() == Some(lmt::SLAVE_CAN_ID);
        is_slave.then(|| Response::read(record.frame.data()).ok()).flatten()
    })
}

fn shown(response: Option<Response>) -> String {
    response.map_or_else(|| "no answer".to_owned(), |response| response.to_string())
}

/// Demands that a message is not answered.
fn expect_silence(bench: &mut Bench<'_>, request: Request, when: &str) -> Judged {
    let response = exchange(bench, request)?;
    bench.check(demand(response.is_none(), || {
        Reason::new(format!("\"{request}\" is not answered {when}"), "silence", shown(response))
    }))
}

/// Whether the slave is in configuration: only then it answers inquiries.
fn is_configuring(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    let response = exchange(bench, Request::Inquire { part: Part::ManufacturerName })?;
    Ok(matches!(response, Some(Response::Part { .. })))
}

/// Runs `judge` while the slave is in configuration, and leads it back to operation whatever comes of that.
fn in_configuration(bench: &mut Bench<'_>, judge: impl FnOnce(&mut Bench<'_>) -> Judged) -> Judged {
    exchange(bench, Request::SwitchGlobal { mode: 1 })?;
    let judged = judge(bench);
    exchange(bench, Request::SwitchGlobal { mode: 0 })?;
    judged
}

/// A part of the slave's address. Only in configuration.
fn inquire(bench: &mut Bench<'_>, part: Part) -> Result<Seven, Stop> {
    let response = exchange(bench, Request::Inquire { part })?;
    match response {
        Some(Response::Part { part: found, value }) if found == part => Ok(value),
        response => {
            let duty = format!("in configuration the slave says its {}", part.name());
            Err(Stop::from(Reason::new(duty, "seven bytes", shown(response))))
        }
    }
}

/// The three parts of the slave's address, asked for in configuration; the slave is in operation afterwards.
fn address(bench: &mut Bench<'_>) -> Result<[Seven; 3], Stop> {
    let mut address = [Seven([0; 7]); 3];
    in_configuration(bench, |bench| {
        for (value, part) in address.iter_mut().zip(Part::ALL) {
            *value = inquire(bench, part).or_inconclusive()?;
        }
        Ok(())
    })?;
    Ok(address)
}

/// Another part of the same kind: the last byte differs, and is two decimal digits if it was.
fn other(value: Seven) -> Seven {
    let [a, b, c, d, e, f, last] = value.0;
    let last = if last & 0x0F == 0 { last | 1 } else { last & 0xF0 };
    Seven([a, b, c, d, e, f, last])
}

/// After a case that could not go on: the node-ID and the bit rate in use are those that are configured.
///
/// # Errors
/// As [`Bench::wait_for`].
fn rescue(bench: &mut Bench<'_>, _stored: bool) -> Result<(), Stop> {
    in_configuration(bench, |bench| {
        configuration::configure_own(bench)?;
        configuration::configure_own_rate(bench)
    })
    .map(|_| ())
}
