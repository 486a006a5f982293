//! Downloads: expedited and in segments (CiA 301, 7.2.4.3.3 and 7.2.4.3.4).

use super::{Next, Transfer};
use crate::device::objects::Objects;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Response, Segment};
use canvass_traces::Timestamp;

/// A download in segments.
#[derive(Clone, Debug)]
pub(super) struct SegmentedDownload {
    pub object: Multiplexer,
    /// What the client announced.
    size: Option<usize>,
    /// What the object takes.
    longest: usize,
    data: Vec<u8>,
    toggle: bool,
    /// The object can't be written, which this firmware finds out only now, or never.
    discards: bool,
    /// What is answered at the end, by a firmware that finds out only then.
    refusal: Option<AbortCode>,
}

/// The request to write an object.
pub(super) fn initiate(now: Timestamp, object: Multiplexer, payload: Payload, objects: &mut Objects) -> Next {
    let size = match payload {
        Payload::Expedited(value) => return write(now, object, value.data(), objects),
        Payload::ExpeditedUnsized(_) if !objects.firmware.answers_unsized_download() => {
            return Next::silence(Transfer::Idle);
        }
        Payload::ExpeditedUnsized(bytes) => return write_unsized(now, object, bytes, objects),
        Payload::Segmented(size) => Some(size as usize),
        Payload::SegmentedUnsized => None,
    };
    let firmware = &objects.firmware;
    if !firmware.knows_segments() || size.is_none() && firmware.requires_size() {
        return Next::abort(object, AbortCode::COMMAND_SPECIFIER);
    }
    let begin = |longest, discards, refusal| {
        let download = SegmentedDownload { object, size, longest, data: Vec::new(), toggle: false, discards, refusal };
        Next::answer(Transfer::Download(download), Response::InitiateDownload { multiplexer: object })
    };
    match objects.begin_download(object, size) {
        Ok(longest) if longest <= 4 && !firmware.takes_short_value_in_segments() => {
            Next::abort(object, AbortCode::UNSUPPORTED_ACCESS)
        }
        Ok(longest) => begin(longest, false, None),
        Err(AbortCode::READ_ONLY) if firmware.begins_download_to_read_only() => begin(size.unwrap_or(8), true, None),
        Err(code) if firmware.refuses_at_end() => begin(0, false, Some(code)),
        Err(code) => Next::abort(object, code),
    }
}

fn write(now: Timestamp, object: Multiplexer, bytes: &[u8], objects: &mut Objects) -> Next {
    match objects.download(now, object, bytes) {
        Ok(()) => Next::end(Response::InitiateDownload { multiplexer: object }),
        Err(code) => Next::abort(object, code),
    }
}

/// The number of bytes is not said: the object's own is meant.
fn write_unsized(now: Timestamp, object: Multiplexer, bytes: [u8; 4], objects: &mut Objects) -> Next {
    let len = objects.size(object).unwrap_or(bytes.len());
    match bytes.get(..len) {
        Some(bytes) => write(now, object, bytes, objects),
        None => write(now, object, &bytes, objects),
    }
}

impl SegmentedDownload {
    /// The next segment.
    pub fn on_segment(mut self, now: Timestamp, segment: Segment, objects: &mut Objects) -> Next {
        if segment.toggle != self.toggle && objects.firmware.checks_toggle() {
            if !objects.firmware.answers_wrong_toggle() {
                return Next::silence(Transfer::Download(self));
            }
            return Next::abort(self.object, AbortCode::TOGGLE);
        }
        if segment.data().is_empty() && !segment.last && !objects.firmware.answers_empty_segment() {
            return Next::silence(Transfer::Download(self));
        }
        if let Some(code) = self.refusal {
            return self.refused(segment, code);
        }
        self.data.extend_from_slice(segment.data());
        let unchecked = !objects.firmware.checks_length();
        if self.data.len() > self.size.unwrap_or(self.longest).min(self.longest) && !unchecked {
            return Next::abort(self.object, AbortCode::LENGTH_TOO_HIGH);
        }
        let toggle = segment.toggle && objects.firmware.toggles_confirmations();
        let confirm = Response::DownloadSegment { toggle };
        if objects.firmware.writes_segments_at_once() {
            let mut so_far = self.data.clone();
            so_far.resize(self.longest.min(8), 0);
            // A value that does not fit is refused with the last segment.
            let _ = objects.download(now, self.object, &so_far);
        }
        if !segment.last {
            self.toggle = !segment.toggle;
            // A firmware that checks no length has a buffer of its own, and drops what does not fit.
            self.data.truncate(self.longest.max(8));
            return Next::answer(Transfer::Download(self), confirm);
        }
        let short = self.size.is_some_and(|size| self.data.len() < size);
        if short && objects.firmware.checks_short_length() && !unchecked {
            return Next::abort(self.object, AbortCode::LENGTH_TOO_LOW);
        }
        match objects.download(now, self.object, &self.data) {
            _ if self.discards => Next::end(confirm),
            Ok(()) => Next::end(confirm),
            Err(code) => Next::abort(self.object, code),
        }
    }

    /// A segment of what is refused at its end.
    fn refused(mut self, segment: Segment, code: AbortCode) -> Next {
        if segment.last {
            return Next::abort(self.object, code);
        }
        self.toggle = !segment.toggle;
        Next::answer(Transfer::Download(self), Response::DownloadSegment { toggle: segment.toggle })
    }
}
