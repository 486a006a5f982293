//! RPDOs when the device leaves operational: their deadline, and values that wait for SYNC (CiA 301, 7.5.2.35).

use super::emcy::{emergencies, is_error, observed, shown};
use super::rpdo::{Subject, expect_value, operational, subject};
use crate::bench::Bench;
use crate::bench::pdo::RPDO;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record};

const DEADLINE_MS: u16 = 200;
const DEADLINE: Duration = Duration::from_millis(200);

/// Sets a deadline for RPDO 1, and makes the device operational.
fn with_deadline(bench: &mut Bench<'_>) -> Result<Subject, Stop> {
    let subject = subject(bench, 255)?;
    if !bench.can_write(RPDO.parameter(5))? {
        let reason = Reason::new("RPDO 1 has a deadline", "1400h:05", "the device has no 1400h:05 that can be written");
        return Err(Stop::NotApplicable(reason));
    }
    bench.set_pdo(RPDO, &[(5, &DEADLINE_MS.to_le_bytes())])?;
    bench.expect_emergencies();
    operational(bench)?;
    Ok(subject)
}

fn expect_none(bench: &mut Bench<'_>, duty: &'static str, heard: &[Record]) -> Judged {
    let code = |record: &Record| super::emcy::code_of(record);
    let late: Vec<Record> = heard
        .iter()
        .filter(|record| is_error(record) && code(record).is_some_and(|code| code == EmcyCode::RPDO_TIMEOUT))
        .cloned()
        .collect();
    bench.check(demand(late.is_empty(), || {
        let breach = Breach::new(RPDO.subject(), duty).expected("no EMCY 8250h");
        breach.found(observed(&late)).told(shown(&late))
    }))
}

/// The device does not report an RPDO that arrives within its deadline (event timer) as missing. It does not report an
/// RPDO as missing after it has left operational either, because it receives no RPDO there.
#[case(id = "301/rpdo/deadline-kept", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Should,
       needs = [RpdoMapping], catches = [RpdoDeadlineOutlivesStop, RpdoDeadlineNotRestarted, RpdoInPreOperational])]
fn deadline_kept(bench: &mut Bench<'_>) -> Judged {
    let subject = with_deadline(bench)?;
    let mut heard = Vec::new();
    for _ in 0..8 {
        bench.send_bytes(subject.can_id, &subject.before)?;
        heard.extend(emergencies(bench, Duration::from_millis(100))?);
    }
    expect_none(bench, "an RPDO that comes every 100 ms does not miss a deadline of 200 ms", &heard)?;
    bench.send_bytes(subject.can_id, &subject.before)?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    let heard = emergencies(bench, DEADLINE.times(4))?;
    expect_none(bench, "no RPDO is reported as missing in pre-operational", &heard)?;
    operational(bench)?;
    let heard = emergencies(bench, DEADLINE.times(4))?;
    expect_none(bench, "after the start an RPDO is reported as missing only if it was received again", &heard)
}

/// The case only records whether an RPDO value that waited for SYNC when the device left operational takes effect at a
/// SYNC after the next start, because CiA 301 does not define this.
#[case(id = "301/rpdo/held-over-stop", clause = "CiA 301 7.5.2.35", confidence = Cited, level = Open,
       needs = [RpdoMapping, Sync], catches = [RpdoHeldOverStop])]
fn held(bench: &mut Bench<'_>) -> Judged {
    bench.expect_plain_sync()?;
    let subject = subject(bench, 1)?;
    let sync_id = bench.sync_id()?;
    operational(bench)?;
    bench.send_bytes(subject.can_id, &subject.other)?;
    bench.listen(bench.shortly())?;
    bench.command(Command::ENTER_PRE_OPERATIONAL)?;
    operational(bench)?;
    bench.send_bytes(sync_id, &[])?;
    bench.listen(bench.shortly())?;
    let now = bench.read(subject.mapped.at)?;
    bench.check(demand(now == subject.before, || {
        let breach = Breach::new(
            subject.mapped.at,
            "a value that waits for SYNC is discarded when the device leaves operational",
        );
        breach.expected(Observation::Value(subject.before.clone())).found(Observation::Value(now.clone()))
    }))?;
    bench.send_bytes(subject.can_id, &subject.other)?;
    bench.send_bytes(sync_id, &[])?;
    bench.listen(bench.shortly())?;
    expect_value(bench, subject.mapped.at, &subject.other, "after the next start the RPDO takes effect at SYNC again")
}
