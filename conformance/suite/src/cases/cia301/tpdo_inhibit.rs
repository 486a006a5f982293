//! The effect of the inhibit time of a TPDO (CiA 301, 7.5.2.37).

use super::tpdo_events::{Subject, operational, subject};
use crate::bench::Bench;
use crate::bench::pdo::TPDO;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Lack, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::Request;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record};

const INHIBIT: Duration = Duration::from_millis(300);
/// The inhibit time in units of 100 µs.
const UNITS: u16 = 3_000;

/// If the device sends a TPDO whenever its value changes, it sends a change within the inhibit time after that time;
/// otherwise consumers would keep the old value. CiA 301 says that the inhibit time delays a transmission, but not that
/// it cancels one.
#[case(id = "301/tpdo/inhibit-pending", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Should,
       needs = [Changeable], catches = [TpdoLostWhenInhibited])]
fn pending(bench: &mut Bench<'_>) -> Judged {
    let subject = inhibited(bench)?;
    let [before, other] = &subject.values;
    let first = change(bench, subject.at, other, subject.can_id)?;
    if !has(&first, other) {
        return Err(sends_no_change_at_once(bench, &subject)?);
    }
    let mut heard = change(bench, subject.at, before, subject.can_id)?;
    heard.extend(bench.frames_of(subject.can_id, INHIBIT.times(2))?);
    bench.check(demand(has(&heard, before), || {
        let found = heard.last().map_or(Observation::Silence, |record| Observation::Value(record.data().to_vec()));
        Breach::new(TPDO.subject(), "a value that changed within the inhibit time is sent after it")
            .expected(Observation::Value(before.clone()))
            .found(found)
    }))
}

/// The reason why a change was not sent at once: the device sends no TPDO on a change, or it is late.
fn sends_no_change_at_once(bench: &mut Bench<'_>, subject: &Subject) -> Result<Stop, Stop> {
    /// A device without processor time is late by up to some seconds.
    const PATIENCE: Duration = Duration::from_secs(2);
    let later = bench.frames_of(subject.can_id, PATIENCE)?;
    let [_, other] = &subject.values;
    let reason = |found| Reason::new("a change of its value sends TPDO 1", "a TPDO with the new value at once", found);
    Ok(match has(&later, other) {
        true => Stop::Inconclusive(reason("it came late").for_lack_of(Lack::Promptness)),
        false => Stop::NotApplicable(reason("none")),
    })
}

/// A TPDO that waited for its inhibit time is sent once. If the device sent no TPDO without a change, it sends no
/// further TPDO afterwards.
#[case(id = "301/tpdo/inhibit-once", clause = "CiA 301 7.5.2.37", confidence = Cited, level = Should,
       needs = [Changeable], catches = [TpdoRepeatsAfterInhibit])]
fn once(bench: &mut Bench<'_>) -> Judged {
    let subject = inhibited(bench)?;
    let before = bench.frames_of(subject.can_id, INHIBIT.times(4))?;
    if !before.is_empty() {
        let reason = Reason::new("only changes send TPDO 1", "silence without a change", "a TPDO");
        return Err(Stop::NotApplicable(reason));
    }
    let [first, other] = &subject.values;
    change(bench, subject.at, other, subject.can_id)?;
    change(bench, subject.at, first, subject.can_id)?;
    bench.listen(INHIBIT.times(2))?;
    bench.drain()?;
    let after = bench.frames_of(subject.can_id, INHIBIT.times(4))?;
    bench.check(demand(after.is_empty(), || {
        let breach = Breach::new(TPDO.subject(), "a TPDO that had to wait for the inhibit time is sent once");
        let expected = Allowed::Count { least: 0, most: Some(0) };
        breach.expected(expected).found(Observation::Count(after.len() as u64))
    }))
}

/// Maps a changeable object in TPDO 1, sent on change, sets the inhibit time, and waits until it has passed after the
/// start: TPDOs of the start must not delay the first change.
fn inhibited(bench: &mut Bench<'_>) -> Result<Subject, Stop> {
    let subject = subject(bench, 254)?;
    if !bench.can_write(TPDO.parameter(3))? {
        let reason = Reason::new("TPDO 1 has an inhibit time", TPDO.parameter(3).to_string(), "absent or read-only");
        return Err(Stop::NotApplicable(reason));
    }
    bench.set_pdo(TPDO, &[(3, &UNITS.to_le_bytes())])?;
    operational(bench)?;
    bench.listen(INHIBIT.times(2))?;
    Ok(subject)
}

/// Writes the value, and returns the TPDOs that come with it. The TPDO may be faster than the confirmation.
fn change(bench: &mut Bench<'_>, at: Multiplexer, value: &[u8], can_id: u16) -> Result<Vec<Record>, Stop> {
    const AT_ONCE: Duration = Duration::from_millis(100);
    bench.drain()?;
    bench.send_request(&Request::download(at, value))?;
    bench.frames_of(can_id, AT_ONCE)
}

fn has(heard: &[Record], value: &[u8]) -> bool {
    heard.iter().any(|record| record.data() == value)
}
