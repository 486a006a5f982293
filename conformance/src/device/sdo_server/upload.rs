//! Uploads: expedited and in segments (CiA 301, 7.2.4.3.5 to 7.2.4.3.7).

use super::{Next, Transfer};
use crate::Fault;
use crate::device::objects::Objects;
use crate::device::parameters::Reading;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Response, Segment};
use canvass_traces::Timestamp;

/// An upload in segments.
#[derive(Clone, Debug)]
pub(super) struct SegmentedUpload {
    pub object: Multiplexer,
    value: Vec<u8>,
    sent: usize,
    toggle: bool,
}

/// The request to read an object.
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
        Response::InitiateUpload { payload: Payload::Segmented(_), .. } => {
            let upload = SegmentedUpload { object, value: bytes.to_vec(), sent: 0, toggle: false };
            Next::answer(Transfer::Upload(upload), response)
        }
        response => Next::end(response),
    }
}

impl SegmentedUpload {
    /// The request for the next segment.
    pub fn on_request(mut self, toggle: bool, objects: &Objects) -> Next {
        if toggle != self.toggle && !objects.faults.has(Fault::SdoToggleUnchecked) {
            return Next::abort(self.object, AbortCode::TOGGLE);
        }
        let rest = self.value.get(self.sent..).unwrap_or_default();
        let last = rest.len() <= 7;
        let mut data = rest.get(..7).unwrap_or(rest);
        if last && objects.faults.has(Fault::SdoSegmentLengthWrong) {
            data = data.get(..data.len().saturating_sub(1)).unwrap_or(data);
        }
        let Some(segment) = Segment::new(toggle, data, last) else {
            return Next::abort(self.object, AbortCode::GENERAL);
        };
        let response = Response::UploadSegment(segment);
        if last {
            return Next::end(response);
        }
        self.sent += 7;
        self.toggle = !toggle;
        Next::answer(Transfer::Upload(self), response)
    }
}
