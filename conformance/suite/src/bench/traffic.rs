//! The bus and its traffic: sending and receiving frames, their senders, and how well the tester keeps up.

use super::clients::Clients;
use super::open_transfer::OpenTransfer;
use super::watch::Watch;
use super::{Annotate, Evidence, Exhibit, HOST_LATE, Target};
use crate::verdict::{Reason, Stop};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::{emcy, error_control, sdo};
use canvass_bus::{Bus, BusError, Health};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp};
use std::sync::atomic::{AtomicBool, Ordering};

/// Interval at which a wait on a live bus checks whether the user has cancelled.
const SLICE: Duration = Duration::from_millis(200);

/// Maximum number of frames that listening keeps: more than any period or count needs.
const LISTENED: usize = 20_000;

/// Number of frames after which the bench checks whether frames were lost.
const LOOK_AT_LOSSES: u64 = 512;

/// Proof that a frame was handed to the bus, with its time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sent {
    /// The time of the bus when the frame was handed over.
    pub at: Timestamp,
}

/// The traffic on the bus. It knows nothing of the changes that a frame makes in the device.
pub(crate) struct Traffic<'a> {
    pub(super) bus: &'a mut dyn Bus,
    annotate: &'a mut dyn Annotate,
    cancel: &'a AtomicBool,
    node: NodeId,
    /// The time at which the time limit ends the run.
    ends: Timestamp,
    evidence: Evidence,
    pub(crate) watch: Watch,
    pub(crate) clients: Clients,
    pub(super) transfer: OpenTransfer,
    /// Whether the tester is putting something back. Otherwise waits end at once when the user cancels.
    pub(super) restoring: bool,
    /// The time of the last frame on the bus.
    taken_at: Timestamp,
    /// Number of frames lost before the case; `None` if lost frames end no wait.
    lost_before: Option<u64>,
    /// Number of frames taken since `lost_before` was noted.
    taken: u64,
    fd_frames: u64,
}

impl<'a> Traffic<'a> {
    /// `limit`: the time limit of the run. `cancel` ends every wait once it is set.
    pub(super) fn new(
        bus: &'a mut dyn Bus,
        target: &Target,
        limit: Option<Duration>,
        annotate: &'a mut dyn Annotate,
        cancel: &'a AtomicBool,
    ) -> Self {
        Self {
            ends: limit.map_or(Timestamp::MAX, |limit| bus.now() + limit),
            bus,
            annotate,
            cancel,
            node: target.node,
            evidence: Evidence::default(),
            watch: Watch::new(target.node),
            clients: Clients::new(target.node, target.description.as_ref()),
            transfer: OpenTransfer::new(target.node),
            restoring: false,
            taken_at: Timestamp::ZERO,
            lost_before: None,
            taken: 0,
            fd_frames: 0,
        }
    }

    /// The time on the bus.
    pub(crate) fn now(&self) -> Timestamp {
        self.bus.now()
    }

    /// The time of the last frame on the bus.
    pub(super) const fn taken_at(&self) -> Timestamp {
        self.taken_at
    }

    /// The state of the bus and of the tester's own machine.
    pub(crate) fn health(&self) -> Health {
        self.bus.health()
    }

    /// Whether the bus is a live one.
    pub(crate) fn is_live(&self) -> bool {
        self.bus.is_live()
    }

    /// The bit rate of the bus in bit/s, if it is known.
    pub(crate) fn bit_rate(&self) -> Option<u32> {
        self.bus.bit_rate()
    }

