//! An idle SDO server between two cases: a transfer that one case has left open must not disturb the next.

use super::Bench;
use super::sdo::DEVICE_TYPE;
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{self, AbortCode, BlockSegment, Request};
use canvass_bus::client::Outcome;
use canvass_traces::Duration;
use std::fmt;

/// Time in which a server is expected to end a transfer whose client is silent.
const SERVER_TIMEOUT: Duration = Duration::from_millis(5_000);

/// Maximum number of waits for such a server.
const WAITS: u32 = 3;

/// Number of attempts of a read that the server refuses.
const TRIES: u32 = 2;

/// A transfer that the server kept open although the client had aborted it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct KeptOpen {
    /// The object of the transfer.
    pub object: Multiplexer,
    /// The action after which the server served a request again.
    pub cure: Cure,
}

/// An action that makes an SDO server idle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Cure {
    /// An abort of the client, as the standard says.
    Abort,
    /// Reset node, and an abort of the client.
    Reset,
    /// A first segment of a block download, and an abort of the client.
    Segment,
    /// Silence of the client.
    Silence,
    /// Nothing that the bench has tried.
    Nothing,
}

impl fmt::Display for Cure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Abort => "an abort of the client ended it",
            Self::Reset => "only reset node ended it",
            Self::Segment => "only an abort after a further block segment ended it",
            Self::Silence => "it ended only after the client had been silent for seconds",
            Self::Nothing => "neither aborts nor reset node nor silence of the client ended it",
        })
    }
}

impl fmt::Display for KeptOpen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the SDO server kept the transfer of {} open after the client's abort; {}", self.object, self.cure)
    }
}

impl Bench<'_> {
    /// The first transfer that the server kept open against the client's abort.
    pub(crate) fn kept_open(&self) -> Option<&KeptOpen> {
        self.knowledge.kept_open.as_ref()
    }

    /// Ends the transfer that the tester may have left open, and requires that the server serves a request. If an abort
    /// of the client was not enough, the bench keeps the transfer and the action that helped, for the report of the
    /// run.
    pub(crate) fn make_server_idle(&mut self) {
        let Some(object) = self.traffic.transfer.suspect().filter(|_| !self.knowledge.has_gone()) else { return };
        // If the bus fails, the next case reports the failure. If the run ends, the device is reset anyway.
        let Ok(Some(cure)) = self.uncancelled(|bench| bench.unjudged(|bench| bench.end_transfer(object))) else {
            return;
        };
        if cure != Cure::Abort {
            let kept = KeptOpen { object, cure };
            self.note(kept.to_string());
            self.knowledge.kept_open.get_or_insert(kept);
        }
    }

    /// Ends the transfer; `None` if the run ends first: the tester then does not try the actions that take seconds.
    fn end_transfer(&mut self, object: Multiplexer) -> Result<Option<Cure>, Stop> {
        if self.aborts(object)? {
            return Ok(Some(Cure::Abort));
        }
        if self.is_cancelled() {
            return Ok(None);
        }
        // In stopped a server must not answer.
        self.command(Command::ENTER_PRE_OPERATIONAL)?;
        self.listen(self.timing().reaction)?;
        if self.aborts(object)? {
            return Ok(Some(Cure::Abort));
        }
        if self.knowledge.kept_open.as_ref().is_some_and(|kept| kept.cure == Cure::Nothing) {
            return Ok(Some(Cure::Nothing));
        }
        // This segment is not the last one, so nothing is written.
        let segment = BlockSegment { sequence: 1, last: false, data: [0; 7] };
        self.send(&segment.to_frame(sdo::REQUEST_BASE + u16::from(self.node().raw())))?;
        if self.aborts(object)? {
            return Ok(Some(Cure::Segment));
        }
        // A device that does not start is looked for before the next case.
        let _ = self.reset(Command::RESET_NODE);
        if self.aborts(object)? {
            return Ok(Some(Cure::Reset));
        }
        for _ in 0..WAITS {
            if self.is_cancelled() {
                return Ok(None);
            }
            self.listen(SERVER_TIMEOUT)?;
            if self.serves()? {
                return Ok(Some(Cure::Silence));
            }
        }
        Ok(Some(Cure::Nothing))
    }

    /// Aborts the transfer; returns whether the server then serves a request.
    fn aborts(&mut self, object: Multiplexer) -> Result<bool, Stop> {
        self.send_request(&Request::abort(object, AbortCode::GENERAL))?;
        self.serves()
    }

    fn serves(&mut self) -> Result<bool, Stop> {
        for _ in 0..TRIES {
            match self.upload(DEVICE_TYPE)?.outcome {
                Outcome::Uploaded(_) => return Ok(true),
                Outcome::Silent => return Ok(false),
                // A server that answers the abort of the client has not answered the request yet.
                _ => {}
            }
        }
        Ok(false)
    }
}
