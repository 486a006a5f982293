//! Life guarding: a guarded device reports the loss of its master after 100Ch times 100Dh (CiA 301, 7.2.8.2.2.2).
//!
//! If 100Ch and 100Dh can't be written, the cases use the device's own life time.

use super::emcy::{code_of, patience};
use super::error_behaviour::after_a_loss;
use crate::bench::Bench;
use crate::bench::state::{GUARD_TIME, LIFE_TIME_FACTOR};
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::object;
use canvass_analyzer::wire::emcy::{self, EmcyCode};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Timestamp};

const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);

/// Guard time in milliseconds, times life time factor.
#[derive(Clone, Copy)]
struct LifeTime {
    guard: Duration,
    factor: u64,
    /// Whether 100Ch and 100Dh can be written. They are read-only if the device does not support life guarding.
    is_settable: bool,
}

impl LifeTime {
    fn whole(self) -> Duration {
        self.guard.times(self.factor)
    }
}

/// Sets the life time if the device allows it; returns the actual life time.
fn life_time(bench: &mut Bench<'_>, guard_ms: u16, factor: u8) -> Result<LifeTime, Stop> {
    bench.expect_emergencies();
    bench.prefer_guarding()?;
    let is_settable = bench.can_write(GUARD_TIME)? && bench.can_write(LIFE_TIME_FACTOR)?;
    if is_settable {
        bench.write(GUARD_TIME, &guard_ms.to_le_bytes())?;
        bench.write(LIFE_TIME_FACTOR, &[factor])?;
    }
    let guard = Duration::from_millis(u64::from(bench.read_number(GUARD_TIME)?));
    let life_time = LifeTime { guard, factor: u64::from(bench.read_number(LIFE_TIME_FACTOR)?), is_settable };
    if life_time.whole() == Duration::ZERO {
        let reason =
            Reason::new("the device can monitor its master", "100Ch and 100Dh other than 0", "0, and read-only");
        return Err(Stop::NotApplicable(reason));
    }
    Ok(life_time)
}

/// An EMCY that is no "error reset", with its time.
type Report = (Timestamp, EmcyCode);

/// The next EMCY that is no "error reset"; `None` if none comes.
fn next_error(bench: &mut Bench<'_>, span: Duration) -> Result<Option<Report>, Stop> {
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    bench.wait_for(span, |record| {
        let code = (record.frame.cob_id() == Some(cob_id)).then(|| code_of(record)).flatten()?;
        (!code.is_reset()).then_some((record.timestamp, code))
    })
}

/// Guards once; returns the time.
fn guard(bench: &mut Bench<'_>) -> Result<Timestamp, Stop> {
    let state = bench.guard()?;
    demand(state.is_some(), || {
        let breach = Breach::new(Service::Guarding, "guarding is answered").expected("a state");
        breach.found(Observation::Silence)
    })
    .or_inconclusive()?;
    Ok(bench.now())
}

fn operational(bench: &mut Bench<'_>) -> Result<(), Stop> {
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction).map(|_| ())
}

/// Requires that there is no sign of a lost master: no EMCY, and an unchanged state.
fn not_missed(bench: &mut Bench<'_>, duty: &str, lost: Option<Report>) -> Judged {
    let state = bench.guard()?;
    let found = match (lost, state) {
        (Some((_, code)), _) => Observation::Emcy(code),
        (None, Some(state)) if state != State::OPERATIONAL => Observation::State(state),
        _ => return Ok(()),
    };
    let breach = Breach::new(Service::Guarding, duty.to_owned()).expected("no EMCY, and the state operational");
    bench.check(Err(Box::new(breach.found(found))))
}

/// If the life time can't be set, only the behaviour of the device shows whether it monitors its master.
fn watches_at_all(life_time: LifeTime, found: &Observation) -> Judged {
    if life_time.is_settable || *found != Observation::State(State::OPERATIONAL) {
        return Ok(());
    }
    let reason = Reason::new("the device monitors its master", "writable 100Ch and 100Dh, or a reaction", "neither");
    Err(Stop::NotApplicable(reason))
}

/// When a master that has guarded the device falls silent, the device detects the loss after guard time multiplied by
/// life time factor. An operational device then leaves operational, unless 1029h:01 demands otherwise; an EMCY that
/// reports the loss comes at that time.
#[case(id = "301/life-guarding/time", clause = "CiA 301 7.2.8.3.2.1", confidence = Cited, level = Must,
       needs = [Guarding], catches = [LifeTimeFactorOffByOne, LifeTimeFactorIgnored], cct = "7.6")]
fn time(bench: &mut Bench<'_>) -> Judged {
    let life_time = life_time(bench, 500, 3)?;
    let enters = after_a_loss(bench)?;
    operational(bench)?;
    let from = guard(bench)?;
    let (whole, half) = (life_time.whole(), Duration::from_nanos(life_time.guard.nanos() / 2));
    let lost = next_error(bench, whole + half)?;
    if let Some((lost, _)) = lost {
        let after = lost.since(from);
        return bench.check(demand(after.nanos().abs_diff(whole.nanos()) <= half.nanos(), || {
            let least = Duration::from_nanos(whole.nanos().saturating_sub(half.nanos()));
            Breach::new(LIFE_TIME_FACTOR, "the loss of the master is reported after the life time")
                .expected(Allowed::Time { least, most: whole + half })
                .found(Observation::Time(after))
        }));
    }
    let found = bench.guard()?.map_or(Observation::Silence, Observation::State);
    let Some(right) = enters else {
        let reason = Reason::new("the loss of the master is visible", "an EMCY, or 1029h:01 of 0 or 2", "neither");
        return Err(Stop::Inconclusive(reason));
    };
    watches_at_all(life_time, &found)?;
    bench.check(demand(found == Observation::State(right), || {
        let duty = format!("an operational device whose master is silent for {whole} becomes {right}");
        Breach::new(LIFE_TIME_FACTOR, duty).expected(Observation::State(right)).found(found)
    }))
}