    /// Changes the bit rate of this end of the bus, in bit/s.
    pub(crate) fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.bus.set_bit_rate(bit_rate)
    }

    /// Time by which the bus alone may delay a frame, or shorten the interval to the next frame: the longest frame may
    /// occupy the wire when the frame is due, and then the frame itself occupies the wire. If the bit rate is unknown,
    /// it is assumed to be 125 kbit/s.
    pub(crate) fn bus_delay(&self) -> Duration {
        /// A 29-bit frame of eight bytes with all its stuff bits, and the intermission.
        const LONGEST: u64 = 160;
        const USUAL_BIT_RATE: u32 = 125_000;
        let bit_rate = u64::from(self.bit_rate().unwrap_or(USUAL_BIT_RATE).max(1));
        Duration::from_nanos(2 * LONGEST * 1_000_000_000 / bit_rate)
    }

    /// The longest delay of the tester's machine so far, in receiving or sending, but at most [`HOST_LATE`]: a longer
    /// delay excuses the device altogether.
    pub(crate) fn host_delay(&self) -> Duration {
        self.health().latest().unwrap_or_default().min(HOST_LATE)
    }

    /// The frames on the bus since the case began.
    pub(crate) const fn evidence(&self) -> &Evidence {
        &self.evidence
    }

    /// Whether the run must end: the user has cancelled it, or its time is over.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.is_out_of_time()
    }

    /// Whether the time of the run is over.
    pub(crate) fn is_out_of_time(&self) -> bool {
        self.ends != Timestamp::MAX && self.bus.now() >= self.ends
    }

    pub(super) fn check_cancelled(&self) -> Result<(), Stop> {
        if self.is_cancelled() && !self.restoring {
            let why =
                if self.is_out_of_time() { "the time limit of the run was reached" } else { "the run was cancelled" };
            let reason = Reason::new("the case runs to its end", "no interruption", why);
            return Err(Stop::Inconclusive(reason));
        }
        Ok(())
    }

    /// Forgets the evidence of the case before. Messages of other clients still count for the whole run.
    pub(super) fn begin(&mut self) {
        self.evidence = Evidence::default();
        self.clients.begin();
        self.watch.forget();
    }

    /// Makes waits end as soon as lost frames are seen: a case that loses frames says nothing about the device.
    pub(crate) fn end_when_frames_are_lost(&mut self) {
        self.lost_before = Some(self.bus.health().lost);
        self.taken = 0;
    }

    /// Lets waits continue despite lost frames: the device is put back in any case.
    pub(super) fn bear_lost_frames(&mut self) {
        self.lost_before = None;
    }

    /// The frames of the case.
    pub(super) fn take_evidence(&mut self) -> Evidence {
        std::mem::take(&mut self.evidence)
    }

    /// Hands a frame to the bus.
    pub(super) fn send(&mut self, frame: &Frame) -> Result<Sent, Stop> {
        let at = self.bus.now();
        self.transfer.on_sent(frame);
        self.bus.send(frame).map_err(|error| broken(&error))?;
        Ok(Sent { at })
    }

    /// The next frame on the bus until `deadline`, including own frames. Each frame becomes evidence.
    pub(super) fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, Stop> {
        loop {
            self.check_cancelled()?;
            let slice = deadline.min(self.bus.now() + SLICE);
            if let Some(record) = self.bus.receive(slice).map_err(|error| broken(&error))? {
                self.check_lost()?;
                self.fd_frames += u64::from(record.frame.is_fd());
                self.watch.observe(&record);
                self.taken_at = record.timestamp;
                if self.clients.observe(&record) && !self.is_own(&record.frame) {
                    self.clients.count(&record);
                }
                if record.direction != Direction::Tx && !self.clients.has_answered_others() {
                    self.transfer.on_answer(&record.frame);
                }
                let text = self.annotate.annotate(&record);
                let recorded = record.clone().at(self.annotate.number(), 0);
                self.evidence.push(Exhibit { record: recorded, text });
                return Ok(Some(record));
            }
            if slice == deadline {
                return Ok(None);
            }
        }
    }

    /// Whether the device under test sent a frame, with its node-ID or with a node-ID that it was given.
    fn is_own(&self, frame: &Frame) -> bool {
        let of_given = || frame.cob_id().and_then(NodeId::of_cob_id).filter(|&node| self.watch.is_given(node));
        is_from(self.node, frame) || of_given().is_some_and(|node| is_from(node, frame))
    }

    /// Ends the wait if the tester does not keep up with the bus, for example with a node that floods it: the run must
    /// still come to its end.
    fn check_lost(&mut self) -> Result<(), Stop> {
        self.taken += 1;
        let Some(before) = self.lost_before.filter(|_| !self.restoring && self.taken.is_multiple_of(LOOK_AT_LOSSES))
        else {
            return Ok(());
        };
        if self.bus.health().lost == before {
            return Ok(());
        }
        let actual = "it was ended because frames were lost";
        Err(Stop::Inconclusive(Reason::new("the case runs to its end", "no frame is lost", actual)))
    }

    /// Waits for a frame of another participant that `wanted` recognises. Skips all other traffic, including answers of
    /// the SDO server to other clients. `None` if `span` passes without such a frame.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus fails, [`Stop::Inconclusive`] if the run was cancelled.
    pub(crate) fn wait_for<T>(
        &mut self,
        span: Duration,
        mut wanted: impl FnMut(&Record) -> Option<T>,
    ) -> Result<Option<T>, Stop> {
        let deadline = self.bus.now() + span;
        while let Some(record) = self.receive(deadline)? {
            if record.direction != Direction::Tx
                && !self.clients.has_answered_others()
                && let Some(found) = wanted(&record)
            {
                return Ok(Some(found));
            }
            // A bus that never falls silent must not turn a wait into a hang.
            if record.timestamp > deadline {
                break;
            }
        }
        Ok(None)
    }

    /// Waits for `span` and returns the frames that the device under test sent meanwhile.
    ///
    /// # Errors
    /// The errors of [`Traffic::wait_for`].
    pub(crate) fn listen(&mut self, span: Duration) -> Result<Vec<Record>, Stop> {
        let node = self.node;
        let mut heard = Vec::new();
        self.wait_for(span, |record| {
            if is_from(node, &record.frame) && heard.len() < LISTENED {
                heard.push(record.clone());
            }
            None::<()>
        })?;
        Ok(heard)
    }

    /// Takes all frames that are already on the bus, so that a late answer is not taken for the answer to the next
    /// request.
    ///
    /// # Errors
    /// The errors of [`Traffic::wait_for`].
    pub(crate) fn drain(&mut self) -> Result<(), Stop> {
        self.wait_for(Duration::ZERO, |_| None::<()>).map(|_| ())
    }

    /// A notice about CAN FD frames on this bus, if any came: no device of classical CAN has sent them.
    pub(crate) fn fd_notice(&self) -> Option<String> {
        let frames = self.fd_frames;
        (frames > 0).then(|| {
            format!(
                "{frames} CAN FD frame{} came, and none was taken for an answer: CANopen is classical CAN, and a device of \
                 classical CAN on this bus takes them for errors",
                if frames == 1 { "" } else { "s" }
            )
        })
    }
}

