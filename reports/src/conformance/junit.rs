//! The result as JUnit XML, for continuous integration.
//!
//! A *fail* is a failure; *error* and *inconclusive* are errors, because nothing is known where something should be;
//! *not applicable* is skipped, and so is what is in quarantine, with what came of it; *tolerated* and *deviation* pass, with
//! their reason in the suite's output.
//!
//! There are two schemas of JUnit files that tools validate against: that of Ant's JUnit task (`JUnit.xsd`) and that of
//! Jenkins (`junit-10.xsd`). The document keeps to what both allow: `reports/tests/junit.xsd`. So cases have no properties
//! and no output of their own: clause, requirement and frames stand in the text of a failure.

use super::told::Told;
use super::{Run, cct_forecast, name_in_family, quarantined, repetitions};
use crate::escape::{Visible, printable};
use crate::provenance;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use canvass_traces::{Duration, Timestamp};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::io::{self, Write};

type Xml<'a> = Writer<&'a mut dyn Write>;

/// Writes the document.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut out = Visible::new(out, false);
    let mut xml: Xml<'_> = Writer::new_with_indent(&mut out, b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("testsuites").write_inner_content(|xml| {
        let suites = run.families().into_iter().enumerate();
        suites.into_iter().try_for_each(|(number, (family, cases))| suite(xml, run, number, family, &cases))
    })?;
    writeln!(xml.into_inner())
}

fn suite(xml: &mut Xml<'_>, run: &Run, number: usize, family: &str, cases: &[&CaseReport]) -> io::Result<()> {
    let count = |element: &str| cases.iter().filter(|report| outcome(report) == Some(element)).count().to_string();
    let nanos = cases.iter().map(|report| report.duration.nanos()).sum();
    xml.create_element("testsuite")
        .with_attributes([
            ("name", family),
            ("package", "canvass"),
            ("id", &number.to_string()),
            ("timestamp", &date_time(began(cases))),
            ("hostname", "localhost"),
            ("tests", &cases.len().to_string()),
            ("failures", &count("failure")),
            ("errors", &count("error")),
            ("skipped", &count("skipped")),
            ("time", &seconds(Duration::from_nanos(nanos))),
        ])
        .write_inner_content(|xml| {
            properties(xml, run)?;
            cases.iter().try_for_each(|report| test_case(xml, report))?;
            let remarks: Vec<String> = cases.iter().copied().flat_map(remarks).collect();
            xml.create_element("system-out").write_text_content(BytesText::new(&remarks.join("\n")))?;
            xml.create_element("system-err").write_empty().map(|_| ())
        })
        .map(|_| ())
}

fn properties(xml: &mut Xml<'_>, run: &Run) -> io::Result<()> {
    let [name, _, software] = &run.info.device.names;
    let text = |text: &Option<String>| printable(text.as_deref().unwrap_or_default()).into_owned();
    let host = run.summary.host.as_ref().map(super::host::sentence).unwrap_or_default();
    let properties = [
        ("node", run.info.node.to_string()),
        ("bus", printable(&run.info.bus).into_owned()),
        ("model", printable(&run.info.model).into_owned()),
        ("device", text(name)),
        ("software", text(software)),
        ("seed", run.info.seed.to_string()),
        ("host", host),
    ];
    let properties = properties.map(|(name, value)| (name.to_owned(), value)).into_iter();
    let mut properties = properties.chain(provenance::junit_properties(&run.provenance));
    xml.create_element("properties")
        .write_inner_content(|xml| {
            properties.try_for_each(|(name, value)| {
                let property = xml.create_element("property");
                let property = property.with_attributes([("name", name.as_str()), ("value", value.as_str())]);
                property.write_empty().map(|_| ())
            })
        })
        .map(|_| ())
}

