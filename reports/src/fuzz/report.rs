//! The result of a run as a report. In JUnit files each property that holds is a case. Each violated rule of the other
//! properties is a case, too.

use super::{Run, Words, annotated, json, left, outcome, reliability, rust_test, sdo_rows, seen, trouble};
use crate::document::junit::{Case, Outcome, Problem, Suite};
use crate::document::{
    Block, Code, Column, Depth, Document, Fact, Finding, PageParts, Report, Row, Section, Table, Tone, fact,
};
use crate::time::milliseconds;
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::{Property, reproducer};
use canvass_traces::{Direction, Record, Timestamp};
use std::io::{self, Write};

/// Maximum number of frames that a terminal shows for a violation that comes back; the last frames are shown.
const FRAMES: usize = 24;

impl Report for Run {
    fn document(&self, depth: Depth) -> Document {
        let model = if self.model.is_empty() { String::new() } else { format!(": {}", self.model) };
        let is_good = self.outcome.violations.is_empty() && self.outcome.ended_by.is_none();
        let findings = self.violations().map(|(found, words)| Block::Finding(finding(self, found, words, depth)));
        let none = depth > Depth::Screen && self.outcome.violations.is_empty();
        let findings = findings.chain(none.then(|| Block::Text("None.".to_owned())));
        let violations = section("violations", "Violations", findings.collect());
        let coverage = (depth == Depth::Page).then(|| section("coverage", "Coverage", coverage(self)));
        Document {
            command: "fuzz",
            kind: "CANopen fuzzing",
            title: format!("Fuzzing of node {}{model}", self.node),
            outcome: outcome(self),
            tone: if is_good { Tone::Good } else { Tone::Bad },
            facts: facts(self, depth),
            summary: repeat(self, depth),
            sections: [violations].into_iter().chain(coverage).collect(),
            about: Some(self.provenance.section(depth, true)),
            suites: vec![suite(self)],
            page: PageParts { footer: "Times are those of the bus.", ..PageParts::default() },
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        json::render(self, out)
    }
}

fn section(id: &'static str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id, title: title.to_owned(), blocks }
}

fn facts(run: &Run, depth: Depth) -> Vec<Fact> {
    let facts = [
        fact("bus", &run.bus),
        fact("target", &run.targets),
        fact("never done", &never_done(run)),
        fact("seed", &run.seed),
        fact("exchanges", &run.outcome.executions),
        fact("frames sent", &run.outcome.frames),
        fact("sequences", &run.outcome.sequences),
        fact("SDO coverage", &format!("{} of state × command", run.sdo_share())),
        fact("LSS coverage", &format!("{} of state × command", run.lss_share())),
        fact("the bus", &trouble(run)),
        fact("at the end", &left(run)),
    ];
    let repeat = (!matches!(depth, Depth::Paper | Depth::Print)).then(|| fact("repeat with", &run.repeat));
    facts.into_iter().filter(|(_, value)| !value.is_empty()).chain(repeat).collect()
}

/// The touches that the user did not allow, in a sentence. Empty if all were allowed.
fn never_done(run: &Run) -> String {
    let forbidden = run.forbidden();
    if forbidden.is_empty() { forbidden } else { forbidden + " (not allowed)" }
}

/// The command that repeats the run, ready to copy. A Markdown table would escape its characters.
fn repeat(run: &Run, depth: Depth) -> Vec<Block> {
    let command = || code("repeat with", "sh", run.repeat.clone());
    matches!(depth, Depth::Paper | Depth::Print).then(command).into_iter().collect()
}

fn finding(run: &Run, found: &Found, words: &Words, depth: Depth) -> Finding {
    let violation = &found.violation;
    let facts = [
        fact("expected", &violation.expected),
        fact("clause", &violation.clause()),
        fact("found", &violation.actual),
        fact("device", &violation.state),
        fact("this", &reliability(found, run.outcome.dead)),
        fact("seen", &seen(found)),
    ];
    let sequence = match found.sequence.stimuli.is_empty() {
        true => "none: it shows without any frame".to_owned(),
        false => annotated(found, words),
    };
    let mut body = vec![
        Block::Text(violation.property.title().to_owned()),
        Block::Facts(facts.into_iter().filter(|(_, value)| !value.is_empty()).collect()),
        code("sequence", "text", sequence),
        Block::fold("on the bus, times in ms", vec![frames(found, words, depth)]),
        code("log for canplayer and canvass fuzz --replay", "text", reproducer::log(found)),
    ];
    if depth > Depth::Screen {
        body.push(code("Rust test", "rust", rust_test(run, found)));
        body.push(code("test for pytest", "python", reproducer::pytest(found, run.node, run.seed)));
    }
    Finding {
        tone: Tone::Bad,
        badge: "violation".to_owned(),
        title: violation.rule.to_owned(),
        id: violation.property.id().to_owned(),
        is_open: true,
        body,
        ..Finding::default()
    }
}

fn code(title: &'static str, language: &'static str, text: String) -> Block {
    Block::Code(Code { title, language, text })
}

/// The frames on the bus. For a violation that did not come back all of them are shown.
fn frames(found: &Found, words: &Words, depth: Depth) -> Block {
    let start = found.evidence.first().map_or(Timestamp::ZERO, |record| record.timestamp);
    let most = if found.confirmed && depth < Depth::Page { FRAMES } else { usize::MAX };
    let row = |(record, words): (&Record, &String)| {
        let direction = if record.direction == Direction::Tx { "tx" } else { "rx" };
        let time = milliseconds(record.timestamp.since(start));
        Row::of([time, direction.to_owned(), record.frame.to_string(), words.clone()])
    };
    let rows = found.evidence.iter().zip(&words.evidence).skip(found.evidence.len().saturating_sub(most)).map(row);
    let columns = [Column::right("ms"), Column::new(""), Column::new("frame"), Column::new("meaning")];
    Block::Table(Table::new(columns, rows))
}

fn coverage(run: &Run) -> Vec<Block> {
    let sdo = sdo_rows(run).into_iter().map(|(state, command, answers)| {
        let answers = answers.iter().map(|(answer, count)| format!("{} {count}", answer.name()));
        Row::of([state.to_owned(), command.to_owned(), answers.collect::<Vec<_>>().join(", ")])
    });
    let lss = run.coverage().lss_rows().map(|(state, command, answered, count)| {
        let answered = if answered { "yes" } else { "no" };
        Row::of([state.name(), command.name(), answered, &count.to_string()])
    });
    vec![
        Block::Table(Table::of(["SDO state", "command", "answers"], sdo)),
        Block::Table(Table::of(["LSS state", "command", "answered", "times"], lss)),
    ]
}

fn suite(run: &Run) -> Suite {
    let mut suite = Suite::new(format!("fuzz/{}", run.targets));
    suite.add_properties([
        ("node", run.node.to_string()),
        ("bus", run.bus.clone()),
        ("model", run.model.clone()),
        ("seed", run.seed.to_string()),
        ("repeat", run.repeat.clone()),
        ("outcome", outcome(run)),
        ("executions", run.outcome.executions.to_string()),
        ("frames", run.outcome.frames.to_string()),
        ("coverage_sdo", run.sdo_share().to_string()),
        ("coverage_lss", run.lss_share().to_string()),
    ]);
    let trouble = trouble(run);
    suite.add_properties((!trouble.is_empty()).then(|| ("bus_trouble", trouble.clone())));
    suite.add_properties(run.provenance.properties());
    for property in Property::all() {
        suite.add_cases(cases(run, property));
    }
    // Without this case, properties that were not tried would look as if they had passed.
    suite.add_cases(run.outcome.ended_by.iter().map(|why| {
        let problem = Problem { kind: "bus", message: why.clone(), details: vec![trouble.clone()] };
        Case::passed(format!("fuzz.{}", run.targets), "the bus works to the end of the run")
            .ended(Outcome::Error(problem))
    }));
    suite
}

fn cases(run: &Run, property: Property) -> Vec<Case> {
    let family = format!("fuzz.{}", run.targets);
    let violated = run.violations().filter(|(found, _)| found.violation.property == property);
    let cases: Vec<Case> = violated.map(|(found, words)| case(run, &family, found, words)).collect();
    match cases.is_empty() {
        true => vec![Case::passed(family, format!("{property} {}", property.title()))],
        false => cases,
    }
}

fn case(run: &Run, family: &str, found: &Found, words: &Words) -> Case {
    let violation = &found.violation;
    let log = reproducer::log(found);
    let text = format!("{}\n{}\n{log}", reliability(found, run.outcome.dead), annotated(found, words));
    Case::passed(family, violation.defect().to_string()).ended(Outcome::Failed(Problem {
        kind: if found.confirmed { "violation" } else { Problem::SEEN_ONCE },
        message: format!(
            "{} {}: expected {}, found {}",
            violation.property, violation.rule, violation.expected, violation.actual
        ),
        details: text.lines().map(str::to_owned).collect(),
    }))
}
