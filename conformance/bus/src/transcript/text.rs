//! A transcript as text, one item per line:
//!
//! ```text
//! canvass-transcript 1
//! live no
//! bit-rate 250000
//! begin 0
//! frames 0 0 1 0               number of timeouts before each frame
//! time 12 1700000000000000000  after this many predictable answers, the time
//! health 3 0 0 0 0 0 / 3:1 7:2 / 4:9 ; 5:1 / the controller is bus-off
//! health 4 0 0 0 0 0 / 3:1 / 4:1 ; 5:1 ; still /    the adapter's time stamps stand still
//! rate set                     or fixed
//! trouble the bus failed
//! ```

use super::Transcript;
use crate::{Health, Latencies, StampTrouble};
use canvass_traces::{Duration, Timestamp};
use std::fmt;
use std::str::FromStr;

const HEAD: &str = "canvass-transcript 1";
/// Number of frames per line.
const IN_LINE: usize = 64;

/// Why a text is no transcript.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {line}: {why}")]
pub struct NotATranscript {
    /// The line, from 1.
    pub line: usize,
    /// The error in the line.
    pub why: String,
}

impl fmt::Display for Transcript {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{HEAD}\nlive {}", if self.is_live { "yes" } else { "no" })?;
        if let Some(bit_rate) = self.bit_rate {
            writeln!(f, "bit-rate {bit_rate}")?;
        }
        writeln!(f, "begin {}", self.begin.nanos())?;
        for waits in self.waits.chunks(IN_LINE) {
            f.write_str("frames")?;
            waits.iter().try_for_each(|wait| write!(f, " {wait}"))?;
            writeln!(f)?;
        }
        for (after, time) in &self.clock {
            writeln!(f, "time {after} {}", time.nanos())?;
        }
        for (after, health) in &self.health {
            let Health {
                lost, interruptions, trouble, error_frames, waits, receive, transmit, stamping, stamps, ..
            } = health;
            let trouble = trouble.as_deref().unwrap_or_default().replace(['\n', '\r'], " ");
            let (receive, transmit, stamping) = (counts(receive), counts(transmit), counts(stamping));
            write!(f, "health {after} {lost} {interruptions} {error_frames} {waits}")?;
            write!(f, " {}", health.interrupted_for.nanos())?;
            health.interrupted_since.map_or(Ok(()), |since| write!(f, " {}", since.nanos()))?;
            let stamps = stamps.map(|trouble| format!("; {} ", trouble.name())).unwrap_or_default();
            writeln!(f, " / {receive} / {transmit} ; {stamping} {stamps}/ {trouble}")?;
        }
        for set in &self.bit_rates {
            writeln!(f, "rate {}", if *set { "set" } else { "fixed" })?;
        }
        match &self.trouble {
            Some(trouble) => writeln!(f, "trouble {}", trouble.replace(['\n', '\r'], " ")),
            None => Ok(()),
        }
    }
}

fn counts(latencies: &Latencies) -> String {
    let counts = latencies.buckets().iter().enumerate().filter(|(_, count)| **count > 0);
    counts.map(|(bucket, count)| format!("{bucket}:{count}")).collect::<Vec<_>>().join(" ")
}

impl FromStr for Transcript {
    type Err = NotATranscript;

    fn from_str(text: &str) -> Result<Self, NotATranscript> {
        let mut lines = text.lines().enumerate();
        let failed = |line: usize, why: String| NotATranscript { line: line + 1, why };
        match lines.next() {
            Some((_, HEAD)) => {}
            found => {
                let found = found.map_or("nothing", |(_, line)| line);
                return Err(failed(0, format!("expected \"{HEAD}\", found \"{found}\"")));
            }
        }
        let mut transcript = Self::default();
        for (at, line) in lines {
            let (key, rest) = line.split_once(' ').unwrap_or((line, ""));
            let read = transcript.read(key, rest);
            read.ok_or_else(|| failed(at, format!("expected a line of a transcript, found \"{line}\"")))?;
        }
        Ok(transcript)
    }
}

impl Transcript {
    fn read(&mut self, key: &str, rest: &str) -> Option<()> {
        match key {
            "live" => self.is_live = rest == "yes",
            "bit-rate" => self.bit_rate = Some(rest.parse().ok()?),
            "begin" => self.begin = Timestamp(rest.parse().ok()?),
            "frames" => {
                let waits: Result<Vec<u64>, _> = rest.split(' ').map(str::parse).collect();
                self.waits.extend(waits.ok()?);
            }
            "time" => {
                let (after, time) = rest.split_once(' ')?;
                self.clock.push((after.parse().ok()?, Timestamp(time.parse().ok()?)));
            }
            "health" => self.health.push(health(rest)?),
            "rate" => self.bit_rates.push(rest == "set"),
            "trouble" => self.trouble = Some(rest.to_owned()),
            _ => return None,
        }
        Some(())
    }
}

fn health(text: &str) -> Option<(u64, Health)> {
    let mut parts = text.splitn(4, '/');
    let mut numbers = parts.next()?.split_whitespace().map(|number| number.parse().ok());
    let mut number = || numbers.next().flatten();
    let after = number()?;
    let (lost, interruptions, error_frames, waits) = (number()?, number()?, number()?, number()?);
    // Older transcripts lack the duration of interruptions.
    let (interrupted_for, interrupted_since) = (Duration(number().unwrap_or_default()), number().map(Timestamp));
    let (receive, sent) = (latencies(parts.next()?)?, parts.next()?);
    // Older transcripts lack the third field, and only an untrustworthy adapter has an entry about its time stamps.
    let mut sorts = sent.split(';');
    let (transmit, stamping) = (sorts.next()?, sorts.next().unwrap_or_default());
    let stamps = match sorts.next() {
        Some(name) => Some(StampTrouble::by_name(name.trim())?),
        None => None,
    };
    let (transmit, stamping) = (latencies(transmit)?, latencies(stamping)?);
    let trouble = Some(parts.next()?.trim().to_owned()).filter(|trouble| !trouble.is_empty());
    let health = Health {
        lost,
        interruptions,
        interrupted_for,
        interrupted_since,
        trouble,
        error_frames,
        waits,
        receive,
        transmit,
        stamping,
        stamps,
    };
    Some((after, health))
}

fn latencies(text: &str) -> Option<Latencies> {
    let mut latencies = Latencies::default();
    for count in text.split_whitespace() {
        let (bucket, count) = count.split_once(':')?;
        latencies.set(bucket.parse().ok()?, count.parse().ok()?)?;
    }
    Some(latencies)
}
