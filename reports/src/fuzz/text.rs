//! The result for people.

use super::{Run, annotated, left, outcome, reliability, trouble};
use crate::escape::{Visible, printable};
use crate::provenance;
use canvass_fuzzer::reproducer;
use canvass_traces::{Direction, Timestamp};
use std::io::{self, Write};

/// At most so many frames of the bus are shown for a violation that comes back; the last ones.
const FRAMES: usize = 24;

/// Writes the text.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, false);
    for (found, words) in run.violations() {
        let violation = &found.violation;
        writeln!(out, "{} {}: {}", violation.property, violation.property.title(), violation.rule)?;
        writeln!(out, "  expected  {}", printable(&violation.expected))?;
        writeln!(out, "  found     {}", printable(&violation.actual))?;
        writeln!(out, "  this      {}", reliability(found, run.outcome.dead))?;
        writeln!(out, "  sequence  {}", length(found.sequence.stimuli.len()))?;
        indented(out, &annotated(found, words))?;
        writeln!(out, "  on the bus")?;
        let start = found.evidence.first().map_or(Timestamp::ZERO, |record| record.timestamp);
        let shown = if found.confirmed { FRAMES } else { usize::MAX };
        let frames: Vec<_> = found.evidence.iter().zip(&words.evidence).collect();
        for (record, words) in frames.iter().skip(frames.len().saturating_sub(shown)) {
            let nanos = record.timestamp.since(start).nanos();
            let direction = if record.direction == Direction::Tx { "tx" } else { "rx" };
            let (ms, rest) = (nanos / 1_000_000, nanos / 1_000 % 1_000);
            let frame = record.frame.to_string();
            writeln!(out, "    {ms:>6}.{rest:03} ms {direction} {frame:24} {}", printable(words))?;
        }
        writeln!(out, "  log for canplayer and canvass fuzz --replay")?;
        indented(out, &reproducer::candump(&found.sequence))?;
        writeln!(out)?;
    }
    provenance::text(&run.provenance, out)?;
    writeln!(out)?;
    let (executions, sequences) = (run.outcome.executions, run.outcome.sequences);
    let frames = run.outcome.frames;
    writeln!(out, "{}: {}", printable(&run.bus), outcome(run))?;
    writeln!(
        out,
        "{executions} exchanges ({frames} frames sent) in {sequences} sequences, target {}, seed {}",
        run.targets, run.seed
    )?;
    writeln!(out, "coverage of state × command: SDO {}, LSS {}", run.sdo_share(), run.lss_share())?;
    for line in [trouble(run), left(run)].iter().filter(|line| !line.is_empty()) {
        writeln!(out, "{}", printable(line))?;
    }
    match run.forbidden() {
        none if none.is_empty() => {}
        names => writeln!(out, "never done, as it is not allowed: {names}")?,
    }
    writeln!(out, "repeat with: {}", printable(&run.repeat))
}

fn length(frames: usize) -> String {
    match frames {
        0 => "none: it shows without any frame".to_owned(),
        1 => "1 frame".to_owned(),
        frames => format!("{frames} frames"),
    }
}

fn indented(out: &mut dyn Write, text: &str) -> io::Result<()> {
    text.lines().try_for_each(|line| writeln!(out, "    {}", printable(line).trim_end()))
}
