use super::name;
use crate::findings::rule::CaptureRule;
use crate::findings::sink::{Report, Sink};
use crate::findings::source::SourceQuality;
use canvass_macros::rule;

/// parts of the capture can't be read
///
/// Lines, packets or messages of the capture violate the rules of its format or are truncated, or the file has no
/// proper end. Damages are counted by kind; the decoder names each of them with its place.
///
/// # Why
/// The diagnosis lacks the frames at these places. Rules that wait for an answer or the next heartbeat start again
/// after each damage, so that no node is blamed for a fault of the file.
///
/// # What to do
/// Check the places that are named on standard error. A truncated file comes from a recorder that was switched off;
/// malformed lines come from editing or from a tool that writes another dialect.
#[rule(id = "capture/damaged", severity = Warning, rank = Detail, of = capture)]
struct Damaged;

impl CaptureRule for Damaged {
    fn check(&self, at: usize, source: &SourceQuality<'_>, sink: &mut Sink<'_>) {
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
}