/// An operational device that loses its master enters pre-operational, unless 1029h:01 demands otherwise.
#[case(id = "301/life-guarding/state", clause = "CiA 301 7.5.2.32", confidence = Cited, level = Must,
       needs = [Guarding], catches = [ErrorBehaviourIgnored], cct = "9.3")]
fn state(bench: &mut Bench<'_>) -> Judged {
    let life_time = life_time(bench, 100, 2)?;
    let Some(right) = after_a_loss(bench)? else {
        let reason =
            Reason::new("the device leaves operational on an error", "1029h:01 of 0 or 2", "another value, read-only");
        return Err(Stop::NotApplicable(reason));
    };
    operational(bench)?;
    guard(bench)?;
    bench.listen(life_time.whole() + life_time.guard)?;
    let found = bench.guard()?.map_or(Observation::Silence, Observation::State);
    watches_at_all(life_time, &found)?;
    bench.check(demand(found == Observation::State(right), || {
        let breach = Breach::new(Service::Guarding, "a device that has lost its master leaves operational");
        breach.expected(Observation::State(right)).found(found)
    }))
}

/// When the master guards again, the device reports the end of the error by EMCY 0000h, and the error register has its
/// previous value.
#[case(id = "301/life-guarding/recovery", clause = "CiA 301 7.2.7.1", confidence = Cited, level = Must,
       needs = [Guarding], catches = [ErrorRegisterStuck, EmcyResetMissing])]
fn recovery(bench: &mut Bench<'_>) -> Judged {
    // Other, permanent errors of the device do not matter in this case.
    let before = bench.read(ERROR_REGISTER)?;
    let patience = patience(bench)?;
    // Longer than an EMCY may take: the master must not be lost again meanwhile.
    let life_time = life_time(bench, 1_000, 2)?;
    guard(bench)?;
    let Some((lost, _)) = next_error(bench, life_time.whole() + life_time.guard)? else {
        return Err(Stop::Inconclusive(Reason::new("the loss of the master is reported", "an EMCY", "none")));
    };
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    bench.guard()?;
    bench.listen(patience.min(Duration::from_millis(800)))?;
    // The EMCY may come before the answer to the remote frame: the case judges the register, and that the device
    // reported it.
    let register = bench.read(ERROR_REGISTER)?;
    bench.check(demand(register == before, || {
        Breach::new(ERROR_REGISTER, "the error register has its previous value when the error is gone")
            .expected(Observation::Value(before.clone()))
            .found(Observation::Value(register))
    }))?;
    if before != [0] {
        return Ok(());
    }
    let said = bench.evidence().frames().any(|exhibit| {
        let record = &exhibit.record;
        let is_reset = code_of(record).is_some_and(EmcyCode::is_reset);
        record.timestamp > lost && record.frame.cob_id() == Some(cob_id) && is_reset
    });
    bench.check(demand(said, || {
        Breach::new(Service::Emcy, "the end of a reported error is reported")
            .expected(Observation::Emcy(EmcyCode::NO_ERROR))
            .found(Observation::Silence)
    }))
}

/// With a guard time or life time factor of 0 the device does not monitor its master.
#[case(id = "301/life-guarding/off", clause = "CiA 301 7.5.2.11", confidence = Cited, level = Must,
       needs = [Guarding], catches = [LifeGuardingNotStopped], cct = "7.1")]
fn off(bench: &mut Bench<'_>) -> Judged {
    if !bench.can_write(GUARD_TIME)? || !bench.can_write(LIFE_TIME_FACTOR)? {
        let reason = Reason::new("life guarding can be switched off", "writable 100Ch and 100Dh", "a read-only one");
        return Err(Stop::NotApplicable(reason));
    }
    bench.each([(GUARD_TIME, &[0, 0][..]), (LIFE_TIME_FACTOR, &[0][..])], |bench, (multiplexer, zero)| {
        // Longer than a slow server takes to confirm the write.
        let life_time = life_time(bench, 1_000, 3)?;
        operational(bench)?;
        guard(bench)?;
        bench.write(multiplexer, zero)?;
        let lost = next_error(bench, life_time.whole() + life_time.guard)?;
        not_missed(bench, &format!("with {multiplexer} = 0 the master is not monitored"), lost)
    })
}

/// The device monitors its master from the first remote frame on: before that frame it reports no loss.
#[case(id = "301/life-guarding/first-request", clause = "CiA 301 7.2.8.2.2", confidence = Cited, level = Must,
       needs = [Guarding], catches = [LifeGuardingStartsAtOnce])]
fn first_request(bench: &mut Bench<'_>) -> Judged {
    // A guarding request before the case may have started the monitoring: a reset ends it.
    bench.reset(Command::RESET_COMMUNICATION)?;
    let life_time = life_time(bench, 100, 2)?;
    operational(bench)?;
    let lost = next_error(bench, life_time.whole().times(2))?;
    not_missed(bench, "a master that has not guarded yet is not reported as lost", lost)
}
