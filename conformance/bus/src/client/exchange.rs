//! Single transfers and dialogues on a bus, for commands; cases use the bench instead.

use super::lss::{Fastscan, ScanStep};
use super::sdo::{Outcome, ServerLine, Transfer};
use crate::{Bus, BusError};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::layer_setting::{self, Dialect};
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_analyzer::wire::{Wire, lss};
use canvass_traces::{Direction, Duration, Frame, Record, Timestamp};

/// A bus, with an observer of its frames.
pub struct Exchange<'a> {
    pub bus: &'a mut dyn Bus,
    /// Gets every frame, including the tester's own.
    pub observe: &'a mut dyn FnMut(&Record),
    /// The time at which all transfers are aborted, even unfinished ones: a server can send segments without end.
    pub ends: Timestamp,
}

impl Exchange<'_> {
    /// Waits for the first frame of another node that `wanted` accepts, at most for `span`.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn wait_for<T>(
        &mut self,
        span: Duration,
        mut wanted: impl FnMut(&Record) -> Option<T>,
    ) -> Result<Option<T>, BusError> {
        let deadline = self.bus.now() + span;
        while let Some(record) = self.bus.receive(deadline)? {
            (self.observe)(&record);
            if record.direction != Direction::Tx
                && let Some(found) = wanted(&record)
            {
                return Ok(Some(found));
            }
            if record.timestamp > deadline {
                break;
            }
        }
        Ok(None)
    }

    /// Carries out an SDO transfer with a server of the predefined connection set. `patience` is the timeout of each
    /// response.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn transfer(
        &mut self,
        node: NodeId,
        (transfer, request): (Transfer, Request),
        patience: Duration,
    ) -> Result<Outcome, BusError> {
        self.wait_for(Duration::ZERO, |_| None::<()>)?;
        let outcome = transfer.carry_out(request, &mut ExchangeLine { exchange: self, node, patience })?;
        if outcome.own_abort().is_some() {
            // The client's own abort is received too, so that the observer gets the whole transfer.
            self.wait_for(Duration::from_millis(2), |_| None::<()>)?;
        }
        Ok(outcome)
    }

    /// Sends a request of LSS or LMT and waits for the answer of a slave. Many slaves may answer; the first one counts.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn ask<D: Dialect>(
        &mut self,
        request: &layer_setting::Request<D>,
        patience: Duration,
    ) -> Result<Option<layer_setting::Response<D>>, BusError> {
        self.bus.send(&request.to_frame(layer_setting::MASTER_CAN_ID))?;
        self.wait_for(patience, |record| {
            let frame = answer(record, layer_setting::SLAVE_CAN_ID)?;
            layer_setting::Response::read(frame.data()).ok()
        })
    }

    /// Finds one slave without a node-ID. Afterwards this slave is in LSS configuration; the others are not.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    pub fn fastscan(&mut self, patience: Duration) -> Result<ScanStep, BusError> {
        let (mut scan, mut request) = Fastscan::begin();
        loop {
            let answered = matches!(self.ask(&request, patience)?, Some(lss::Response::Identified));
            match scan.handle(answered) {
                ScanStep::Ask(next) => request = next,
                end => return Ok(end),
            }
        }
    }
}

/// The connection to the default SDO server of a node.
struct ExchangeLine<'e, 'a> {
    exchange: &'e mut Exchange<'a>,
    node: NodeId,
    patience: Duration,
}

impl ServerLine for ExchangeLine<'_, '_> {
    type Error = BusError;

    fn now(&self) -> Timestamp {
        self.exchange.bus.now()
    }

    fn send(&mut self, request: &Request) -> Result<(), BusError> {
        self.exchange.bus.send(&request.to_frame(sdo::REQUEST_BASE + u16::from(self.node.raw())))
    }

    fn receive(&mut self) -> Result<Option<Frame>, BusError> {
        let from = sdo::RESPONSE_BASE + u16::from(self.node.raw());
        let frame = self.exchange.wait_for(self.patience, |record| answer(record, from))?;
        Ok(frame.filter(|_| self.exchange.bus.now() < self.exchange.ends))
    }
}

fn answer(record: &Record, cob_id: u16) -> Option<Frame> {
    (record.frame.cob_id() == Some(cob_id)).then_some(record.frame)
}
