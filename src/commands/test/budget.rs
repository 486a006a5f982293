//! `--for` and `--profile`: the cases that run if there is little time.

use super::Args;
use super::forecast::timed;
use crate::status::Failure;
use canvass_suite::bench::Options;
use canvass_suite::case::Case;
use canvass_suite::order::{Timed, by_benefit, caught, quick};
use canvass_traces::Duration;

/// Which of the chosen cases run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub enum Profile {
    /// All chosen cases.
    Full,
    /// Chosen cases that together catch 90 % of the known faults in the least time.
    Quick,
}

/// The share of the known faults, in percent, that a quick run catches.
const QUICK: usize = 90;

/// The part of `--for`, in tenths, that the cases may take: the rest is for reading and restoring the device.
const FOR_CASES: u64 = 7;

/// The cases that run, and a sentence about those that are left out.
pub struct Affordable {
    pub cases: Vec<&'static Case>,
    pub told: Option<String>,
}

/// Chooses cases for the available time. A simulated device like the device under test shows how long each case takes.
/// Without `--for` and with the full profile all cases run.
pub fn affordable(args: &Args, cases: Vec<&'static Case>, options: &Options) -> Result<Affordable, Failure> {
    if args.span.is_none() && args.profile == Profile::Full {
        return Ok(Affordable { cases, told: None });
    }
    let timed = timed(args, &cases, options)?;
    let mut chosen = match args.profile {
        Profile::Full => timed.clone(),
        Profile::Quick => quick(&timed, QUICK),
    };
    if let Some(span) = args.span {
        chosen = fitting(&by_benefit(&chosen), span, args.repeat);
    }
    // In every run, the cases that can lose the device come last.
    chosen.sort_by_key(|timed| timed.case.can_lose_the_device());
    let told = told(&timed, &chosen);
    Ok(Affordable { cases: chosen.iter().map(|timed| timed.case).collect(), told: Some(told) })
}

/// The cases that fit into the span, in their order.
fn fitting(sorted: &[Timed], span: Duration, repeat: u32) -> Vec<Timed> {
    let mut left = span.nanos() / 10 * FOR_CASES;
    let mut fits = |timed: &&Timed| {
        let takes = timed.takes.nanos().saturating_mul(u64::from(repeat));
        let fits = takes <= left;
        left -= if fits { takes } else { 0 };
        fits
    };
    sorted.iter().filter(|timed| fits(timed)).copied().collect()
}

fn told(all: &[Timed], chosen: &[Timed]) -> String {
    format!(
        "{} of {} cases that apply are run; they catch {} of {} known faults",
        chosen.len(),
        all.len(),
        caught(chosen),
        caught(all)
    )
}
