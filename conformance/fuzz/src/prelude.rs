//! Frames that are sent before a reset to bring the SDO server into the same state each time.
//!
//! A reset need not clear the buffers of a server. On a device that can't be switched off, a violation can depend on
//! what an earlier sequence has left in them. These frames overwrite the buffers, so that each repetition of a sequence
//! and each replay of its log begin in the same way.

use super::stimulus::{Stimulus, Then};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_analyzer::wire::sdo::{AbortCode, REQUEST_BASE, Request};
use canvass_analyzer::{Multiplexer, NodeId, object};
use canvass_traces::Duration;

/// Number of segments in a block that the client accepts.
const BLOCK_SIZE: u8 = 127;

/// Shortest time for a reset.
const LEAST_BOOT: Duration = Duration::from_millis(500);

/// An expedited, a segmented and a block upload, and a reset. `boot`: time for the reset, at least [`LEAST_BOOT`].
pub(super) fn prelude(node: NodeId, boot: Duration) -> Vec<Stimulus> {
    let name = Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0);
    let abort = Request::abort(name, AbortCode::GENERAL);
    let requests = [
        Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0)),
        Request::upload(name),
        Request::UploadSegment { toggle: false },
        abort,
        Request::InitiateBlockUpload { multiplexer: name, block_size: BLOCK_SIZE, threshold: 0, crc: true },
        Request::StartBlockUpload,
        abort,
    ];
    let server = REQUEST_BASE + u16::from(node.raw());
    let requests = requests.map(|request| Stimulus::settle(request.to_frame(server)));
    let reset = Nmt { command: Command::RESET_NODE, node: node.raw() }.to_frame(nmt::CAN_ID);
    let boot = Stimulus { frame: reset, then: Then::Pause(LEAST_BOOT.max(boot)) };
    requests.into_iter().chain([boot]).collect()
}
