//! The bit rate that a slave uses after "activate bit timing": the tester follows the device to another bit rate, asks it
//! there, and brings it back. Nothing is stored, so a device that gets lost comes back by switching it off and on.

use super::{Observed, RESTART, exchange, expect_error, tell};
use crate::bench::Bench;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{ConfigureCommand, MASTER_CAN_ID, Request};
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// How long the slave is silent before the change, and again after it.
const DELAY_MS: u16 = 300;
/// How much longer the tester waits, since both clocks are not the same.
const MARGIN: Duration = Duration::from_millis(50);

/// The bit rates of a case, in bit/s.
struct Rates {
    /// The one in use.
    own: u32,
    /// The one that the device is brought to.
    other: u32,
    /// Where a device is looked for: both of these first, then the others of the table.
    all: Vec<u32>,
}

impl Rates {
    /// The bit rate in use, and the next lower one of the description, or else the next higher one: a cable that carries
    /// one bit rate also carries a lower one.
    fn of<D: Observed>(bench: &Bench<'_>) -> Result<Self, Stop> {
        let not_applicable = |what, expected, found| Stop::NotApplicable(Reason::new(what, expected, found));
        let own = bench.bit_rate().filter(|rate| D::bit_rate_index(*rate).is_some()).ok_or_else(|| {
            let found = bench.bit_rate().map_or_else(|| "it is not known".to_owned(), |rate| format!("{rate} bit/s"));
            not_applicable("the bit rate of the bus is in table 0", "one of the standard", found)
        })?;
        let described = bench.target().description.as_ref().map_or(&[][..], |known| &known.device.bit_rates);
        let described = described.iter().map(|kbit| u32::from(*kbit) * 1_000);
        let others = described.filter(|rate| *rate != own && D::bit_rate_index(*rate).is_some());
        let nearest = others.min_by_key(|rate| (*rate > own, rate.abs_diff(own)));
        let other = nearest.ok_or_else(|| {
            not_applicable("the description has another bit rate", "two bit rates", "the one in use only".to_owned())
        })?;
        let rest = (0..=u8::MAX).filter_map(D::bit_rate).filter(|rate| ![own, other].contains(rate));
        Ok(Self { own, other, all: [other, own].into_iter().chain(rest).collect() })
    }

    /// Makes sure that this end of the bus can follow, before the device is told anything, and that nobody is left behind.
    fn probe(&self, bench: &mut Bench<'_>) -> Result<(), Stop> {
        if bench.has_other_clients() {
            let found = "requests of another client, which stays at the old bit rate".to_owned();
            return Err(Stop::NotApplicable(Reason::new("the tester alone uses the bus", "no other client", found)));
        }
        match bench.try_bit_rate(self.other) {
            Ok(()) => bench.set_bit_rate(self.own),
            Err(error) => {
                let reason = Reason::new("the tester can change its bit rate", "a change", error.to_string());
                Err(Stop::NotApplicable(reason))
            }
        }
    }
}

/// After "activate bit timing" the device uses the bit rate that it has confirmed.
///
/// # Errors
/// [`Stop::NotApplicable`] if there is no other bit rate, or the tester can't change its own.
pub fn takes_effect<D: Observed>(bench: &mut Bench<'_>) -> Judged {
    let rates = Rates::of::<D>(bench)?;
    rates.probe(bench)?;
    tell(bench, Request::<D>::SwitchGlobal { mode: 1 })?;
    bench.uncancelled(|bench| {
        let judged = follow::<D>(bench, &rates);
        // Whatever happened: the cases that come use the old bit rate.
        bench.set_bit_rate(rates.own)?;
        judged
    })
}

fn follow<D: Observed>(bench: &mut Bench<'_>, rates: &Rates) -> Judged {
    if let Err(refused) = configure::<D>(bench, rates.other) {
        leave::<D>(bench, rates)?;
        return Err(refused);
    }
    bench.watch_restart();
    // A device may need longer than the delay to start its controller again, so it is asked once more.
    let found = if go::<D>(bench, rates.other)? { Some(rates.other) } else { find(bench, rates)? };
    bring_back::<D>(bench, rates, found)?;
    bench.check(demand(found == Some(rates.other), || {
        let duty = "after \"activate bit timing\" the device uses the bit rate that it has confirmed";
        let answer = |rate: u32| format!("an SDO response at {} kbit/s", rate / 1_000);
        let found = found.map_or_else(|| "no response at any bit rate of the table".to_owned(), answer);
        let breach = Breach::new(D::SERVICE, duty.to_owned());
        breach.expected(answer(rates.other)).found(Observation::Named(found.into()))
    }))
}

/// Lets the slave confirm a bit rate.
fn configure<D: Observed>(bench: &mut Bench<'_>, rate: u32) -> Result<(), Stop> {
    let Some(index) = D::bit_rate_index(rate) else { return Ok(()) };
    let answer = exchange(bench, Request::<D>::ConfigureBitTiming { table: 0, index })?;
    let duty = format!("{} kbit/s, which the description has, is accepted", rate / 1_000);
    expect_error(duty, "error code 0", ConfigureCommand::BitTiming, answer, |error| error == 0).or_inconclusive()
}

/// Activates the configured bit rate and follows; returns whether the device answers there.
fn go<D: Observed>(bench: &mut Bench<'_>, rate: u32) -> Result<bool, Stop> {
    let delay = Duration::from_millis(u64::from(DELAY_MS));
    bench.drain()?;
    bench.send(&Request::<D>::ActivateBitTiming { delay: DELAY_MS }.to_frame(MASTER_CAN_ID))?;
    bench.listen(delay)?;
    bench.set_bit_rate(rate)?;
    bench.listen(delay + MARGIN)?;
    bench.answers()
}

/// Looks for the device at all bit rates of the table.
fn find(bench: &mut Bench<'_>, rates: &Rates) -> Result<Option<u32>, Stop> {
    for rate in &rates.all {
        // An adapter that lacks a bit rate can't look there.
        if bench.try_bit_rate(*rate).is_ok() && bench.answers()? {
            return Ok(Some(*rate));
        }
    }
    Ok(None)
}

/// Brings the device back from where it was found. A device that restarts at the end of configuration may move once
/// more.
fn bring_back<D: Observed>(bench: &mut Bench<'_>, rates: &Rates, found: Option<u32>) -> Result<(), Stop> {
    let mut found = found;
    for _ in 0..2 {
        if found.is_some_and(|rate| rate != rates.own) {
            tell(bench, Request::<D>::SwitchGlobal { mode: 1 })?;
            // What the device refuses shows in whether it comes back.
            let _ = configure::<D>(bench, rates.own);
            go::<D>(bench, rates.own)?;
        }
        bench.set_bit_rate(rates.own)?;
        leave::<D>(bench, rates)?;
        if bench.answers()? {
            return Ok(());
        }
        found = find(bench, rates)?;
    }
    Ok(())
}

/// Replaces the pending bit rate by the one in use, and ends configuration.
fn leave<D: Observed>(bench: &mut Bench<'_>, rates: &Rates) -> Result<(), Stop> {
    tell(bench, Request::<D>::SwitchGlobal { mode: 1 })?;
    // A device that is not here does not answer.
    let _ = configure::<D>(bench, rates.own);
    tell(bench, Request::<D>::SwitchGlobal { mode: 0 })?;
    bench.listen(RESTART)?;
    Ok(())
}
