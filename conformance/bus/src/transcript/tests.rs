//! A tester that repeats a run on its recording does exactly the same as on the bus.

use super::*;
use crate::{Bus, BusError, Latencies, StampTrouble};
use canvass_traces::{CanId, ChannelId, Direction, Duration, Frame};

/// A bus whose clock is unpredictable, and which echoes each frame.
struct Wilful {
    now: u64,
    queue: std::collections::VecDeque<Record>,
    health: Health,
}

impl Bus for Wilful {
    fn now(&self) -> Timestamp {
        Timestamp(self.now)
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        for direction in [Direction::Tx, Direction::Rx] {
            self.queue.push_back(Record::new(Timestamp(self.now + 5), ChannelId(0), *frame).with_direction(direction));
        }
        Ok(())
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        self.now = self.now.max(deadline.0) + 7;
        self.health.receive.add(Duration(self.now));
        Ok(self.queue.pop_front())
    }

    fn bit_rate(&self) -> Option<u32> {
        Some(125_000)
    }

    fn is_live(&self) -> bool {
        true
    }

    fn health(&self) -> Health {
        self.health.clone()
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        if bit_rate > 500_000 { Err(BusError::FixedBitRate { bit_rate }) } else { Ok(()) }
    }
}

fn frame(id: u16) -> Frame {
    Frame::full(CanId::standard_masked(u32::from(id)), [1; 8])
}

/// The results that a tester sees when it sends frames and waits.
fn work(bus: &mut dyn Bus, ids: &[u16]) -> Result<Vec<String>, BusError> {
    let mut seen = vec![format!("{:?} {:?} {}", bus.now(), bus.bit_rate(), bus.is_live())];
    for &id in ids {
        bus.receive(bus.now() + Duration(10))?;
        bus.send(&frame(id))?;
        for _ in 0..3 {
            let deadline = bus.now() + Duration(100);
            let record = bus.receive(deadline)?;
            seen.push(format!("{:?} {record:?} {:?}", bus.now(), bus.health()));
        }
        seen.push(format!("{:?}", bus.set_bit_rate(u32::from(id) * 1_000).map_err(|error| error.to_string())));
    }
    Ok(seen)
}

fn transcribed(ids: &[u16]) -> (Vec<String>, Vec<Record>, Transcript) {
    let mut bus = Wilful { now: 1_000, queue: std::collections::VecDeque::new(), health: Health::default() };
    let mut records = Vec::new();
    let mut observe = |record: &Record| records.push(record.clone());
    let mut transcriber = Transcriber::new(&mut bus, &mut observe);
    let seen = work(&mut transcriber, ids).unwrap();
    let transcript = transcriber.finish();
    (seen, records, transcript)
}

#[test]
fn a_run_is_done_again_on_its_recording() {
    let (seen, records, transcript) = transcribed(&[100, 600, 200]);
    assert_eq!(records.len(), 6);
    // The transcript is written as text and read back.
    let read: Transcript = transcript.to_string().parse().unwrap();
    assert_eq!(read, transcript);
    let mut replay = Replay::new(records, read);
    assert_eq!(work(&mut replay, &[100, 600, 200]).unwrap(), seen);
    assert_eq!(replay.divergence(), None);
}

#[test]
fn another_frame_is_not_what_was_sent() {
    let (_, records, transcript) = transcribed(&[100, 600, 200]);
    let mut replay = Replay::new(records, transcript);
    let error = work(&mut replay, &[100, 601]).unwrap_err().to_string();
    assert!(error.contains("259#") && error.contains("258#") && error.contains("after frame 2"), "{error}");
    assert!(replay.divergence().is_some());
}

#[test]
fn what_is_not_sent_any_more_shows() {
    let (_, records, transcript) = transcribed(&[100, 600, 200]);
    let mut replay = Replay::new(records.clone(), transcript.clone());
    work(&mut replay, &[100, 600]).unwrap();
    assert!(replay.divergence().unwrap().why.contains("not sent is 1, the first is 0C8#"), "{:?}", replay.divergence());
    // A tester that only listens gets an own frame that it has not sent.
    let mut replay = Replay::new(records, transcript);
    let heard: Result<Vec<_>, _> = (0..9).map(|_| replay.receive(Timestamp(5_000))).collect();
    assert!(heard.unwrap_err().to_string().contains("to be sent"));
}

#[test]
fn what_no_recording_holds_is_told() {
    struct Broken;
    impl Bus for Broken {
        fn now(&self) -> Timestamp {
            Timestamp::ZERO
        }
        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            Err(std::io::Error::other("unplugged").into())
        }
        fn receive(&mut self, _: Timestamp) -> Result<Option<Record>, BusError> {
            Ok(None)
        }
        fn bit_rate(&self) -> Option<u32> {
            None
        }
    }
    let mut bus = Broken;
    let mut observe = |_: &Record| ();
    let mut transcriber = Transcriber::new(&mut bus, &mut observe);
    assert!(transcriber.send(&frame(1)).is_err());
    let transcript = transcriber.finish();
    assert!(transcript.trouble().is_some_and(|trouble| trouble.contains("unplugged")));
    assert_eq!(transcript.to_string().parse(), Ok(transcript));
}

/// The transcript keeps the fault of untrustworthy time stamps; without such an entry the adapter had no fault.
#[test]
fn trouble_with_time_stamps_is_kept() {
    let read = |line: &str| format!("canvass-transcript 1\n{line}\n").parse::<Transcript>();
    for trouble in [StampTrouble::Still, StampTrouble::Jump, StampTrouble::Range] {
        let line = format!("health 4 0 0 0 0 0 / 3:1 / 4:1 ; 5:1 ; {} / x", trouble.name());
        let transcript = read(&line).unwrap();
        assert_eq!(transcript.health[0].1.stamps, Some(trouble));
        assert!(transcript.to_string().contains(&line), "{transcript}");
        let health = Health { stamps: Some(trouble), ..Health::default() };
        assert_eq!(health.since(&health).stamps, Some(trouble), "it stays");
    }
    assert_eq!(read("health 4 0 0 0 0 / 3:1 / 4:1 ; 5:1 / x").unwrap().health[0].1.stamps, None);
    assert_eq!(read("health 4 0 0 0 0 / 3:1 / 4:1 / x").unwrap().health[0].1.stamps, None);
    assert!(read("health 4 0 0 0 0 / 3:1 / 4:1 ; 5:1 ; slow / x").is_err());
}

#[test]
fn mistakes_have_their_line() {
    let wrong = |text: &str| text.parse::<Transcript>().unwrap_err().line;
    assert_eq!(wrong(""), 1);
    assert_eq!(wrong("canvass-transcript 1\nlive no\nframes 1 x\n"), 3);
    assert_eq!(wrong("canvass-transcript 1\nhealth 1 2\n"), 2);
    assert!(Latencies::default().set(40, 1).is_none());
}
