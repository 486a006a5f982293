//! Uploads: expedited and segmented (CiA 301, 7.2.4.3.5 to 7.2.4.3.7).

use super::{Next, Transfer};
use crate::device::objects::Objects;
use crate::device::parameters::Reading;
use crate::{Fault, Liberty};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Response, Segment};
use canvass_traces::Timestamp;

/// A segmented upload.
#[derive(Clone, Debug)]
pub(super) struct SegmentedUpload {
    pub object: Multiplexer,
    value: Vec<u8>,
    sent: usize,
    toggle: bool,
}

/// Handles the initiate request of an upload.
pub(super) fn initiate(now: Timestamp, object: Multiplexer, objects: &Objects) -> Next {
    let reading = match objects.upload(now, object) {
        Ok(reading) => reading,
        Err(code) => return Next::abort(object, code),
    };
    let bytes = reading.bytes();
    let mut response = Response::upload(object, bytes);
    if matches!(reading, Reading::Bytes(_)) && objects.model.sheet().quirks.strings_in_segments {
        response = Response::InitiateUpload { multiplexer: object, payload: Payload::Segmented(bytes.len() as u32) };
    }
    match response {
        Response::InitiateUpload { payload: Payload::Segmented(0), .. } if objects.has(Fault::SdoEmptyValueSilent) => {
            Next::silence(Transfer::Idle)
        }
        Response::InitiateUpload { multiplexer, payload: Payload::Segmented(size) }
            if objects.has(Fault::SdoAnnouncedSizeWrong) =>
        {
            let upload = SegmentedUpload { object, value: bytes.to_vec(), sent: 0, toggle: false };
            let payload = Payload::Segmented(size.saturating_add(1));
            Next::answer(Transfer::Upload(upload), Response::InitiateUpload { multiplexer, payload })
        }
        Response::InitiateUpload { payload: Payload::Segmented(_), .. } => begin(object, bytes, objects),
        response => Next::end(response),
    }
}

/// Begins a segmented upload, whatever the length of the value.
pub(super) fn begin(object: Multiplexer, value: &[u8], objects: &Objects) -> Next {
    let upload = SegmentedUpload { object, value: value.to_vec(), sent: 0, toggle: false };
    let unannounced = objects.takes(Liberty::SizesUnannounced);
    let payload = if unannounced { Payload::SegmentedUnsized } else { Payload::Segmented(value.len() as u32) };
    Next::answer(Transfer::Upload(upload), Response::InitiateUpload { multiplexer: object, payload })
}

impl SegmentedUpload {
    /// Handles the client's request for the next segment.
    pub fn on_request(mut self, toggle: bool, objects: &Objects) -> Next {
        if toggle != self.toggle && !objects.has(Fault::SdoToggleUnchecked) {
            if objects.takes(Liberty::ToggleIgnored) {
                return Next::silence(Transfer::Upload(self));
            }
            return Next::abort(self.object, AbortCode::TOGGLE);
        }
        let rest = self.value.get(self.sent..).unwrap_or_default();
        let last = rest.len() <= 7;
        let mut data = rest.get(..7).unwrap_or(rest);
        if last && objects.has(Fault::SdoSegmentLengthWrong) {
            data = data.get(..data.len().saturating_sub(1)).unwrap_or(data);
        }
        let shown = toggle && !objects.has(Fault::SdoUploadToggleStuck);
        let marked = last && !objects.has(Fault::SdoUploadEndMissing);
        let Some(segment) = Segment::new(shown, data, marked) else {
            return Next::abort(self.object, AbortCode::GENERAL);
        };
        let response = Response::UploadSegment(segment);
        if last && objects.has(Fault::SdoSegmentAfterEndAnswered) {
            self.sent = self.value.len();
            self.toggle = !toggle;
            return Next::answer(Transfer::Upload(self), response);
        }
        if last {
            return Next::end(response);
        }
        self.sent += 7;
        self.toggle = !toggle;
        Next::answer(Transfer::Upload(self), response)
    }
}