fn test_case(xml: &mut Xml<'_>, report: &CaseReport) -> io::Result<()> {
    let classname = report.case.family().replace('/', ".");
    let case = xml.create_element("testcase").with_attributes([
        ("name", name_in_family(report.case.id)),
        ("classname", &classname),
        ("time", &seconds(report.duration)),
    ]);
    let Some(element) = outcome(report) else { return case.write_empty().map(|_| ()) };
    let reason = report.verdict.reason().map(|reason| printable(&reason.to_string()).into_owned()).unwrap_or_default();
    let message = match quarantined(report) {
        Some(quarantined) => format!("{quarantined}; {}: {reason}", report.verdict.kind()),
        None => reason,
    };
    case.write_inner_content(|xml| {
        let outcome = xml.create_element(element).with_attribute(("message", message.as_str()));
        if element == "skipped" {
            return outcome.write_empty().map(|_| ());
        }
        let outcome = outcome.with_attribute(("type", report.verdict.kind().name()));
        outcome.write_text_content(BytesText::new(&details(report))).map(|_| ())
    })
    .map(|_| ())
}

/// The element that says how a case ended; none where it passed.
fn outcome(report: &CaseReport) -> Option<&'static str> {
    match report.verdict.kind() {
        Kind::Pass | Kind::Tolerated | Kind::Deviation => None,
        _ if report.quarantine.is_some() => Some("skipped"),
        Kind::Fail => Some("failure"),
        Kind::Error | Kind::Inconclusive => Some("error"),
        Kind::NotApplicable => Some("skipped"),
    }
}

/// What a person looks at when a case failed.
fn details(report: &CaseReport) -> String {
    let mut lines = vec![
        report.case.id.to_owned(),
        format!("{} ({})", report.case.clause, report.case.level.name()),
        printable(report.case.requirement).into_owned(),
    ];
    let told = Told::all(report);
    lines.extend(told.iter().map(|told| format!("{}: expected {}, found {}", told.duty, told.expected, told.found)));
    lines.extend(told.iter().filter_map(Told::waiver).map(|waiver| format!("as data: {waiver}")));
    lines.extend(cct_forecast(report).map(|forecast| format!("forecast for CiA's test tool: {forecast}")));
    lines.extend(repetitions(report));
    lines.extend(report.notes.iter().map(|note| format!("note: {note}")));
    for exhibit in report.evidence.frames() {
        let record = &exhibit.record;
        lines.push(format!("({}) {} {}", record.timestamp, record.frame, exhibit.text));
    }
    lines.iter().map(|line| printable(line).into_owned()).collect::<Vec<_>>().join("\n")
}

/// What is to be said of a case that did not simply pass, and did not fail.
fn remarks(report: &CaseReport) -> Vec<String> {
    if matches!(report.verdict.kind(), Kind::Fail | Kind::Error | Kind::Inconclusive) {
        return Vec::new();
    }
    let mut remarks = Vec::new();
    for told in Told::all(report).iter().filter(|told| matches!(told.kind, Kind::Tolerated | Kind::Deviation)) {
        remarks.push(format!("{}: {}: expected {}, found {}", told.kind, told.duty, told.expected, told.found));
        let documented = told.excuse.iter().map(|excuse| &excuse.documented);
        remarks.extend(documented.map(|text| format!("{}: {text}", told.authority().to_lowercase())));
    }
    remarks.extend(repetitions(report));
    remarks.extend(report.notes.iter().map(|note| format!("note: {note}")));
    remarks.iter().map(|remark| printable(&format!("{}: {remark}", report.case.id)).into_owned()).collect()
}

/// When the first of the frames came: of a simulated bus since its power-on, so that the same run gives the same bytes.
fn began(cases: &[&CaseReport]) -> Timestamp {
    let first = cases.iter().find_map(|report| report.evidence.frames().next());
    first.map_or(Timestamp::ZERO, |exhibit| exhibit.record.timestamp)
}

/// Date and time of day in UTC to the second, without a time zone, as the schemas want it.
fn date_time(at: Timestamp) -> String {
    let seconds = i64::try_from(at.nanos() / 1_000_000_000).unwrap_or(0);
    let at = jiff::Timestamp::from_second(seconds).unwrap_or(jiff::Timestamp::UNIX_EPOCH);
    at.strftime("%Y-%m-%dT%H:%M:%S").to_string()
}

fn seconds(span: Duration) -> String {
    format!("{}.{:03}", span.nanos() / 1_000_000_000, span.nanos() / 1_000_000 % 1_000)
}
