//! What a terminal shows of a case: what matters most, on less than a screen. JSON and the page have all of it.

use super::told::Told;
use super::{cct_forecast, decisive, quarantined, repetitions, symbol, uses};
use crate::escape::printable;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;

/// The lines of a case below its title: with that, and an empty one before it, it fits on a terminal of 24 lines.
pub const LINES: usize = 22;
/// Of these so many are for breaches.
const BREACHES: usize = 12;
/// And so many for what else was noticed.
const REMARKS: usize = 4;
/// More frames than these explain nothing.
const FRAMES: usize = 16;

/// The lines of a case.
pub fn lines(report: &CaseReport) -> Vec<String> {
    let mut lines = breaches(report);
    lines.extend(remarks(report));
    if report.verdict.kind() != Kind::Pass {
        let room = LINES.saturating_sub(lines.len());
        lines.extend(frames(report, room));
    }
    lines
}

/// The worst breach, and as many more as there is room for.
fn breaches(report: &CaseReport) -> Vec<String> {
    let all = Told::all(report);
    let mut lines: Vec<String> = Vec::new();
    for (at, told) in all.iter().enumerate() {
        let next = of_breach(told);
        // The last line may have to say how many are left out.
        let room = if at + 1 == all.len() { BREACHES } else { BREACHES - 1 };
        if at > 0 && lines.len() + next.len() > room {
            let hidden = all.len() - at;
            lines.push(format!("  … {hidden} more breach{}", if hidden == 1 { "" } else { "es" }));
            break;
        }
        lines.extend(next);
    }
    lines
}

fn of_breach(told: &Told) -> Vec<String> {
    let mut lines = vec![
        format!("  {}", printable(&told.duty)),
        format!("    expected  {}", printable(&told.expected)),
        format!("    found     {}", printable(&told.found)),
    ];
    if let Some(excuse) = &told.excuse {
        let label = told.authority().to_lowercase();
        lines.push(format!("    {label:10}  {}", printable(&excuse.documented)));
    }
    lines.extend(told.waiver().map(|waiver| format!("    as data   {}", printable(&waiver))));
    lines
}

fn remarks(report: &CaseReport) -> Vec<String> {
    let mut lines: Vec<String> = quarantined(report).into_iter().map(|told| format!("    {told}")).collect();
    if let (Some(forecast), Some(number)) = (cct_forecast(report), report.case.cct) {
        lines.push(format!("    forecast  case {number} of CiA's test tool would {forecast}"));
    }
    lines.extend(repetitions(report).map(|repetitions| format!("    {repetitions}")));
    lines.extend(uses(report).map(|uses| format!("    used      {uses}")));
    let measured = |measurement: &canvass_suite::bench::Measurement| measurement.to_string();
    lines.extend(report.measurements.iter().map(|m| format!("    measured  {}", printable(&measured(m)))));
    lines.extend(report.notes.iter().map(|note| format!("    note  {}", printable(note))));
    if lines.len() > REMARKS {
        let hidden = lines.len() - (REMARKS - 1);
        lines.truncate(REMARKS - 1);
        lines.push(format!("    … {hidden} more notes"));
    }
    lines
}

/// The frames that the verdict is made of, in so many lines.
fn frames(report: &CaseReport, room: usize) -> Vec<String> {
    let (frames, before) = decisive(report, FRAMES.min(room.saturating_sub(1)));
    let mut lines = Vec::with_capacity(frames.len() + 1);
    if before > 0 {
        lines.push(format!("    … {before} frame{} before", if before == 1 { "" } else { "s" }));
    }
    lines.extend(frames.into_iter().map(|exhibit| {
        let (record, text) = (&exhibit.record, printable(&exhibit.text));
        let (frame, direction) = (record.frame.to_string(), record.direction.to_string());
        format!("    ({}) {frame:<21} {direction:<2} {text}", record.timestamp)
    }));
    lines
}

/// Whether a case is among those that somebody has to look into.
pub const fn is_bad(kind: Kind) -> bool {
    matches!(kind, Kind::Fail | Kind::Error | Kind::Inconclusive)
}

/// A line for the list of what failed.
pub fn listed(report: &CaseReport) -> String {
    let kind = report.verdict.kind();
    let reason = report.verdict.reason().map(|reason| reason.to_string()).unwrap_or_default();
    let quarantined = quarantined(report).map(|told| format!("{told}; ")).unwrap_or_default();
    format!("{} {}  {quarantined}{}", symbol(kind), report.case.id, printable(&reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_bus::observation::{Observation, Subject};
    use canvass_suite::bench::{Evidence, Exhibit};
    use canvass_suite::catalogue;
    use canvass_suite::verdict::{Breach, Ruled, Verdict};
    use canvass_traces::{CanId, ChannelId, Duration, Frame, Record, Timestamp};

    fn report(breaches: usize, notes: usize, frames: u64) -> CaseReport {
        let breach = |n| Breach::new(Subject::Device, format!("duty {n}")).found(Observation::Silence);
        let ruled = (0..breaches).map(|n| Ruled { breach: breach(n), excuse: None }).collect();
        let mut evidence = Evidence::default();
        let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
        for n in 0..frames {
            evidence.push(Exhibit { record: Record::new(Timestamp(n), ChannelId(0), frame), text: String::new() });
        }
        CaseReport {
            case: catalogue::cases()[0],
            verdict: Verdict::new(ruled, None),
            evidence,
            notes: vec!["a note".to_owned(); notes],
            measurements: Vec::new(),
            uses: Vec::new(),
            foreign: Vec::new(),
            outcomes: vec![Kind::Fail],
            quarantine: None,
            duration: Duration::ZERO,
        }
    }

    #[test]
    fn a_case_takes_at_most_a_screen_whatever_it_found() {
        for (breaches, notes, frames) in [(1, 0, 500), (300, 0, 500), (1, 300, 3), (300, 300, 500), (3, 0, 0)] {
            let lines = lines(&report(breaches, notes, frames));
            assert!(lines.len() <= LINES, "{breaches} {notes} {frames}: {lines:#?}");
            assert!(lines[0].contains("duty 0"));
        }
    }

    #[test]
    fn what_is_left_out_is_counted() {
        let shown = lines(&report(300, 0, 500)).join("\n");
        assert!(shown.contains("more breaches") && shown.contains("frames before"), "{shown}");
        let told = lines(&report(3, 0, 2)).join("\n");
        assert!(told.contains("duty 2") && !told.contains("more"), "{told}");
        assert!(lines(&report(1, 9, 0)).join("\n").contains("… 6 more notes"));
    }
}
