//! How promptly the device answers what costs it nothing: one that gets no processor is late as a whole, and its times say nothing
//! of its clock.

use super::sdo::DEVICE_TYPE;
use super::{Bench, HOST_LATE};
use crate::verdict::Stop;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_traces::{Duration, Timestamp};

/// Reads beside a case, at most.
const READS: usize = 100;

/// As many reads at least tell whether a device is late now and then, or answers now sooner and now later by its nature.
const FEWEST_READS: u32 = 20;

/// From one read to the next.
const PAUSE: Duration = Duration::from_millis(20);

/// How long the device took to answer reads of an object that does not change.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Promptness {
    /// The least time in the run.
    usual: Option<Duration>,
    /// The longest in the case, and in the run.
    longest: Duration,
    longest_of_run: Duration,
    /// The reads of the run, and how many of them took much longer than usual.
    reads: u32,
    late: u32,
}

impl Promptness {
    fn note(&mut self, took: Duration) {
        self.usual = Some(self.usual.map_or(took, |usual| usual.min(took)));
        self.longest = self.longest.max(took);
        self.longest_of_run = self.longest_of_run.max(took);
        self.reads += 1;
        self.late += u32::from(self.usual.is_some_and(|usual| took.0 >= usual.0 + HOST_LATE.0));
    }

    /// A case begins.
    pub fn begin(&mut self) {
        self.longest = Duration::ZERO;
    }

    /// The least time, or zero as long as nothing was answered.
    pub fn usual(self) -> Duration {
        self.usual.unwrap_or_default()
    }

    /// Whether one answer in four comes late: the device answers so by its nature, and that says nothing of its timers. One that
    /// gets too little processor now and then is prompt most of the time.
    const fn varies(self) -> bool {
        self.reads >= FEWEST_READS && self.late * 4 >= self.reads
    }

    /// By how much the device was later than usual in the case.
    fn lateness(self) -> Duration {
        if self.varies() { Duration::ZERO } else { self.beyond_usual(self.longest) }
    }

    fn beyond_usual(self, longest: Duration) -> Duration {
        Duration(longest.0.saturating_sub(self.usual().0))
    }

    /// Whether nothing is to be learned by one more read.
    fn is_known(self, enough: Duration) -> bool {
        self.reads >= FEWEST_READS && (self.varies() || self.lateness() >= enough)
    }
}

impl Bench<'_> {
    /// The device has answered a read of its device type, which was asked for then.
    pub(super) fn note_answer(&mut self, asked: Timestamp) {
        self.knowledge.promptness.note(self.traffic.taken_at().since(asked));
    }
}

/// By how much the device was later than usual, in the case or right beside it: it is asked again and again until that is
/// `enough`, or often enough. One that does not answer is not late.
pub(crate) fn lateness(bench: &mut Bench<'_>, enough: Duration) -> Duration {
    // Frames on the bus delay an answer, too: that is no lateness of the device.
    let by_bus = bench.bus_delay();
    let enough = enough + by_bus;
    let beyond = |lateness: Duration| Duration(lateness.0.saturating_sub(by_bus.0));
    if bench.knowledge.promptness.is_known(enough) {
        return beyond(bench.knowledge.promptness.lateness());
    }
    let looked = bench.uncancelled(|bench| bench.unjudged(|bench| look_beside(bench, enough)));
    // A look that ends early has seen what it has seen.
    drop(looked);
    beyond(bench.knowledge.promptness.lateness())
}

/// By how much the device was later than usual at some time in the run, frames on the bus left out. That excuses nothing, so it
/// does not matter whether its answers vary.
pub(crate) fn lateness_of_run(bench: &Bench<'_>) -> Duration {
    let promptness = bench.knowledge.promptness;
    Duration(promptness.beyond_usual(promptness.longest_of_run).0.saturating_sub(bench.bus_delay().0))
}

fn look_beside(bench: &mut Bench<'_>, enough: Duration) -> Result<(), Stop> {
    if !bench.answers()? {
        // Stopped, for example.
        bench.prepare()?;
    }
    for _ in 0..READS {
        if bench.knowledge.promptness.is_known(enough) || !read_beside(bench)? {
            break;
        }
        bench.wait_for(PAUSE, |_| None::<()>)?;
    }
    Ok(())
}

fn read_beside(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    bench.drain()?;
    bench.traffic.wait_for_quiet(bench.knowledge.slowest_answer)?;
    let response = sdo::RESPONSE_BASE + u16::from(bench.node().raw());
    let request = Request::upload(DEVICE_TYPE).to_frame(sdo::REQUEST_BASE + u16::from(bench.node().raw()));
    let sent = bench.send(&request)?;
    let is_response = |cob_id| cob_id == Some(response);
    let answered =
        bench.wait_for(bench.timing().sdo_response, |record| is_response(record.frame.cob_id()).then_some(()))?;
    if answered.is_some() {
        bench.note_answer(sent.at);
    }
    Ok(answered.is_some())
}
