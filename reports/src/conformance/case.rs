//! The report of one case. On a terminal only the most important facts are shown, on less than a screen.

use super::defects::Defect;
use super::told::Told;
use super::{cct_forecast, decisive, delays, hex, quarantined, recorded, repetitions, symbol, timeline, tone, uses};
use crate::document::{Block, Cell, Column, Depth, Fact, Finding, Row, Table, Tone, fact};
use crate::page_text::counted;
use crate::time::milliseconds;
use canvass_suite::bench::Exhibit;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use canvass_traces::{Direction, Timestamp};

/// Maximum number of lines of a case below its title on a terminal. With the title and an empty line before it, a case
/// fits on a terminal of 24 lines.
const LINES: usize = 22;
/// Maximum number of lines for breaches, among the [`LINES`].
const BREACHES: usize = 12;
/// Maximum number of lines for remarks, among the [`LINES`].
const REMARKS: usize = 4;
/// Maximum number of frames on a terminal. More frames explain nothing.
const FRAMES: usize = 16;
/// Maximum number of frames of a case in Markdown; the last frames are shown.
const FRAMES_ON_PAPER: usize = 20;

/// The anchor of the case on the page.
pub fn anchor(report: &CaseReport) -> String {
    report.case.id.replace('/', "-")
}

/// The sign and the verdict of a case.
fn badge(report: &CaseReport) -> String {
    let kind = report.verdict.kind();
    format!("{} {kind}", symbol(kind))
}

/// The rows of a defect for the list of failed cases.
pub fn rows_of(defect: &Defect<'_>, depth: Depth) -> Vec<Row> {
    let mut first = row_of(defect.first, &why(defect.first));
    if defect.others.is_empty() {
        return vec![first];
    }
    if depth == Depth::Screen {
        let others: Vec<&str> = defect.others.iter().map(|report| report.case.id).collect();
        first.lines.push(format!("    the same: {}", others.join(", ")));
        return vec![first];
    }
    let same = format!("the same as {}", defect.first.case.id);
    let others = defect.others.iter().map(|report| row_of(report, &same));
    [first].into_iter().chain(others).collect()
}

fn why(report: &CaseReport) -> String {
    let reason = report.verdict.reason().map(|reason| reason.to_string()).unwrap_or_default();
    quarantined(report).map(|told| format!("{told}; ")).unwrap_or_default() + &reason
}

fn row_of(report: &CaseReport, why: &str) -> Row {
    let kind = report.verdict.kind();
    let case = Cell { link: format!("#{}", anchor(report)), ..report.case.id.into() };
    Row {
        tone: tone(kind),
        lines: vec![format!("{} {}  {why}", symbol(kind), report.case.id)],
        ..Row::of([Cell { tone: tone(kind), ..badge(report).into() }, case, why.into()])
    }
}

/// A case, in the detail that `depth` allows.
pub fn finding(report: &CaseReport, depth: Depth) -> Finding {
    let kind = report.verdict.kind();
    Finding {
        tone: tone(kind),
        badge: badge(report),
        title: report.case.id.to_owned(),
        id: report.case.clause.to_string(),
        anchor: anchor(report),
        data_kind: kind.name(),
        is_open: matches!(kind, Kind::Fail | Kind::Error),
        body: if depth == Depth::Screen { on_a_screen(report) } else { in_full(report, depth) },
    }
}

/// The body of a case on a terminal: the worst breach, further breaches and the first remarks as far as there is room,
/// then frames.
fn on_a_screen(report: &CaseReport) -> Vec<Block> {
    let all = Told::all(report);
    let (mut blocks, mut used) = (Vec::new(), 0);
    for (at, facts) in all.iter().map(facts).enumerate() {
        // If breaches are left out, the last line says how many.
        let room = if at + 1 == all.len() { BREACHES } else { BREACHES - 1 };
        if at > 0 && used + facts.len() > room {
            let hidden = all.len() - at;
            blocks.push(Block::Text(format!("… {hidden} more breach{}", if hidden == 1 { "" } else { "es" })));
            used += 1;
            break;
        }
        used += facts.len();
        blocks.push(Block::Facts(facts));
    }
    let mut remarks = remarks(report);
    if remarks.len() > REMARKS {
        let hidden = remarks.len() - (REMARKS - 1);
        remarks.truncate(REMARKS - 1);
        remarks.push(fact("…", &format!("{hidden} more notes")));
    }
    used += remarks.len();
    blocks.push(Block::Facts(remarks));
    if report.verdict.kind() != Kind::Pass {
        let (frames, before) = decisive(report, FRAMES.min(LINES.saturating_sub(used + 1)));
        let told = format!("… {} before", counted(before as usize, "frame"));
        blocks.extend((before > 0).then_some(Block::Text(told)));
        blocks.push(Block::Table(Table::of(["time", "frame", "", "meaning"], frames.into_iter().map(seen))));
    }
    blocks
}

/// A row for a frame, with the time of the recording.
fn seen(Exhibit { record, text }: &Exhibit) -> Row {
    let time = format!("({})", record.timestamp);
    Row::of([time, record.frame.to_string(), record.direction.to_string(), text.clone()])
}

/// The facts of a breach, or of the reason why the case did not reach its end.
fn facts(told: &Told) -> Vec<Fact> {
    let mut facts = vec![fact("duty", &told.duty), fact("expected", &told.expected), fact("found", &told.found)];
    facts.extend(told.excuse.iter().map(|excuse| fact(&told.authority().to_lowercase(), &excuse.documented)));
    facts.extend(told.waiver().map(|waiver| fact("as data", &waiver)));
    facts
}

