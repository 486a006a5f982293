//! Configuration and activation of the bit timing (CiA 305, 6.4.3 and 6.4.4).

use super::dialogue::{breach, configure, exchange, expect_error, expect_plain, wait};
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::{RESTART, bit_rate};
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lss::{ConfigureCommand, Lss, MASTER_CAN_ID, Request, Response};
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// The slave confirms the bit rates of the standard table that the description names, and refuses all others with error
/// code 1.
#[case(id = "305/bit-timing/table", clause = "CiA 305 6.4.3", confidence = Attested, level = Must,
       needs = [Lss, Alone, Description], touches = [BitRate], catches = [LssBitTimingRefused])]
fn table(bench: &mut Bench<'_>) -> Judged {
    let rates: Vec<u32> = bench.target().description.as_ref().map_or_else(Vec::new, |description| {
        description.device.bit_rates.iter().map(|kbit| u32::from(*kbit) * 1_000).collect()
    });
    let current = bench.bit_rate();
    configure(bench)?;
    let mut answers = Vec::new();
    for index in (0..=8_u8).filter(|&index| index != 5) {
        answers.push((index, exchange(bench, Request::ConfigureBitTiming { table: 0, index })?));
    }
    leave_bit_rate(bench, current)?;
    let is_refused = |answer: &Option<Response>| {
        matches!(answer, Some(Response::Configured { command: ConfigureCommand::BitTiming, error: 1, .. }))
    };
    // A device with a single bit rate has nothing to configure, and may refuse even that bit rate.
    if rates.len() == 1 && answers.iter().all(|(_, answer)| is_refused(answer)) {
        return Ok(());
    }
    bench.each(answers, |bench, (index, answer)| {
        let has = Lss::bit_rate(index).is_some_and(|rate| rates.contains(&rate));
        let what = format!("bit timing {index} of table 0, which the device {},", if has { "has" } else { "has not" });
        bench.check(expect_plain(&what, answer))?;
        bench.check(expect_error(&what, ConfigureCommand::BitTiming, &[u8::from(!has)], answer))
    })
}

/// The slave refuses reserved tables and reserved rows of the bit timing table with error code 1.
#[case(id = "305/bit-timing/reserved", clause = "CiA 305 6.4.3", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [BitRate], catches = [LssBitTimingUnchecked, LssBitTimingWrongCode])]
fn reserved(bench: &mut Bench<'_>) -> Judged {
    let current = bench.bit_rate();
    configure(bench)?;
    bench.each([(0, 5), (0, 10), (0, 255), (1, 0), (127, 0)], |bench, (table, index)| {
        let answer = exchange(bench, Request::ConfigureBitTiming { table, index })?;
        let what = format!("the reserved bit timing {index} of table {table}");
        bench.check(expect_error(&what, ConfigureCommand::BitTiming, &[1], answer))
    })?;
    leave_bit_rate(bench, current)
}

/// Replaces the pending bit rate by the one in use, and ends configuration.
fn leave_bit_rate(bench: &mut Bench<'_>, current: Option<u32>) -> Result<(), Stop> {
    if let Some(index) = current.and_then(Lss::bit_rate_index) {
        exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    }
    wait(bench)
}

/// After activate bit timing the slave is silent for two delays: before and after the change.
#[case(id = "305/bit-timing/activate", clause = "CiA 305 6.4.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [BitRate], catches = [LssActivatesAtOnce])]
fn activate(bench: &mut Bench<'_>) -> Judged {
    const DELAY_MS: u16 = 300;
    let delay = Duration::from_millis(u64::from(DELAY_MS));
    let Some(index) = bench.bit_rate().and_then(Lss::bit_rate_index) else {
        let found = bench.bit_rate().map_or_else(|| "it is not known".to_owned(), |rate| format!("{rate} bit/s"));
        let reason = Reason::new("the bit rate of the bus is in table 0", "one of CiA 305", found);
        return Err(Stop::NotApplicable(reason));
    };
    // The bit rate is the one in use, so that no other node has to change its bit rate.
    bench.show_state()?;
    configure(bench)?;
    let answer = exchange(bench, Request::ConfigureBitTiming { table: 0, index })?;
    if matches!(answer, Some(Response::Configured { command: ConfigureCommand::BitTiming, error: 1, .. })) {
        wait(bench)?;
        let found = "error code 1: it does not support its current bit rate";
        return Err(Stop::NotApplicable(Reason::new("the bit rate can be set", "error code 0", found)));
    }
    expect_error("the bit timing in use", ConfigureCommand::BitTiming, &[0], answer).or_inconclusive()?;
    expect_plain("the bit timing in use", answer).or_inconclusive()?;
    bench.watch_restart();
    bench.drain()?;
    bench.send(&Request::ActivateBitTiming { delay: DELAY_MS }.to_frame(MASTER_CAN_ID))?;
    // Frames that were on their way may still come.
    bench.listen(Duration::from_millis(20))?;
    let heard = bench.listen(Duration::from_millis(2 * u64::from(DELAY_MS) - 40))?;
    bench.listen(delay.times(2))?;
    wait(bench)?;
    // Some devices restart at the end of configuration.
    bench.listen(RESTART)?;
    bench.check(heard.first().map_or(Ok(()), |first| {
        let breach = breach("after activate bit timing the slave is silent for twice the delay");
        Err(Box::new(breach.expected(Observation::Silence).found(Observation::Frame(first.frame))))
    }))?;
    let answers = bench.answers()?;
    bench.check(demand(answers, || {
        let breach = breach("after activate bit timing the device still works");
        breach.expected("an SDO response").found(Observation::Silence)
    }))
}

/// After "activate bit timing" the slave uses the bit rate that it has confirmed. The tester changes its own bit rate, asks
/// the device there, and brings it back. The device stores nothing.
#[case(id = "305/bit-timing/takes-effect", clause = "CiA 305 6.4.4", confidence = Attested, level = Must,
       needs = [Lss, Alone, Description], touches = [BitRate], catches = [LssBitTimingWithoutEffect])]
fn takes_effect(bench: &mut Bench<'_>) -> Judged {
    bit_rate::takes_effect::<Lss>(bench)
}