/// Whether this node sends a frame according to the predefined connection set: EMCY, TPDO 1 to 4, SDO response or error
/// control. Other COB-IDs do not show their sender.
pub fn is_from(node: NodeId, frame: &Frame) -> bool {
    let Some(cob_id) = frame.cob_id() else { return false };
    NodeId::of_cob_id(cob_id) == Some(node)
        && (is_tpdo(cob_id)
            || matches!(cob_id & 0x780, emcy::CAN_ID_BASE | sdo::RESPONSE_BASE | error_control::CAN_ID_BASE))
}

/// Whether a CAN-ID is one of the predefined TPDOs 1 to 4.
pub const fn is_tpdo(cob_id: u16) -> bool {
    matches!(cob_id & 0x780, 0x180 | 0x280 | 0x380 | 0x480)
}

/// The stop for a failure of the bus, which is never the device's fault. Not every bus over a network carries every
/// frame.
pub(super) fn broken(error: &BusError) -> Stop {
    if let BusError::Unsendable { frame, reason } = error {
        return Stop::NotApplicable(Reason::new("this bus carries all frames of the case", *reason, frame.to_string()));
    }
    Stop::Error(Reason::new("the bus works", "frames in and out", error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{Bench, Options, Target};
    use canvass_analyzer::object;
    use canvass_traces::{CanId, ChannelId};
    use std::sync::atomic::AtomicBool;

    /// A bus over a network without remote frames.
    struct WithoutRemoteFrames;

    impl Bus for WithoutRemoteFrames {
        fn now(&self) -> Timestamp {
            Timestamp::ZERO
        }

        fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
            Err(BusError::Unsendable { frame: *frame, reason: "only data frames" })
        }

        fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
            Ok(None)
        }

        fn bit_rate(&self) -> Option<u32> {
            None
        }
    }

    #[test]
    fn a_frame_that_the_bus_cannot_carry_is_no_fault_of_the_device() {
        let (mut bus, options, cancel) = (WithoutRemoteFrames, Options::default(), AtomicBool::new(false));
        let target = Target::unknown(NodeId::new(63).unwrap());
        let mut annotate = |_: &Record| String::new();
        let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        let stop = bench.guard().unwrap_err();
        assert!(matches!(&stop, Stop::NotApplicable(_)), "{stop:?}");
    }

    /// A bus that is never silent, and loses every other frame on the way to the tester.
    #[derive(Default)]
    struct Flooded(u64);

    impl Bus for Flooded {
        fn now(&self) -> Timestamp {
            Timestamp(self.0 * 1_000)
        }

        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            Ok(())
        }

        fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
            self.0 += 1;
            let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
            Ok(Some(Record::new(self.now(), ChannelId(0), frame).with_direction(Direction::Rx)))
        }

        fn bit_rate(&self) -> Option<u32> {
            None
        }

        fn health(&self) -> Health {
            Health { lost: self.0, ..Health::default() }
        }
    }

    #[test]
    fn a_can_fd_frame_is_told_and_is_no_answer() {
        let script = |request: &Frame| match request.to_string().starts_with("63F#40") {
            true => ["5BF##04300100001000000", "5BF#4300100002000000"]
                .map(|answer| (Duration::from_millis(1), canvass_traces::parse_frame(answer).unwrap().frame))
                .to_vec(),
            false => Vec::new(),
        };
        crate::scripted::with_bench(script, |bench| {
            let value = bench.read(canvass_analyzer::Multiplexer::new(object::DEVICE_TYPE, 0));
            assert_eq!(value.unwrap(), [2, 0, 0, 0]);
            assert!(bench.traffic.fd_notice().unwrap().starts_with("1 CAN FD frame came"));
        });
    }

    #[test]
    fn a_case_ends_when_frames_are_lost_and_what_it_changed_is_put_back_all_the_same() {
        let (mut bus, options, cancel) = (Flooded::default(), Options::default(), AtomicBool::new(false));
        let target = Target::unknown(NodeId::new(63).unwrap());
        let mut annotate = |_: &Record| String::new();
        let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        let hour = Duration::from_secs(3_600);
        bench.traffic.end_when_frames_are_lost();
        assert!(matches!(bench.wait_for(hour, |_| None::<()>), Err(Stop::Inconclusive(_))));
        assert_eq!(bench.now(), Timestamp(512 * 1_000), "it looks at every 512th frame");
        // Five thousand frames come within this time.
        let more = Duration::from_millis(5);
        assert_eq!(bench.uncancelled(|bench| bench.wait_for(more, |_| None::<()>)), Ok(None));
        bench.finish();
        assert_eq!(bench.wait_for(more, |_| None::<()>), Ok(None), "no case runs any more");
    }
}
