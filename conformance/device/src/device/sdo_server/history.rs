//! Data of earlier transfers that a faulty server uses in later ones.

use super::{Answer, Next};
use crate::{Fault, Firmware};
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response};

/// The earlier transfers since the start of the device.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    /// Whether the last transfer was a segmented upload that ended.
    upload_ended: bool,
    /// The value of the last block upload, if no block download has begun since.
    block_upload: Option<Vec<u8>>,
    /// The value of the last block upload in a buffer that no start of the device clears.
    kept: Option<Vec<u8>>,
    /// The size that the last segmented download announced.
    announced: Option<u32>,
}

impl History {
    /// The request as the firmware understands it: a faulty firmware expects the size that an earlier download
    /// announced.
    pub fn taken(&self, request: Request, firmware: &Firmware) -> Request {
        match (request, self.announced) {
            (Request::InitiateDownload { multiplexer, payload: Payload::SegmentedUnsized }, Some(size))
                if firmware.has(Fault::SdoStaleSizeExpected) =>
            {
                Request::InitiateDownload { multiplexer, payload: Payload::Segmented(size) }
            }
            _ => request,
        }
    }

    /// Handles a request that begins a transfer; returns the refusal of a faulty firmware.
    pub fn begin(&mut self, request: &Request, firmware: &Firmware) -> Option<Next> {
        let object = request.multiplexer()?;
        let after_upload = std::mem::take(&mut self.upload_ended);
        let Request::InitiateDownload { payload, .. } = request else { return None };
        if let Payload::Segmented(size) = payload {
            self.announced = Some(*size);
        }
        let refuses = after_upload && firmware.has(Fault::SdoDownloadRefusedAfterUpload);
        refuses.then(|| Next::abort(object, AbortCode::GENERAL))
    }

    /// Records the answer to a segment request of an upload.
    pub fn uploaded(&mut self, next: &Next) {
        self.upload_ended = matches!(next.answer, Answer::Response(Response::UploadSegment(segment)) if segment.last);
    }

    /// What remains at the start of the device.
    pub fn at_start(self) -> Self {
        Self { kept: self.kept, ..Self::default() }
    }

    /// Records the end of a block upload.
    pub fn block_uploaded(&mut self, value: &[u8], firmware: &Firmware) {
        if firmware.has(Fault::SdoBlockDownloadKeepsUpload) {
            self.kept = Some(value.to_vec());
        }
        if firmware.has(Fault::SdoBlockDownloadWritesUpload) {
            self.block_upload = Some(value.to_vec());
        }
    }

    /// The value that the next block download writes in place of its own, in a faulty firmware.
    pub fn take_block(&mut self) -> Option<Vec<u8>> {
        self.block_upload.take().or_else(|| self.kept.clone())
    }
}
