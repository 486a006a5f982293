use super::error_frames::is_error;
use crate::findings::effect::{Effect, MONITORING, SETTLE, SOON};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::wire::error_frame::ErrorFrame;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// EMCY codes of nodes that notice errors on the bus: communication, overrun, error passive, recovered from bus-off.
const OF_BUS: &[u64] = &[0x8100, 0x8110, 0x8120, 0x8140];

/// Effects: hardly a frame gets through.
const EFFECTS: &[Effect] = &[
    Effect::on(&["capture/error-frames", "capture/error-passive", "capture/bus-off"]).spanning(SETTLE),
    Effect::on(&["nodes/lost", "nodes/heartbeat-missing", "nodes/heartbeat-late", "nodes/heartbeat-ended"])
        .during(SETTLE, SOON),
    Effect::on(&["nodes/consumer-time", "nodes/life-guarding", "nodes/guarding-unanswered"]).during(SETTLE, SETTLE),
    Effect::on(&["emcy/raised"]).with_codes(OF_BUS).during(SOON, SETTLE),
    Effect::on(&["emcy/raised"]).with_codes(MONITORING).during(SOON, SETTLE),
    Effect::never_on(&["bus/duplicate-node-id", "bus/two-producers"]),
    Effect::on(&["pdo/", "sdo/unanswered", "sdo/retries", "sdo/late", "sdo/unfinished", "sdo/protocol-violation"])
        .during(SOON, SETTLE),
    Effect::on(&["nodes/state-lost", "nodes/heartbeat-jitter", "capture/gaps"]).during(SOON, SETTLE),
];

/// errors disturb the bus again and again
///
/// Error frames follow each other, with short pauses, and are at least a fourth of all frames meanwhile: frame after frame
/// is destroyed. Frames that nodes do not send meanwhile are no fault of these nodes.
///
/// # Why
/// While errors come at this rate, hardly a frame gets through, of whatever node: the fault is in what all nodes share.
///
/// # What to do
/// Look at the physical layer first: measure 60 ohms between the wires with the supply off, look for a short circuit
/// and a loose connector, and compare the bit rates. If it comes and goes, disconnect the nodes one by one: a defective
/// transceiver disturbs everybody. The nodes that fall silent are not the cause.
#[rule(id = "capture/error-flood", severity = Error, rank = Loss, services = [ErrorFrame], leads_to = EFFECTS)]
struct ErrorFlood {
    /// least number of error frames
    #[threshold(count = 10, min = 2)]
    frames: u64,
    /// longest pause between two successive error frames
    #[threshold(ms = 500)]
    pause: Duration,
    flood: Option<Flood>,
}

/// Error frames that follow each other.
struct Flood {
    first: Seen,
    last: Timestamp,
    count: u64,
    /// Number of frames of the bus up to the first error frame of the flood, and up to the last one.
    frames: [u64; 2],
}

impl Flood {
    /// Whether the errors are a considerable part of the traffic: a few error frames among many good frames disturb
    /// nobody.
    fn disturbs(&self) -> bool {
        const SHARE: u64 = 4;
        let [first, last] = self.frames;
        SHARE * self.count >= last.saturating_sub(first)
    }
}

impl ErrorFlood {
    /// Ends the flood if its last error frame is longer ago than the longest pause; without `now`, ends it at once.
    fn flush(&mut self, now: Option<Timestamp>, sink: &mut Sink<'_>) {
        let ends = |flood: &Flood| now.is_none_or(|now| now.since(flood.last) > self.pause);
        let is_flood = |flood: &Flood| flood.count >= self.frames && flood.disturbs();
        let Some(flood) = self.flood.take_if(|flood| ends(flood)).filter(is_flood) else { return };
        let Flood { first, last, count, .. } = flood;
        let report = Report::at(first.time()).until(last).measure(count).evidence(first.evidence());
        sink.report(report, || {
            let first_error = ErrorFrame::of(&first.record.frame).map(|error| format!("; the first: {error}"));
            format!("{count} error frames within {}{}", last.since(first.time()), first_error.unwrap_or_default())
        });
    }
}

impl Rule for ErrorFlood {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let is_error = ErrorFrame::of(&context.record.frame).is_some_and(|error| is_error(&error));
        if !is_error || !context.scene.has_times() {
            return;
        }
        self.flush(Some(context.now()), sink);
        let frames = context.scene.quality.frames.total();
        let flood = || Flood { first: context.seen(), last: context.now(), count: 0, frames: [frames; 2] };
        let flood = self.flood.get_or_insert_with(flood);
        (flood.last, flood.count, flood.frames[1]) = (context.now(), flood.count + 1, frames);
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        self.flush(Some(scene.now), sink);
    }

    fn interrupted(&mut self) {
        // Pauses across a gap are not known.
        self.flood = None;
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        self.flush(None, sink);
    }
}
