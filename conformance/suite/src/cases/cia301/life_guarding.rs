//! Life guarding: a device that was guarded misses its master after 100Ch times 100Dh (CiA 301, 7.2.8.2.2.2).
//!
//! Where 100Ch and 100Dh can't be written, the life time that the device has is used.

use crate::bench::Bench;
use crate::bench::state::GUARD_TIME;
use crate::case;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::sdo::Bytes;
use canvass_traces::{Duration, Timestamp};

const LIFE_TIME_FACTOR: Multiplexer = Multiplexer::new(0x100D, 0);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(0x1001, 0);
const ERROR_BEHAVIOUR: Multiplexer = Multiplexer::new(0x1029, 1);

/// Guard time in milliseconds, times life time factor.
#[derive(Clone, Copy)]
struct LifeTime {
    guard: Duration,
    factor: u64,
}

impl LifeTime {
    fn whole(self) -> Duration {
        self.guard.times(self.factor)
    }
}

/// Sets the life time, where the device lets it be set, and says what it is.
fn life_time(bench: &mut Bench<'_>, guard_ms: u16, factor: u8) -> Result<LifeTime, Stop> {
    bench.expect_emergencies();
    bench.prefer_guarding()?;
    if bench.can_write(GUARD_TIME)? && bench.can_write(LIFE_TIME_FACTOR)? {
        bench.write(GUARD_TIME, &guard_ms.to_le_bytes())?;
        bench.write(LIFE_TIME_FACTOR, &[factor])?;
    }
    let guard = Duration::from_millis(u64::from(bench.read_number(GUARD_TIME)?));
    let life_time = LifeTime { guard, factor: u64::from(bench.read_number(LIFE_TIME_FACTOR)?) };
    if life_time.whole() == Duration::ZERO {
        let reason = Reason::new("the device can watch its master", "100Ch and 100Dh other than 0", "0, and read-only");
        return Err(Stop::NotApplicable(reason));
    }
    Ok(life_time)
}

/// When the next EMCY comes that is no "error reset", if one does.
fn next_error(bench: &mut Bench<'_>, span: Duration) -> Result<Option<Timestamp>, Stop> {
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    bench.wait_for(span, |record| {
        let is_ours = record.frame.cob_id() == Some(cob_id);
        let code = is_ours.then(|| Emcy::read(record.frame.data()).ok()).flatten().and_then(|emcy| emcy.code())?;
        (!code.is_reset()).then_some(record.timestamp)
    })
}

/// Guards once; says when.
fn guard(bench: &mut Bench<'_>) -> Result<Timestamp, Stop> {
    let state = bench.guard()?;
    demand(state.is_some(), || Reason::new("guarding is answered", "a state", "no answer")).or_inconclusive()?;
    Ok(bench.now())
}

/// A master that has guarded once and then falls silent is reported by an EMCY after guard time times life time factor.
#[case(id = "301/life-guarding/time", clause = "CiA 301 7.2.8.2.2.2", confidence = Attested, level = Must,
       needs = [Guarding], catches = [LifeTimeFactorOffByOne, LifeTimeFactorIgnored, LifeGuardingUnreported, HeartbeatConsumerSilent], cct = "7.6")]
fn time(bench: &mut Bench<'_>) -> Judged {
    let life_time = life_time(bench, 500, 3)?;
    let from = guard(bench)?;
    let lost = next_error(bench, life_time.whole() + life_time.guard.times(2))?;
    let (whole, half) = (life_time.whole(), Duration::from_nanos(life_time.guard.nanos() / 2));
    let is_right = lost.is_some_and(|lost| lost.since(from).nanos().abs_diff(whole.nanos()) <= half.nanos());
    bench.check(demand(is_right, || {
        let actual = lost.map_or_else(|| "no EMCY".to_owned(), |lost| format!("after {}", lost.since(from)));
        Reason::new("the loss of the master is reported", format!("an EMCY after {whole} ± {half}"), actual)
    }))
}

/// A device that is operational when its master is lost becomes pre-operational, unless 1029h:01 says otherwise.
#[case(id = "301/life-guarding/state", clause = "CiA 301 7.2.8.2.2.2", confidence = Attested, level = Must,
       needs = [Guarding], catches = [ErrorBehaviourIgnored], cct = "9.3")]
