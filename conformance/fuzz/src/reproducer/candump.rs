//! Conversion of a sequence to a candump log and back.

use crate::campaign::Found;
use crate::stimulus::{SETTLE, Sequence, Start, Stimulus, Then};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp};
use std::fmt::Write;

/// Comment of a log whose sequence begins with a device without node-ID.
pub(super) const UNCONFIGURED: &str = "# start: without node-ID";

/// Comment with the wait after the last frame, which no time stamp contains: a number and `ms`.
const LAST_WAIT: &str = "# end: after ";

/// Maximum wait after the last frame in ms. No reproducer needs a longer wait.
const LONGEST_WAIT: u64 = 60_000;

/// Comment of a log before the frames that bring the device to the start of the sequence.
const PRELUDE: &str =
    "# before the sequence: the SDO server is used and the node reset, as a reset need not clear its buffers";

/// Comment of a log before the frames of the sequence, if there are frames before it.
const SEQUENCE: &str = "# the sequence";

/// Comment with a frame of the device.
const ANSWER: &str = "# the device: ";

/// The frames of a sequence as a candump log, for `canplayer` and `canvass fuzz --replay`. The time stamps say when to
/// send the frames: 100 ms apart if the device needs time, otherwise at once.
pub fn candump(sequence: &Sequence) -> String {
    let mut text = head(sequence);
    for (at, stimulus) in times(sequence).zip(&sequence.stimuli) {
        line(&mut text, "", at, &stimulus.frame);
    }
    end(text, sequence)
}

/// The log of a violation: the frames before its sequence, the sequence, and as comments the frames that the device sent
/// meanwhile.
pub fn log(found: &Found) -> String {
    let (whole, before) = (found.whole(), found.prelude.len());
    let mut text = head(&whole);
    if before > 0 {
        let _ = writeln!(text, "{PRELUDE}");
    }
    let mut sent = answers(&found.evidence).into_iter();
    for (number, (at, stimulus)) in times(&whole).zip(&whole.stimuli).enumerate() {
        if before > 0 && number == before {
            let _ = writeln!(text, "{SEQUENCE}");
        }
        line(&mut text, "", at, &stimulus.frame);
        let answers = if number < before { None } else { sent.next() };
        for (delay, frame) in answers.unwrap_or_default() {
            line(&mut text, ANSWER, at + delay, &frame);
        }
    }
    end(text, &whole)
}

/// The frames of the device after each own frame, with their delays.
fn answers(evidence: &[Record]) -> Vec<Vec<(Duration, Frame)>> {
    let mut sent: Vec<(Timestamp, Vec<(Duration, Frame)>)> = Vec::new();
    for record in evidence {
        match (record.direction, sent.last_mut()) {
            (Direction::Tx, _) => sent.push((record.timestamp, Vec::new())),
            (_, Some((at, answers))) => answers.push((record.timestamp.since(*at), record.frame)),
            (_, None) => {}
        }
    }
    sent.into_iter().map(|(_, answers)| answers).collect()
}

fn head(sequence: &Sequence) -> String {
    if sequence.start == Start::Unconfigured { format!("{UNCONFIGURED}\n") } else { String::new() }
}

/// The time at which each frame of the sequence is sent.
pub(super) fn times(sequence: &Sequence) -> impl Iterator<Item = Timestamp> {
    sequence.stimuli.iter().scan(Timestamp::ZERO, |now, stimulus| {
        let at = *now;
        *now += wait_after(stimulus);
        Some(at)
    })
}

fn line(text: &mut String, comment: &str, at: Timestamp, frame: &Frame) {
    let (seconds, micros) = (at.nanos() / 1_000_000_000, at.nanos() % 1_000_000_000 / 1_000);
    // Writing to a string can't fail.
    let _ = writeln!(text, "{comment}({seconds:010}.{micros:06}) can0 {}", compact(frame));
}

/// The log with the wait after its last frame.
fn end(mut text: String, sequence: &Sequence) -> String {
    if let Some(Stimulus { then: Then::Pause(time), .. }) = sequence.stimuli.last() {
        let _ = writeln!(text, "{LAST_WAIT}{} ms", time.nanos().div_ceil(1_000_000));
    }
    text
}

/// The wait after the last frame, if the log contains it.
pub(super) fn last_wait(log: &str) -> Option<Duration> {
    let number = log.lines().find_map(|line| line.strip_prefix(LAST_WAIT)?.trim().strip_suffix("ms"))?;
    number.trim().parse().ok().filter(|millis| *millis <= LONGEST_WAIT).map(Duration::from_millis)
}

