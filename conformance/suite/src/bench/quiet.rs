//! Quiet moments between the requests of other clients, in which the tester asks the SDO server.

use super::traffic::Traffic;
use crate::verdict::Stop;
use canvass_traces::Duration;

/// A client that polls asks again within this time.
const POLL: Duration = Duration::from_millis(1_100);

/// Minimum and maximum wait for an answer to others.
const PATIENCE: (Duration, Duration) = (Duration::from_millis(10), Duration::from_millis(200));

impl Traffic<'_> {
    /// Waits until the SDO server has answered all requests of others, or no answer is expected any more. `slowest`:
    /// the longest response time so far.
    pub(super) fn wait_for_quiet(&mut self, slowest: Duration) -> Result<(), Stop> {
        let begun = self.now();
        let patience = slowest.times(3).clamp(PATIENCE.0, PATIENCE.1);
        while let Some(until) = self.clients.busy_until(self.now(), patience) {
            // A client that asks without a pause leaves no quiet moment.
            if self.now().since(begun) > PATIENCE.1 {
                break;
            }
            self.receive(until)?;
        }
        Ok(())
    }

    /// Waits for a moment that leaves time for a dialogue of several messages: not shortly before others are likely to
    /// ask again.
    pub(super) fn wait_for_time(&mut self, slowest: Duration) -> Result<(), Stop> {
        match self.clients.next_request() {
            Some((period, next)) if period < POLL && next > self.now() && next.since(self.now()).0 < period.0 / 2 => {
                self.wait_for_pause(slowest)
            }
            _ => self.wait_for_quiet(slowest),
        }
    }

    /// Waits until others have asked once more and have got their answer: then they pause.
    pub(super) fn wait_for_pause(&mut self, slowest: Duration) -> Result<(), Stop> {
        let (before, deadline) = (self.clients.requests(), self.now() + POLL);
        while self.clients.requests() == before && self.now() < deadline {
            self.receive(deadline)?;
        }
        self.wait_for_quiet(slowest)
    }
}
