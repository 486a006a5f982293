//! The services that work in each NMT state (CiA 301, 7.3.2.2).

use crate::bench::Bench;
use crate::bench::state::command_to;
use crate::case;
use crate::verdict::{Breach, Judged, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::sdo::Request;
use canvass_bus::observation::Observation;

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);

/// The SDO server sends no response in stopped, not even an abort.
#[case(id = "301/state/stopped/sdo", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       catches = [SdoAnsweredWhenStopped, SdoRequestKeptOverStop], cct = "9.4")]
fn stopped_sdo(bench: &mut Bench<'_>) -> Judged {
    // An answer before the command proves that silence after it is significant.
    bench.read(DEVICE_TYPE)?;
    if let Some(stop) = command_to(State::STOPPED) {
        bench.command(stop)?;
    }
    bench.listen(bench.timing().reaction)?;
    let reply = bench.send_unanswered(&Request::upload(DEVICE_TYPE), "upload of 1000h:00 in stopped")?;
    bench.check(reply.expect_silence())?;
    // The server must not keep the request and answer it later, either.
    if let Some(start) = command_to(State::OPERATIONAL) {
        bench.command(start)?;
    }
    let late = bench.wait_for_late_response()?;
    bench.check(demand(late.is_none(), || {
        Breach::new(
            DEVICE_TYPE,
            "a request that was sent in stopped stays unanswered after the device has left stopped",
        )
        .expected(Observation::Silence)
        .found(Observation::named("an answer after stopped"))
        .told(late.map(|frame| frame.to_string()).unwrap_or_default())
    }))
}

/// The SDO server answers in pre-operational and in operational.
#[case(id = "301/state/operational/sdo", clause = "CiA 301 7.3.2.2.5", confidence = Cited, level = Must,
       catches = [SdoSilentWhenOperational], cct = "9.2")]
fn operational_sdo(bench: &mut Bench<'_>) -> Judged {
    bench.each([State::PRE_OPERATIONAL, State::OPERATIONAL], |bench, state| {
        if let Some(command) = command_to(state) {
            bench.command(command)?;
        }
        bench.listen(bench.timing().reaction)?;
        let mut attempt = bench.upload(DEVICE_TYPE)?;
        attempt.what = format!("{} in {state}", attempt.what);
        attempt.value()?;
        Ok(())
    })
}
