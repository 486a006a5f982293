//! Downloads: expedited and segmented (CiA 301, 7.2.4.3.3 and 7.2.4.3.4).

use super::{Next, Transfer};
use crate::device::objects::Objects;
use crate::{Fault, Liberty};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Response, Segment};
use canvass_traces::Timestamp;

/// A segmented download.
#[derive(Clone, Debug)]
pub(super) struct SegmentedDownload {
    pub object: Multiplexer,
    /// The number of bytes that the client announced, if it did.
    size: Option<usize>,
    /// The largest number of bytes that the object accepts.
    longest: usize,
    data: Vec<u8>,
    toggle: bool,
    /// Whether the object is read-only: a faulty firmware confirms the download and discards the value.
    discards: bool,
    /// The abort code of a refused download, in a firmware that refuses only at the end.
    refusal: Option<AbortCode>,
}

/// Handles the initiate request of a download.
pub(super) fn initiate(now: Timestamp, object: Multiplexer, payload: Payload, objects: &mut Objects) -> Next {
    let size = match payload {
        Payload::Expedited(value) => return write(now, object, value.data(), objects),
        Payload::ExpeditedUnsized(_) if objects.has(Fault::SdoUnsizedDownloadSilent) => {
            return Next::silence(Transfer::Idle);
        }
        Payload::ExpeditedUnsized(bytes) => return write_unsized(now, object, bytes, objects),
        Payload::Segmented(size) => Some(size as usize),
        Payload::SegmentedUnsized => None,
    };
    let firmware = &objects.firmware;
    if firmware.takes(Liberty::NoSegmentedTransfer) || size.is_none() && firmware.has(Fault::SdoSegmentedSizeRequired) {
        return Next::abort(object, AbortCode::COMMAND_SPECIFIER);
    }
    let begin = |longest, discards, refusal| {
        let download = SegmentedDownload { object, size, longest, data: Vec::new(), toggle: false, discards, refusal };
        Next::answer(Transfer::Download(download), Response::InitiateDownload { multiplexer: object })
    };
    match objects.begin_download(object, size) {
        Ok(longest) if longest <= 4 && firmware.has(Fault::SdoSegmentedShortRefused) => {
            Next::abort(object, AbortCode::UNSUPPORTED_ACCESS)
        }
        Ok(longest) => begin(longest, false, None),
        Err(AbortCode::READ_ONLY) if firmware.has(Fault::SdoReadOnlySegmentedAccepted) => {
            begin(size.unwrap_or(8), true, None)
        }
        Err(code) if firmware.takes(Liberty::RefusedAtEnd) => begin(0, false, Some(code)),
        Err(code) => Next::abort(object, code),
    }
}

fn write(now: Timestamp, object: Multiplexer, bytes: &[u8], objects: &mut Objects) -> Next {
    match objects.download(now, object, bytes) {
        Ok(()) => Next::end(Response::InitiateDownload { multiplexer: object }),
        Err(code) => Next::abort(object, code),
    }
}

/// Writes an expedited value whose length is not indicated: the object's own length applies.
fn write_unsized(now: Timestamp, object: Multiplexer, bytes: [u8; 4], objects: &mut Objects) -> Next {
    let len = objects.size(object).unwrap_or(bytes.len());
    match bytes.get(..len) {
        Some(bytes) => write(now, object, bytes, objects),
        None => write(now, object, &bytes, objects),
    }
}

impl SegmentedDownload {
    /// Handles the next segment.
    pub fn on_segment(mut self, now: Timestamp, segment: Segment, objects: &mut Objects) -> Next {
        if segment.toggle != self.toggle && !objects.has(Fault::SdoToggleUnchecked) {
            if objects.takes(Liberty::ToggleIgnored) {
                return Next::silence(Transfer::Download(self));
            }
            return Next::abort(self.object, AbortCode::TOGGLE);
        }
        if segment.data().is_empty() && !segment.last && objects.has(Fault::SdoEmptySegmentSilent) {
            return Next::silence(Transfer::Download(self));
        }
        if let Some(code) = self.refusal {
            return self.refused(segment, code);
        }
        self.data.extend_from_slice(segment.data());
        let unchecked = objects.has(Fault::SdoLengthUnchecked);
        if self.data.len() > self.size.unwrap_or(self.longest).min(self.longest) && !unchecked {
            return Next::abort(self.object, AbortCode::LENGTH_TOO_HIGH);
        }
        let toggle = segment.toggle && !objects.has(Fault::SdoConfirmationToggleStuck);
        let confirm = Response::DownloadSegment { toggle };
        if objects.has(Fault::SdoSegmentsWrittenAtOnce) {
            let mut so_far = self.data.clone();
            so_far.resize(self.longest.min(8), 0);
            // An error is ignored here: the server refuses an unsuitable value at the last segment.
            let _ = objects.download(now, self.object, &so_far);
        }
        if !segment.last {
            self.toggle = !segment.toggle;
            // A firmware that checks no length keeps its own buffer, and drops surplus bytes.
            self.data.truncate(self.longest.max(8));
            if objects.has(Fault::SdoDownloadSegmentUnconfirmed) {
                return Next::silence(Transfer::Download(self));
            }
            return Next::answer(Transfer::Download(self), confirm);
        }
        let short = self.size.is_some_and(|size| self.data.len() < size);
        if short && !objects.has(Fault::SdoShortLengthUnchecked) && !unchecked {
            return Next::abort(self.object, AbortCode::LENGTH_TOO_LOW);
        }
        let is_full = self.data.len() >= 14 && self.data.len().is_multiple_of(7);
        if is_full && self.size.is_none() && objects.has(Fault::SdoUnsizedSevenTruncated) {
            self.data.pop();
        }
        match objects.download(now, self.object, &self.data) {
            _ if self.discards => Next::end(confirm),
            Ok(()) => Next::end(confirm),
            Err(code) => Next::abort(self.object, code),
        }
    }

    /// Handles a segment of a download that the server refuses at its end.
    fn refused(mut self, segment: Segment, code: AbortCode) -> Next {
        if segment.last {
            return Next::abort(self.object, code);
        }
        self.toggle = !segment.toggle;
        Next::answer(Transfer::Download(self), Response::DownloadSegment { toggle: segment.toggle })
    }
}