fn state(bench: &mut Bench<'_>) -> Judged {
    let life_time = life_time(bench, 100, 2)?;
    if bench.can_write(ERROR_BEHAVIOUR)? {
        bench.write(ERROR_BEHAVIOUR, &[0])?;
    }
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    guard(bench)?;
    bench.listen(life_time.whole() + life_time.guard)?;
    let found = bench.guard()?;
    bench.check(demand(found == Some(State::PRE_OPERATIONAL), || {
        let actual = found.map_or_else(|| "no answer".to_owned(), |state| state.to_string());
        Reason::new("a device that has lost its master leaves operational", State::PRE_OPERATIONAL.to_string(), actual)
    }))
}

/// When the master guards again, EMCY 0000h says that the error is gone, and the error register is 0.
#[case(id = "301/life-guarding/recovery", clause = "CiA 301 7.2.7", confidence = Attested, level = Must,
       needs = [Guarding], catches = [ErrorRegisterStuck, EmcyResetMissing])]
fn recovery(bench: &mut Bench<'_>) -> Judged {
    // Another error that the device has all the time is not the matter of this case.
    let before = bench.read(ERROR_REGISTER)?;
    let life_time = life_time(bench, 100, 2)?;
    guard(bench)?;
    let lost = next_error(bench, life_time.whole() + life_time.guard)?;
    demand(lost.is_some(), || Reason::new("the loss of the master is reported", "an EMCY", "none"))
        .or_inconclusive()?;
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    bench.guard()?;
    // The EMCY may come before the answer to the remote frame: what is judged is the register, and that it was said.
    let register = bench.read(ERROR_REGISTER)?;
    demand(register == before, || {
        let duty = "the error register is as before when the error is gone";
        Reason::new(duty, Bytes(&before).to_string(), Bytes(&register).to_string())
    })?;
    if before != [0] {
        return Ok(());
    }
    let said = bench.evidence().frames().any(|exhibit| {
        let frame = &exhibit.record.frame;
        let is_late = lost.is_some_and(|lost| exhibit.record.timestamp > lost);
        let emcy = Emcy::read(frame.data()).ok().and_then(|emcy| emcy.code());
        is_late && frame.cob_id() == Some(cob_id) && emcy.is_some_and(emcy::EmcyCode::is_reset)
    });
    bench.check(demand(said, || Reason::new("the end of the error is reported", "EMCY 0000h", "none")))
}

/// With a guard time or life time factor of 0 the master is not watched; guarding is answered all the same.
#[case(id = "301/life-guarding/off", clause = "CiA 301 7.2.8.2.2.2", confidence = Attested, level = Must,
       needs = [Guarding], catches = [GuardingSilentWhenOff, LifeGuardingNotStopped], cct = "7.1")]
fn off(bench: &mut Bench<'_>) -> Judged {
    if !bench.can_write(GUARD_TIME)? || !bench.can_write(LIFE_TIME_FACTOR)? {
        let reason = Reason::new("life guarding can be switched off", "100Ch and 100Dh rw", "ro");
        return Err(Stop::NotApplicable(reason));
    }
    for (multiplexer, zero) in [(GUARD_TIME, &[0, 0][..]), (LIFE_TIME_FACTOR, &[0][..])] {
        let life_time = life_time(bench, 100, 2)?;
        guard(bench)?;
        bench.write(multiplexer, zero)?;
        let state = bench.guard()?;
        demand(state.is_some(), || {
            Reason::new(format!("with {multiplexer} = 0 guarding is answered"), "a state", "no answer")
        })?;
        let lost = next_error(bench, life_time.whole().times(3))?;
        demand(lost.is_none(), || {
            Reason::new(format!("with {multiplexer} = 0 the master is not watched"), "no EMCY", "an EMCY")
        })?;
    }
    Ok(())
}

/// The master is watched from its first remote frame on: before that it can't be lost.
#[case(id = "301/life-guarding/first-request", clause = "CiA 301 7.2.8.2.2.2", confidence = Attested, level = Must,
       needs = [Guarding], catches = [LifeGuardingStartsAtOnce])]
fn first_request(bench: &mut Bench<'_>) -> Judged {
    // What showed the state before the case was a request: a reset forgets it.
    bench.reset(Command::RESET_COMMUNICATION)?;
    let life_time = life_time(bench, 100, 2)?;
    let lost = next_error(bench, life_time.whole().times(2))?;
    bench.check(demand(lost.is_none(), || {
        Reason::new("a master that has not guarded yet is not missed", "no EMCY", "an EMCY")
    }))
}
