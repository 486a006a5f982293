//! Frames out and in.

use super::{Bench, Exhibit};
use crate::verdict::{Reason, Stop};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::{emcy, error_control, sdo};
use canvass_bus::BusError;
use canvass_traces::{CanId, Direction, Duration, Frame, Record, Timestamp};

/// A wait on a live bus looks this often whether the user has cancelled.
const SLICE: Duration = Duration::from_millis(200);

/// A listener keeps no more frames than this; more than any period or count needs.
const LISTENED: usize = 20_000;

/// Whether frames were lost is looked at after so many.
const LOOK_AT_LOSSES: u64 = 512;

/// The proof that a frame was handed to the bus, and when.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sent {
    /// The time of the bus when the frame was handed over.
    pub at: Timestamp,
}

impl Bench<'_> {
    /// Sends a frame as it is, however wrong.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus does not take it, [`Stop::Inconclusive`] if the run was cancelled, [`Stop::NotApplicable`] if
    /// it would move a zero point or write the memory, and the user has not allowed that.
    pub fn send(&mut self, frame: &Frame) -> Result<Sent, Stop> {
        self.check_cancelled()?;
        self.check_leave(frame)?;
        self.journal_frame(frame)?;
        let at = self.bus.now();
        self.bus.send(frame).map_err(|error| broken(&error))?;
        Ok(Sent { at })
    }

    /// Sends up to eight bytes with an 11-bit CAN-ID.
    ///
    /// # Errors
    /// As [`Bench::send`]; [`Stop::Error`] if there are more than eight bytes.
    pub fn send_bytes(&mut self, cob_id: u16, bytes: &[u8]) -> Result<Sent, Stop> {
        match Frame::new(CanId::standard_masked(u32::from(cob_id)), bytes) {
            Some(frame) => self.send(&frame),
            None => Err(Stop::Error(Reason::new(
                "the tester sends a classical CAN frame",
                "up to 8 bytes",
                format!("{} bytes", bytes.len()),
            ))),
        }
    }

    /// The next frame on the bus until `deadline`, own frames among them. Each becomes evidence.
    pub(super) fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, Stop> {
        loop {
            self.check_cancelled()?;
            let slice = deadline.min(self.bus.now() + SLICE);
            if let Some(record) = self.bus.receive(slice).map_err(|error| broken(&error))? {
                self.check_lost()?;
                self.knowledge.fd_frames += u64::from(record.frame.is_fd());
                self.watch.observe(&record);
                self.taken_at = record.timestamp;
                if self.clients.observe(&record) && !self.is_own(&record.frame) {
                    self.foreign.count(&record, self.target.node);
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

    /// Whether the device under test sent a frame, with its node-ID or one that it was given.
    fn is_own(&self, frame: &Frame) -> bool {
        let of_given = || frame.cob_id().and_then(NodeId::of_cob_id).filter(|&node| self.watch.is_given(node));
        is_from(self.target.node, frame) || of_given().is_some_and(|node| is_from(node, frame))
    }

    /// A tester that does not keep up with the bus (a node that babbles faster than any bus) must still come to an end.
    fn check_lost(&mut self) -> Result<(), Stop> {
        self.taken += 1;
        let Some(before) = self.lost_before.filter(|_| !self.restoring && self.taken.is_multiple_of(LOOK_AT_LOSSES))
        else {
            return Ok(());
        };
        if self.bus.health().lost == before {
            return Ok(());
        }
        let actual = "it was ended, as frames were lost";
        Err(Stop::Inconclusive(Reason::new("the case runs to its end", "no frame is lost", actual)))
    }

    /// Waits for a frame of another participant that `wanted` recognises. Other traffic goes by, answers of the SDO server to
    /// other clients too. `None` when `span`
    /// has passed without it.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus fails, [`Stop::Inconclusive`] if the run was cancelled.
    pub fn wait_for<T>(
        &mut self,
        span: Duration,
        mut wanted: impl FnMut(&Record) -> Option<T>,
    ) -> Result<Option<T>, Stop> {
        let deadline = self.bus.now() + span;
        while let Some(record) = self.receive(deadline)? {
            if record.direction != Direction::Tx
                && !self.answered_others()
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

    /// Lets time pass and returns the frames that the device under test sent meanwhile.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn listen(&mut self, span: Duration) -> Result<Vec<Record>, Stop> {
        let node = self.node();
        let mut heard = Vec::new();
        self.wait_for(span, |record| {
            if is_from(node, &record.frame) && heard.len() < LISTENED {
                heard.push(record.clone());
            }
            None::<()>
        })?;
        Ok(heard)
    }

    /// What has come since then, of what is kept as evidence.
    pub(crate) fn heard_since(&self, begun: Timestamp) -> Vec<Record> {
        let records = self.evidence.frames().map(|exhibit| &exhibit.record);
        records.filter(|record| record.timestamp >= begun && record.direction == Direction::Rx).cloned().collect()
    }

    /// Takes in what was on the bus up to now, so that a late answer is not taken for that of the next request.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn drain(&mut self) -> Result<(), Stop> {
        self.wait_for(Duration::ZERO, |_| None::<()>).map(|_| ())
    }
}

/// Whether a frame is one that this node sends by the predefined connection set: EMCY, TPDO 1 to 4, SDO response or
/// error control. Other COB-IDs say nothing of their sender.
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

/// A failure of the bus is never the device's.
fn broken(error: &BusError) -> Stop {
    Stop::Error(Reason::new("the bus works", "frames in and out", error.to_string()))
}

impl Bench<'_> {
    /// What CAN FD frames on this bus mean, if any came: no device of classical CAN has sent them.
    pub(crate) fn fd_notice(&self) -> Option<String> {
        let frames = self.knowledge.fd_frames;
        (frames > 0).then(|| {
            format!(
                "{frames} CAN FD frame{} came, and none was taken for an answer: CANopen is classical CAN, and a device of \
                 classical CAN on this bus takes them for errors",
                if frames == 1 { "" } else { "s" }
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{Options, Target};
    use canvass_analyzer::object;
    use canvass_bus::{Bus, Health};
    use canvass_traces::ChannelId;
    use std::sync::atomic::AtomicBool;

    /// A bus that never falls silent, and of whose frames the tester gets every other one.
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
            assert!(bench.fd_notice().unwrap().starts_with("1 CAN FD frame came"));
        });
    }

    #[test]
    fn a_case_ends_when_frames_are_lost_and_what_it_changed_is_put_back_all_the_same() {
        let (mut bus, options, cancel) = (Flooded::default(), Options::default(), AtomicBool::new(false));
        let target = Target::unknown(NodeId::new(63).unwrap());
        let mut annotate = |_: &Record| String::new();
        let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        let hour = Duration::from_secs(3_600);
        bench.end_when_frames_are_lost();
        assert!(matches!(bench.wait_for(hour, |_| None::<()>), Err(Stop::Inconclusive(_))));
        assert_eq!(bench.now(), Timestamp(512 * 1_000), "it looks at every 512th frame");
        // Five thousand frames.
        let more = Duration::from_millis(5);
        assert_eq!(bench.uncancelled(|bench| bench.wait_for(more, |_| None::<()>)), Ok(None));
        bench.finish();
        assert_eq!(bench.wait_for(more, |_| None::<()>), Ok(None), "no case runs any more");
    }
}