/// Further observations in the case.
fn remarks(report: &CaseReport) -> Vec<Fact> {
    let mut remarks: Vec<Fact> = quarantined(report).map(|told| fact("quarantine", &told)).into_iter().collect();
    if let (Some(forecast), Some(number)) = (cct_forecast(report), report.case.cct) {
        remarks.push(fact("forecast", &format!("case {number} of CiA's test tool would {forecast}")));
    }
    remarks.extend(repetitions(report).map(|told| fact("repeated", &told)));
    remarks.extend(uses(report).map(|uses| fact("used", &uses)));
    remarks.extend(report.measurements.iter().map(|measurement| fact("measured", measurement)));
    remarks.extend(report.notes.iter().map(|note| fact("note", note)));
    remarks
}

fn in_full(report: &CaseReport, depth: Depth) -> Vec<Block> {
    let mut blocks = vec![Block::Text(report.case.requirement.to_owned())];
    blocks.extend(Told::all(report).iter().map(|told| Block::Facts(facts(told))));
    let mut remarks = remarks(report);
    let comparable = report.case.cct.filter(|_| cct_forecast(report).is_none());
    remarks.extend(comparable.map(|number| fact("comparable", &format!("with case {number} of CiA's test tool"))));
    remarks.extend([
        fact("level", report.case.level.name()),
        fact("duration", &format!("{} on the bus", report.duration)),
    ]);
    blocks.push(Block::Facts(remarks));
    blocks.extend(evidence(report, depth));
    blocks
}

fn evidence(report: &CaseReport, depth: Depth) -> Option<Block> {
    let all: Vec<&Exhibit> = report.evidence.frames().collect();
    let start = all.first()?.record.timestamp;
    let omitted = report.evidence.omitted();
    let mut title = format!("{} frames", all.len());
    if omitted > 0 {
        title += &format!(" ({omitted} more left out)");
    }
    if let Some([first, last]) = recorded(report) {
        title += &format!(": #{first} to #{last} of the recording");
    }
    if depth < Depth::Page {
        let frames = decisive(report, FRAMES_ON_PAPER).0;
        return Some(Block::fold(title, vec![table(frames.into_iter().map(|shown| row(shown, start)))]));
    }
    let mut rows: Vec<Row> = all.iter().map(|shown| row(shown, start)).collect();
    if omitted > 0 {
        let gap = ["", "", "", "", "", &format!("{omitted} frames left out")];
        rows.insert(report.evidence.gap().min(rows.len()), Row { tone: Tone::Odd, ..Row::of(gap) });
    }
    let pictures = [timeline::strip(&all), delays::plot(&all)].map(Block::Markup);
    let blocks = pictures.into_iter().chain([table(rows.into_iter())]).collect();
    Some(Block::Fold { title, is_open: matches!(report.verdict.kind(), Kind::Fail | Kind::Error), blocks })
}

fn table(rows: impl Iterator<Item = Row>) -> Block {
    let names = ["", "CAN-ID", "data", "meaning"].map(Column::new);
    Block::Table(Table::new([Column::right("#"), Column::right("ms")].into_iter().chain(names), rows))
}

fn row(Exhibit { record, text }: &Exhibit, start: Timestamp) -> Row {
    let number = record.place.number;
    let is_sent = record.direction == Direction::Tx;
    let (sign, title) = if is_sent { ("→", "sent by the tester") } else { ("←", "received") };
    let anchor = if number > 0 { format!("frame-{number}") } else { String::new() };
    let place = match number {
        0 => Cell::default(),
        _ => Cell { link: format!("#{anchor}"), ..number.to_string().into() },
    };
    let time = milliseconds(record.timestamp.since(start));
    let direction = Cell { title: title.to_owned(), ..sign.into() };
    let meaning = Cell { class: "text".to_owned(), ..text.clone().into() };
    let cells = [place, time.into(), direction, record.frame.id().to_string().into(), hex(record).into(), meaning];
    Row { tone: if is_sent { Tone::Faint } else { Tone::Plain }, anchor, ..Row::of(cells) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::height;
    use canvass_bus::observation::{Observation, Subject};
    use canvass_suite::bench::Evidence;
    use canvass_suite::catalogue;
    use canvass_suite::verdict::{Breach, Ruled, Verdict};
    use canvass_traces::{CanId, ChannelId, Duration, Frame, Record};

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

    /// The body of the case on a terminal, below its title.
    fn body(breaches: usize, notes: usize, frames: u64) -> Vec<Block> {
        finding(&report(breaches, notes, frames), Depth::Screen).body
    }

    fn text(breaches: usize, notes: usize, frames: u64) -> String {
        format!("{:?}", body(breaches, notes, frames))
    }

    #[test]
    fn a_case_takes_at_most_a_screen_whatever_it_found() {
        for (breaches, notes, frames) in [(1, 0, 500), (300, 0, 500), (1, 300, 3), (300, 300, 500), (3, 0, 0)] {
            let height = height(&body(breaches, notes, frames));
            assert!(height <= LINES, "{breaches} {notes} {frames}: {height}");
            assert!(text(breaches, notes, frames).contains("duty 0"));
        }
    }

    #[test]
    fn what_is_left_out_is_counted() {
        let shown = text(300, 0, 500);
        assert!(shown.contains("more breaches") && shown.contains("frames before"), "{shown}");
        let told = text(3, 0, 2);
        assert!(told.contains("duty 2") && !told.contains("more"), "{told}");
        assert!(text(1, 9, 0).contains("6 more notes"));
    }
}
