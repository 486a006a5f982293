//! Shared functions of the LMT cases: reaching and proving modes, and the address of the slave.

use crate::bench::Bench;
use crate::cases::layer_setting::{self, Observed};
pub use crate::cases::layer_setting::{exchange, expect_error, observed, shown, tell};
use crate::verdict::{Breach, Judged, Stop, demand};
use canvass_analyzer::Service;
use canvass_analyzer::wire::lmt::{Lmt, Part, Request, Response, Seven};
use canvass_bus::observation::Observation;

impl Observed for Lmt {
    const SERVICE: Service = Service::Lmt;
    const UNKNOWN: &'static str = "an unknown LMT response";

    fn part(Seven(bytes): Seven) -> Observation {
        Observation::Value(bytes.to_vec())
    }
}

/// A breach of a requirement on LMT.
pub fn breach(duty: impl Into<String>) -> Breach {
    Breach::new(Service::Lmt, duty.into())
}

/// Requires that a message is not answered.
pub(crate) fn expect_silence(bench: &mut Bench<'_>, request: Request, when: &str) -> Judged {
    let response = tell(bench, request)?;
    bench.check(layer_setting::expect_silence(format!("\"{request}\" is not answered {when}"), response))
}

/// Whether the slave is in configuration: only then does it answer inquiries.
pub(crate) fn is_configuring(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    let response = tell(bench, Request::Inquire { part: Part::ManufacturerName })?;
    Ok(matches!(response, Some(Response::Part { .. })))
}

/// Requires that the slave answers inquiries, or that it does not.
pub(crate) fn expect_configuring(bench: &mut Bench<'_>, configuring: bool, duty: impl Into<String>) -> Judged {
    let found = is_configuring(bench)?;
    bench.check(demand(found == configuring, || {
        let shown = |answers: bool| match answers {
            true => Observation::named("an answer to an inquiry"),
            false => Observation::Silence,
        };
        breach(duty).expected(shown(configuring)).found(shown(found))
    }))
}

/// Runs `judge` while the slave is in configuration, and switches it back to operation, whatever the result.
pub(crate) fn in_configuration(bench: &mut Bench<'_>, judge: impl FnOnce(&mut Bench<'_>) -> Judged) -> Judged {
    tell(bench, Request::SwitchGlobal { mode: 1 })?;
    let judged = judge(bench);
    tell(bench, Request::SwitchGlobal { mode: 0 })?;
    judged
}

/// A part of the slave's address. The slave answers only in configuration.
pub fn inquire(bench: &mut Bench<'_>, part: Part) -> Result<Seven, Stop> {
    let response = exchange(bench, Request::Inquire { part })?;
    match response {
        Some(Response::Part { part: found, value }) if found == part => Ok(value),
        response => {
            let actual = match response {
                Some(Response::Part { .. }) => Observation::named("another part of the address"),
                other => observed(other),
            };
            let breach = breach(format!("in configuration the slave returns its {}", part.name()));
            Err(Stop::from(Box::new(breach.expected("seven bytes").found(actual).told(shown(response)))))
        }
    }
}

/// The three parts of the slave's address, read in configuration; the slave is in operation afterwards.
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

/// Another part of the same kind: the last byte differs, and remains two decimal digits if it had two decimal digits.
pub fn other(value: Seven) -> Seven {
    let [a, b, c, d, e, f, last] = value.0;
    let last = if last & 0x0F == 0 { last | 1 } else { last & 0xF0 };
    Seven([a, b, c, d, e, f, last])
}