/// Frames at a smaller distance follow each other at once.
const AT_ONCE: Duration = Duration::from_micros(1);

pub(super) fn wait_after(stimulus: &Stimulus) -> Duration {
    match stimulus.then {
        Then::Settle => SETTLE,
        Then::AtOnce => AT_ONCE,
        // One more microsecond distinguishes this pause from that of a settled frame.
        Then::Pause(time) if time == SETTLE => Duration(time.nanos() + 1_000),
        Then::Pause(time) => time,
    }
}

/// The sequence of the frames of a log. Reading a log of [`candump`] gives the original sequence.
pub fn sequence(frames: &[(Timestamp, Frame)]) -> Sequence {
    let next = frames.iter().skip(1).map(|(time, _)| Some(*time)).chain([None]);
    let stimuli = frames.iter().zip(next).map(|(&(time, frame), next)| {
        let then = match next.map(|next| next.since(time)) {
            None => Then::Settle,
            Some(SETTLE) => Then::Settle,
            Some(wait) if wait <= AT_ONCE => Then::AtOnce,
            Some(wait) => Then::Pause(wait),
        };
        Stimulus { frame, then }
    });
    Sequence { start: Start::Configured, stimuli: stimuli.collect() }
}

/// The frame in compact notation: `601#4000100000000000`, `701#R1`, `00000000#8105`.
fn compact(frame: &Frame) -> String {
    let id = match frame.id().is_extended() {
        true => format!("{:08X}", frame.id().raw()),
        false => format!("{:03X}", frame.id().raw()),
    };
    if frame.is_remote() {
        return format!("{id}#R{}", frame.len());
    }
    frame.data().iter().fold(format!("{id}#"), |mut text, byte| {
        let _ = write!(text, "{byte:02X}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::CanId;
    use proptest::prelude::*;

    fn frame() -> impl Strategy<Value = Frame> {
        let data = proptest::collection::vec(any::<u8>(), 0..=8);
        (0_u32..0x800, data).prop_map(|(id, data)| Frame::new(CanId::standard_masked(id), &data).unwrap())
    }

    fn then() -> impl Strategy<Value = Then> {
        prop_oneof![
            Just(Then::Settle),
            Just(Then::AtOnce),
            (1_u64..500).prop_map(|time| Then::Pause(Duration::from_millis(time)))
        ]
    }

    #[test]
    fn frames_as_candump_writes_them() {
        let settle = |frame| Stimulus { frame, then: Then::Settle };
        let id = CanId::standard_masked(0x701);
        let stimuli = vec![
            settle(Frame::new(CanId::standard_masked(0), &[0x81, 5]).unwrap()),
            settle(Frame::remote(id, 1).unwrap()),
            settle(Frame::new(CanId::extended(0x701).unwrap(), &[]).unwrap()),
        ];
        let text = candump(&Sequence { start: Start::Configured, stimuli });
        assert_eq!(
            text,
            "(0000000000.000000) can0 000#8105\n(0000000000.100000) can0 701#R1\n(0000000000.200000) can0 00000701#\n"
        );
    }

    proptest! {
        /// A log contains the whole sequence: reading a written log gives the same sequence.
        #[test]
        fn logs_are_replayed_as_they_were(steps in proptest::collection::vec((frame(), then()), 1..20)) {
            let mut stimuli: Vec<Stimulus> =
                steps.into_iter().map(|(frame, then)| Stimulus { frame, then }).collect();
            // The device always gets time to answer the last frame.
            if let Some(last) = stimuli.last_mut() {
                last.then = Then::Settle;
            }
            let mut now = Timestamp::ZERO;
            let frames: Vec<(Timestamp, Frame)> = stimuli.iter().map(|stimulus| {
                let at = now;
                now += wait_after(stimulus);
                (at, stimulus.frame)
            }).collect();
            for ((_, frame), stimulus) in frames.iter().zip(&stimuli) {
                prop_assert_eq!(*frame, stimulus.frame);
            }
            let read = sequence(&frames);
            for (read, written) in read.stimuli.iter().zip(&stimuli) {
                let expected = match written.then {
                    Then::Pause(time) if time == SETTLE => Then::Pause(Duration(time.nanos() + 1_000)),
                    then => then,
                };
                prop_assert_eq!(read.then, expected);
            }
        }
    }
}
