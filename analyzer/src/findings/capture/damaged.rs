use super::name;
use crate::findings::Severity;
use crate::findings::diagnosis::SourceQuality;
use crate::findings::rule::{Also, Definition, Metadata, Thresholds};
use crate::findings::sink::{Report, Sink};

pub const RULE: Definition = Definition { metadata: &METADATA, services: &[], also: Also::Nothing, make: None };

static METADATA: Metadata = Metadata {
    id: "capture/damaged",
    severity: Severity::Warning,
    title: "parts of the capture can't be read",
    what: "Lines, packets or messages of the capture break the rules of its format, are cut, or the file has no \
           proper end. They are counted by kind; the decoder names each with its place.",
    why: "What stood there is missing in everything else that is said of this capture. Rules that wait for an answer \
          or a next beat start anew behind each damage, so that nothing is blamed on a node that may be the file's.",
    advice: "Look at the places that are named on standard error. A cut file comes from a recorder that was switched \
             off; malformed lines from editing or from a tool that writes another dialect.",
    thresholds: &[],
};

pub fn check(at: usize, source: &SourceQuality<'_>, _: &Thresholds, sink: &mut Sink<'_>) {
    let kinds = source.quality.damages.by_kind();
    let kinds: Vec<String> = kinds
        .iter()
        .filter(|(kind, count)| *count > 0 && *kind != "dropped")
        .map(|(kind, count)| format!("{count} {kind}"))
        .collect();
    if !kinds.is_empty() {
        let time = source.quality.first.unwrap_or_default();
        sink.report(Report::at(time).source(at), || format!("{}: {}", name(source), kinds.join(", ")));
    }
}
