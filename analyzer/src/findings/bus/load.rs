use crate::findings::effect::{Effect, MONITORING, SETTLE};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen, Thresholds};
use crate::statistics::RATES;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// EMCY codes caused by the bus: overrun, error passive, recovered from bus off, communication.
const OF_BUS: &[u64] = &[0x8110, 0x8120, 0x8140, 0x8100];

/// Messages that a full bus delays.
const EFFECTS: &[Effect] = &[
    Effect::on(&["nodes/heartbeat-late", "nodes/heartbeat-jitter", "nodes/heartbeat-missing"]).spanning(SETTLE),
    Effect::on(&["nodes/consumer-time", "nodes/life-guarding", "nodes/guarding-unanswered"]).spanning(SETTLE),
    Effect::on(&["sdo/late", "sdo/retries", "sdo/unanswered", "sdo/impatient-client"]).spanning(SETTLE),
    Effect::on(&["pdo/period", "pdo/jitter", "pdo/sync-missing", "pdo/sync-jitter"]).spanning(SETTLE),
    Effect::on(&["pdo/sync-window", "pdo/sync-pdo-missing"]).spanning(SETTLE),
    Effect::on(&["emcy/raised"]).with_codes(OF_BUS).spanning(SETTLE),
    Effect::on(&["emcy/raised"]).with_codes(MONITORING).spanning(SETTLE),
];

/// the bus is nearly full
///
/// The bits of all frames within a window, with stuff bits and the pauses between frames, fill more than the given
/// share of the window. The bit rate is given by the user, or inferred from frames that follow each other without a
/// pause; if neither is possible, the rule reports nothing. The rule infers a bit rate that is high enough for the
/// frames of every tenth of a second.
///
/// # Why
/// A frame with a high CAN-ID waits until no frame with higher priority is sent. At a high load answers come late, PDOs
/// lose their cycle, and controllers with small buffers lose frames.
///
/// # What to do
/// Find the node and service with the highest load in the statistics. Lengthen event timers, set inhibit times, send
/// cyclic data synchronously, or raise the bit rate.
#[rule(id = "bus/load", severity = Warning, rank = Participants, services = all, leads_to = EFFECTS)]
struct Load {
    /// a higher load is reported
    #[threshold(percent = 85)]
    percent: Percent,
    /// length of the window over which the load is measured
    #[threshold(ms = 1000, min = 1)]
    window: Duration,
    begin: Option<Timestamp>,
    bits: u64,
    /// Full windows at each bit rate: the right bit rate may be known only at the end.
    #[from(full)]
    full: Vec<Full>,
}

/// Full windows at one bit rate.
#[derive(Default)]
struct Full {
    rate: u32,
    count: u64,
    first: Timestamp,
    last: Timestamp,
    /// The fullest window: percent, and the frame that ended it.
    worst: Option<(u64, Seen)>,
}

/// The initial state: no full window at any usual bit rate.
fn full(_: &Thresholds) -> Vec<Full> {
    RATES.into_iter().map(|rate| Full { rate, ..Full::default() }).collect()
}

impl Full {
    fn window(&mut self, (bits, begin, elapsed): (u64, Timestamp, Duration), percent: Percent, end: &Seen) {
        let most = u128::from(self.rate) * u128::from(elapsed.nanos()) / 1_000_000_000;
        let load = (u128::from(bits) * 100 / most.max(1)) as u64;
        if load <= percent.0 {
            return;
        }
        self.first = if self.count == 0 { begin } else { self.first };
        (self.last, self.count) = (begin, self.count + 1);
        if self.worst.as_ref().is_none_or(|worst| load > worst.0) {
            self.worst = Some((load, end.clone()));
        }
    }
}

impl Load {
    /// Judges a window. A pause makes a window longer than requested, and its load lower.
    #[cold]
    fn judge(&mut self, begin: Timestamp, elapsed: Duration, context: &Context<'_>) {
        let end = context.seen();
        if let Some(rate) = context.scene.bit_rate.filter(|rate| self.full.iter().all(|full| full.rate != *rate)) {
            self.full.push(Full { rate, ..Full::default() });
        }
        for full in &mut self.full {
            full.window((self.bits, begin, elapsed), self.percent, &end);
        }
        (self.begin, self.bits) = (Some(context.now()), u64::from(context.bits));
    }
}

impl Rule for Load {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let (bits, now) = (context.bits, context.now());
        let begin = *self.begin.get_or_insert(now);
        let elapsed = now.since(begin);
        if elapsed < self.window {
            self.bits += u64::from(bits);
        } else {
            self.judge(begin, elapsed, context);
        }
    }

    fn interrupted(&mut self) {
        self.begin = None;
        self.bits = 0;
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let full = self.full.iter().find(|full| Some(full.rate) == scene.bit_rate);
        let Some((full, (load, end))) = full.and_then(|full| Some((full, full.worst.as_ref()?))) else { return };
        let message = || {
            let (rate, length) = (f64::from(full.rate) / 1000.0, self.window);
            let inferred = if scene.is_inferred { " (inferred)" } else { "" };
            // The first frame may have begun before the window, so a little more than 100 % is possible.
            let wrong =
                if *load > 101 && !scene.is_inferred { ": more than fits: the bit rate must be higher" } else { "" };
            format!("up to {load} % of {rate} kbit/s{inferred} within {length}{wrong}")
        };
        sink.report(Report::at(full.first).measure(*load).evidence(end.evidence()), message);
        if full.count > 1 {
            sink.report(Report::at(full.last).times(full.count - 1), message);
        }
    }
}
