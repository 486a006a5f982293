//! Answers that a faulty server makes of its own receive buffer.

use crate::{Fault, Firmware};
use canvass_analyzer::wire::sdo::Response;
use canvass_traces::Frame;

/// A firmware that returns requests does so for one upload request of this many requests.
const READ_EVERY: u32 = 9;

/// The buffer for requests.
#[derive(Clone, Debug, Default)]
pub(super) struct ReceiveBuffer([u8; 8]);

impl ReceiveBuffer {
    pub fn take(&mut self, frame: &Frame) {
        self.0 = frame.bytes();
    }

    /// The bytes of an answer as the firmware sends them; `requests` is the number of requests so far.
    pub fn sent(&self, response: &Response, bytes: [u8; 8], requests: u32, firmware: &Firmware) -> [u8; 8] {
        let is_expedited = self.0[0] & 0xE2 == 0x22;
        let is_echoed = match response {
            Response::InitiateDownload { .. } => is_expedited && firmware.has(Fault::SdoWriteEchoed),
            Response::InitiateUpload { .. } => {
                requests.is_multiple_of(READ_EVERY) && firmware.has(Fault::SdoReadEchoed)
            }
            _ => false,
        };
        if is_echoed { self.0 } else { bytes }
    }

    /// The message that the firmware sends for a segment of a block download, which needs no answer.
    pub fn echo(&self, firmware: &Firmware) -> Option<[u8; 8]> {
        (self.0[0] & 0x80 == 0 && firmware.has(Fault::SdoBlockSegmentsEchoed)).then_some(self.0)
    }
}
