//! Further SDO channels (1201h to 127Fh): servers of their own beside that of the default channel.

use super::objects::Objects;
use super::sdo_server::SdoServer;
use crate::models::Timing;
use canvass_analyzer::{CobId, NodeId};
use canvass_traces::{CanId, Frame, Timestamp};

/// One further channel.
#[derive(Clone, Debug)]
pub(super) struct SecondSdo {
    index: u16,
    server: SdoServer,
    request: CobId,
    response: CobId,
}

impl SecondSdo {
    /// The channels of the dictionary.
    pub fn all(objects: &Objects, timing: Timing, blocks: bool, seed: u64) -> Vec<Self> {
        let new = |index| Self {
            index,
            server: SdoServer::new(timing, blocks, seed ^ u64::from(index)),
            request: CobId(CobId::INVALID),
            response: CobId(CobId::INVALID),
        };
        (0x1201..0x1280).filter(|&index| objects.parameters.number(index, 1).is_some()).map(new).collect()
    }

    /// Takes the COB-IDs over.
    pub fn configure(&mut self, objects: &Objects) {
        let number = |sub| objects.parameters.number(self.index, sub).map_or(CobId::INVALID, |raw| raw as u32);
        (self.request, self.response) = (CobId(number(1)), CobId(number(2)));
        if self.can_id().is_none() {
            self.server.reset();
        }
    }

    /// The CAN-ID of requests, while both COB-IDs are valid.
    pub fn can_id(&self) -> Option<u16> {
        (self.request.is_valid() && self.response.is_valid()).then_some(self.request.can_id() as u16)
    }

    /// Whether frames with that CAN-ID are responses of this channel.
    pub fn responds_with(&self, can_id: u16) -> bool {
        self.can_id().is_some() && self.response.can_id() == u32::from(can_id)
    }

    /// A frame came on the client's CAN-ID.
    pub fn handle(&mut self, now: Timestamp, frame: &Frame, objects: &mut Objects) {
        self.server.handle(now, frame, objects);
    }

    /// Drops the transfer.
    pub fn reset(&mut self) {
        self.server.reset();
    }

    /// When the server wants to be called.
    pub fn timeout(&self) -> Timestamp {
        self.server.timeout()
    }

    /// A transfer whose client says nothing any more ends.
    pub fn expire(&mut self, now: Timestamp, objects: &Objects) {
        self.server.expire(now, objects);
    }

    /// The next answer that is ready.
    pub fn poll(&mut self, now: Timestamp, node: NodeId) -> Option<Frame> {
        // Only the CAN-ID differs from that of the default channel.
        let answer = self.server.poll(now, node)?;
        Frame::new(CanId::standard_masked(self.response.can_id()), answer.data())
    }
}
