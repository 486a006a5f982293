//! `--timeout WHAT=MS`.

use anyhow::{Context, Result, anyhow, bail};
use canvass_suite::bench::Timing;
use canvass_traces::Duration;
use std::str::FromStr;

/// One waiting time.
#[derive(Clone, Copy, Debug)]
pub struct Timeout {
    what: What,
    span: Duration,
}

#[derive(Clone, Copy, Debug)]
enum What {
    Sdo,
    BootUp,
    Reaction,
    Silence,
}

impl Timeout {
    /// Puts it where the bench looks for it.
    pub const fn set(self, timing: &mut Timing) {
        match self.what {
            What::Sdo => timing.sdo_response = self.span,
            What::BootUp => timing.boot_up = self.span,
            What::Reaction => timing.reaction = self.span,
            What::Silence => timing.silence = self.span,
        }
    }
}

impl FromStr for Timeout {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        const LONGEST_MS: u64 = 600_000;
        let (what, milliseconds) = text.split_once('=').context("expected WHAT=MS, such as sdo=500")?;
        let what = match what {
            "sdo" => What::Sdo,
            "boot-up" => What::BootUp,
            "reaction" => What::Reaction,
            "silence" => What::Silence,
            other => bail!("expected sdo, boot-up, reaction or silence, found \"{other}\""),
        };
        let span = milliseconds.parse().ok().filter(|ms| (1..=LONGEST_MS).contains(ms));
        let span = span.ok_or_else(|| anyhow!("expected 1 to {LONGEST_MS} milliseconds, found \"{milliseconds}\""))?;
        Ok(Self { what, span: Duration::from_millis(span) })
    }
}
