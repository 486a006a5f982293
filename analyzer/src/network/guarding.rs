//! Distinguishes answers of node guarding from heartbeats: both are one byte on the same CAN-ID.

use canvass_traces::{Duration, Timestamp};

/// The error control of one node.
#[derive(Clone, Copy, Default, Debug)]
pub struct Guarding {
    /// Time of an unanswered remote frame.
    asked: Option<Timestamp>,
    /// The toggle bit of the last message.
    toggle: bool,
    /// Whether the last message was a heartbeat.
    beats: bool,
}

impl Guarding {
    /// A message of a heartbeat producer that comes later than this after a remote frame is no answer.
    const ANSWER: Duration = Duration::from_millis(100);

    /// Handles a remote frame that requests the node's state.
    pub const fn ask(&mut self, now: Timestamp) {
        self.asked = Some(now);
    }

    /// Whether the last message was a heartbeat. The next message without toggle bit is then also a heartbeat.
    pub const fn beats(&self) -> bool {
        self.beats && !self.toggle && self.asked.is_none()
    }

    /// Handles a message other than a boot-up; returns whether it is an answer: it was requested, it has the toggle
    /// bit, or it follows a message with the toggle bit, as in captures without remote frames. A single request does
    /// not make a node guarded: a tool may poll a heartbeat producer.
    pub fn is_answer(&mut self, now: Timestamp, toggle: bool) -> bool {
        let soon = |asked| !self.beats || now.since(asked) <= Self::ANSWER;
        let asked = self.asked.take().is_some_and(soon);
        let alternates = std::mem::replace(&mut self.toggle, toggle);
        self.beats = !(asked || toggle || alternates);
        debug_assert!(!(self.beats && self.toggle), "a heartbeat has no toggle bit");
        !self.beats
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: u64) -> Timestamp {
        Timestamp(millis * 1_000_000)
    }

    #[test]
    fn answers_alternate() {
        let mut guarding = Guarding::default();
        for (n, toggle) in [false, true, false, true].into_iter().enumerate() {
            guarding.ask(at(1000 * n as u64));
            assert!(guarding.is_answer(at(1000 * n as u64 + 300), toggle), "{n}");
        }
    }

    #[test]
    fn answers_to_requests_that_were_not_recorded() {
        let mut guarding = Guarding::default();
        let seen = [false, true, false, true].map(|toggle| guarding.is_answer(at(0), toggle));
        assert_eq!(seen, [false, true, true, true], "the first could be a heartbeat");
    }

    #[test]
    fn one_request_ends_no_heartbeat() {
        let mut guarding = Guarding::default();
        assert!(!guarding.is_answer(at(0), false));
        guarding.ask(at(300));
        assert!(guarding.is_answer(at(302), false));
        assert!(!guarding.is_answer(at(500), false));
        // A request without an answer does not end the heartbeat either.
        guarding.ask(at(600));
        assert!(!guarding.is_answer(at(1000), false));
    }

    #[test]
    fn heartbeats_follow_guarding_without_a_boot_up() {
        let mut guarding = Guarding::default();
        guarding.ask(at(0));
        assert!(guarding.is_answer(at(1), true));
        let seen = [500, 1000, 1500].map(|now| guarding.is_answer(at(now), false));
        assert_eq!(seen, [true, false, false]);
    }
}
