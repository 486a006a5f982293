use crate::findings::rule::{Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Service;
use canvass_traces::{Duration, Timestamp};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &Service::ALL,
    make: Some(|thresholds| {
        Box::new(Load {
            percent: thresholds.get(&METADATA, "percent"),
            window: Duration::from_millis(thresholds.get(&METADATA, "window").max(1)),
            begin: None,
            bits: 0,
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "bus/load",
    severity: Severity::Warning,
    title: "the bus is nearly full",
    what: "The bits of all frames within a window, with their stuff bits and the pauses between frames, fill more \
           than the given share of it. The bit rate is the one that was said, or is inferred from frames that follow \
           each other without a pause; where neither is possible, nothing is said.",
    why: "What is sent with a high CAN-ID waits until nothing more important is sent. At a high load answers come \
          late, PDOs lose their cycle, and controllers with small buffers lose frames.",
    advice: "See in the statistics which node and service takes most. Lengthen event timers, set inhibit times, send \
             cyclic data synchronously, or raise the bit rate.",
    thresholds: &[
        Threshold { name: "percent", default: 85, unit: "%", meaning: "a load above this is reported" },
        Threshold { name: "window", default: 1000, unit: "ms", meaning: "over which the load is taken" },
    ],
};

struct Load {
    percent: u64,
    window: Duration,
    begin: Option<Timestamp>,
    bits: u64,
}

impl Rule for Load {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (bits, now) = (context.bits, context.now());
        let begin = *self.begin.get_or_insert(now);
        let elapsed = now.since(begin);
        if elapsed < self.window {
            self.bits += u64::from(bits);
            return;
        }
        // A window that is longer than asked for has had a pause in it: its load is lower all the same.
        if let Some(rate) = context.scene.bit_rate {
            let most = u128::from(rate) * u128::from(elapsed.nanos()) / 1_000_000_000;
            let load = (u128::from(self.bits) * 100 / most.max(1)) as u64;
            if load > self.percent {
                sink.report(Report::at(begin).measure(load).evidence(context.evidence()), || {
                    let length = self.window;
                    format!("{load} % of {} kbit/s within {length}, which ends here", f64::from(rate) / 1000.0)
                });
            }
        }
        (self.begin, self.bits) = (Some(now), u64::from(bits));
    }

    fn interrupted(&mut self) {
        self.begin = None;
        self.bits = 0;
    }
}
