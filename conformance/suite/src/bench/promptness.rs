//! The time that the device takes to answer cheap requests. A device without processor time is late as a whole, and its
//! times say nothing about its clock.

use super::sdo::DEVICE_TYPE;
use super::{Bench, HOST_LATE};
use crate::verdict::Stop;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_traces::{Duration, Timestamp};

/// Maximum number of reads beside a case.
const READS: usize = 100;

/// Minimum number of reads that show whether a device is late now and then, or has response times that vary by its
/// nature.
const FEWEST_READS: u32 = 20;

/// Wait between two reads.
const PAUSE: Duration = Duration::from_millis(20);

/// Response times of the device to reads of an object that does not change.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Promptness {
    /// The shortest time in the run.
    usual: Option<Duration>,
    /// The longest time in the case.
    longest: Duration,
    /// The longest time in the run.
    longest_of_run: Duration,
    /// Number of reads in the run, and number of reads that took much longer than usual.
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

    /// Begins a case: forgets the longest time of the last case.
    pub fn begin(&mut self) {
        self.longest = Duration::ZERO;
    }

    /// The shortest time in the run; zero before the first answer.
    pub fn usual(self) -> Duration {
        self.usual.unwrap_or_default()
    }

    /// Whether at least one answer in four comes late: then the response times vary by nature and say nothing about
    /// timers. A device that sometimes gets too little processor time is prompt most of the time.
    const fn varies(self) -> bool {
        self.reads >= FEWEST_READS && self.late * 4 >= self.reads
    }

    /// The longest delay beyond the usual time in the case.
    fn lateness(self) -> Duration {
        self.beyond_usual(self.longest)
    }

    /// The part of `longest` beyond the usual time; zero if the response times vary by nature.
    fn beyond_usual(self, longest: Duration) -> Duration {
        if self.varies() { Duration::ZERO } else { Duration(longest.0.saturating_sub(self.usual().0)) }
    }

    /// Whether one more read would add nothing.
    fn is_known(self, enough: Duration) -> bool {
        self.reads >= FEWEST_READS && (self.varies() || self.lateness() >= enough)
    }
}

impl Bench<'_> {
    /// Records that the device has answered a read of its device type sent at `asked`.
    pub(super) fn note_answer(&mut self, asked: Timestamp) {
        self.knowledge.promptness.note(self.traffic.taken_at().since(asked));
    }
}

/// The delay of the device beyond its usual time, in the case or right after it. The device is asked until the delay
/// reaches `enough`, or until it was asked often enough. A device that does not answer is not late.
pub(crate) fn lateness(bench: &mut Bench<'_>, enough: Duration) -> Duration {
    // Frames on the bus delay an answer too: that is no lateness of the device.
    let by_bus = bench.bus_delay();
    let enough = enough + by_bus;
    let beyond = |lateness: Duration| Duration(lateness.0.saturating_sub(by_bus.0));
    if bench.knowledge.promptness.is_known(enough) {
        return beyond(bench.knowledge.promptness.lateness());
    }
    let looked = bench.uncancelled(|bench| bench.unjudged(|bench| look_beside(bench, enough)));
    // If the measurement ends early, its reads so far still count.
    drop(looked);
    beyond(bench.knowledge.promptness.lateness())
}

/// The longest delay of the device beyond its usual time in the run, without the delay by frames on the bus.
pub(crate) fn lateness_of_run(bench: &Bench<'_>) -> Duration {
    let promptness = bench.knowledge.promptness;
    Duration(promptness.beyond_usual(promptness.longest_of_run).0.saturating_sub(bench.bus_delay().0))
}

fn look_beside(bench: &mut Bench<'_>, enough: Duration) -> Result<(), Stop> {
    if !bench.answers()? {
        // The device does not answer, for example because it is stopped.
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
