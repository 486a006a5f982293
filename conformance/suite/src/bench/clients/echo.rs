//! Echoes of adapters: they return the tester's own frames as if others had sent them.

use canvass_traces::{Duration, Frame, Timestamp};
use std::collections::VecDeque;

/// Maximum delay of an echo.
const ECHO: Duration = Duration::from_millis(100);

/// Number of own frames that are kept: more are never sent within [`ECHO`].
const KEPT: usize = 2_048;

/// Whether the adapter echoes frames. An adapter that returns one frame returns all.
#[derive(Debug, Default)]
pub(crate) struct Echo {
    sent: VecDeque<(Frame, Timestamp)>,
    is_known: Option<bool>,
}

impl Echo {
    /// Records a frame that the tester has sent.
    pub fn sent(&mut self, frame: &Frame, at: Timestamp) {
        if self.is_known != Some(false) {
            self.forget(at);
            self.sent.push_back((*frame, at));
        }
    }

    /// Whether a received frame is an echo of an own frame.
    pub(crate) fn gives_back(&mut self, frame: &Frame, at: Timestamp) -> bool {
        self.forget(at);
        let Some(place) = self.sent.iter().position(|(sent, _)| sent == frame) else { return false };
        self.sent.remove(place);
        self.is_known = Some(true);
        true
    }

    /// Forgets old frames. An own frame that did not return in time proves that the adapter does not echo.
    fn forget(&mut self, now: Timestamp) {
        while self.sent.front().is_some_and(|(_, at)| now.since(*at) > ECHO) || self.sent.len() > KEPT {
            self.sent.pop_front();
            self.is_known.get_or_insert(false);
        }
        if self.is_known == Some(false) {
            self.sent.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::frame;

    const AT: fn(u64) -> Timestamp = |ms| Timestamp(ms * 1_000_000);

    #[test]
    fn an_adapter_that_gives_back_frames_is_no_other_client() {
        let (mut echo, read) = (Echo::default(), frame("63F#4000100000000000"));
        for n in 0..10 {
            echo.sent(&read, AT(n * 1_000));
            assert!(echo.gives_back(&read, AT(n * 1_000 + 1)));
            assert!(!echo.gives_back(&read, AT(n * 1_000 + 2)), "once each");
        }
    }

    #[test]
    fn without_an_echo_an_equal_frame_is_of_others() {
        let (mut echo, read) = (Echo::default(), frame("63F#4000100000000000"));
        echo.sent(&read, AT(0));
        assert!(!echo.gives_back(&read, AT(101)), "too late for an echo");
        echo.sent(&read, AT(200));
        assert!(!echo.gives_back(&read, AT(201)), "there is none on this bus");
    }
}
