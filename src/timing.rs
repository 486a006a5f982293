//! `--timeout WHAT=SPAN`.

use crate::live::{parse_span, typed_span};
use crate::reconnect::RECONNECT;
use anyhow::{Context, Result, anyhow, bail};
use canvass_suite::bench::Timing;
use canvass_traces::Duration;
use std::str::FromStr;

/// A value of `--timeout`.
#[derive(Clone, Copy, Debug)]
pub struct Timeout {
    what: What,
    span: Duration,
}

#[derive(Clone, Copy, Debug)]
enum What {
    Sdo,
    Store,
    Lss,
    BootUp,
    Reaction,
    Silence,
    Client,
    Reconnect,
}

impl Timeout {
    /// The time to wait for a client, if this value sets it.
    pub fn of_client(self) -> Option<Duration> {
        matches!(self.what, What::Client).then_some(self.span)
    }

    /// Sets the time in the bench's timing.
    pub const fn set(self, timing: &mut Timing) {
        match self.what {
            What::Sdo => timing.sdo_response = self.span,
            What::Store => timing.store = self.span,
            What::Lss => timing.lss = self.span,
            What::BootUp => timing.boot_up = self.span,
            What::Reaction => timing.reaction = self.span,
            What::Silence => timing.silence = self.span,
            What::Client | What::Reconnect => {}
        }
    }
}

/// The time to wait for an interrupted bus, from the last value that sets it.
pub fn reconnect(timeouts: &[Timeout]) -> Duration {
    let is_it = |timeout: &&Timeout| matches!(timeout.what, What::Reconnect);
    timeouts.iter().rfind(is_it).map_or(RECONNECT, |timeout| timeout.span)
}

/// All waiting times, in the form of `--timeout`.
pub fn told(timing: &Timing, client: Duration, reconnect: Duration) -> Vec<String> {
    let spans = [
        ("sdo", timing.sdo_response),
        ("boot-up", timing.boot_up),
        ("reaction", timing.reaction),
        ("silence", timing.silence),
        ("client", client),
        ("reconnect", reconnect),
    ];
    spans.map(|(what, span)| format!("{what}={}", typed_span(span))).into()
}

impl FromStr for Timeout {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        const LONGEST: Duration = Duration::from_secs(600);
        let (what, span) = text.split_once('=').context("expected WHAT=SPAN, such as sdo=500ms")?;
        let what = match what {
            "sdo" => What::Sdo,
            "store" => What::Store,
            "lss" => What::Lss,
            "boot-up" => What::BootUp,
            "reaction" => What::Reaction,
            "silence" => What::Silence,
            "client" => What::Client,
            "reconnect" => What::Reconnect,
            other => {
                bail!("expected sdo, store, lss, boot-up, reaction, silence, client or reconnect, found \"{other}\"")
            }
        };
        let known = parse_span(span).ok().filter(|known| (Duration::from_millis(1)..=LONGEST).contains(known));
        let span = known.ok_or_else(|| anyhow!("expected 1ms to {LONGEST}, such as 500ms, found \"{span}\""))?;
        Ok(Self { what, span })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_wait_has_its_own_name() {
        let mut timing = Timing::default();
        for text in ["sdo=1ms", "store=2ms", "lss=3ms", "boot-up=4ms", "reaction=5ms", "silence=6ms", "client=7"] {
            text.parse::<Timeout>().unwrap().set(&mut timing);
        }
        let set = [timing.sdo_response, timing.store, timing.lss, timing.boot_up, timing.reaction, timing.silence];
        assert_eq!(set, [1, 2, 3, 4, 5, 6].map(Duration::from_millis));
        let spans = ["reconnect=9s", "client=1s", "reconnect=8s"].map(|text| text.parse().unwrap());
        assert_eq!((reconnect(&spans), reconnect(&spans[1..2])), (Duration::from_secs(8), RECONNECT));
        assert!("lss".parse::<Timeout>().is_err() && "lss=0".parse::<Timeout>().is_err());
    }
}
