//! Downloads in blocks (CiA 301, 7.2.4.3.8 to 7.2.4.3.11).

use super::{Next, Transfer};
use crate::device::objects::Objects;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, BlockSegment, Response, crc16};
use canvass_traces::Timestamp;

/// The block size of a firmware with little memory.
const SMALL_BLOCK: u8 = 4;
/// The usual block size.
const BLOCK_SIZE: u8 = BlockSegment::MAX;

/// A block download while its segments are received.
#[derive(Clone, Debug)]
pub(super) struct BlockDownload {
    pub object: Multiplexer,
    crc: bool,
    size: Option<usize>,
    longest: usize,
    data: Vec<u8>,
    /// The sequence number of the last segment of this block that was received in order.
    sequence: u8,
    /// Number of segments received in this block, in order or not.
    received: u8,
    /// The abort code of a refused download, in a firmware that refuses only at the end.
    refusal: Option<AbortCode>,
    /// The value that a faulty firmware writes in place of the downloaded value.
    stale: Option<Vec<u8>>,
}

/// A block download after its last segment.
#[derive(Clone, Debug)]
pub(super) struct BlockDownloadEnd(BlockDownload);

/// Handles the initiate request of a block download. `size` is the number of bytes, if the client announced it. `stale`
/// is the value that a faulty firmware writes in place of the downloaded value.
pub(super) fn initiate(
    object: Multiplexer,
    crc: bool,
    size: Option<u32>,
    stale: Option<Vec<u8>>,
    objects: &Objects,
) -> Next {
    if objects.has(Fault::SdoBlockDownloadRefused) {
        return Next::abort(object, AbortCode::LENGTH_TOO_LOW);
    }
    let size = size.map(|size| size as usize);
    let begun = match objects.begin_download(object, size) {
        Err(AbortCode::READ_ONLY) if objects.has(Fault::SdoBlockReadOnlyAccepted) => Ok((size.unwrap_or(8), None)),
        Err(code) if objects.takes(Liberty::RefusedAtEnd) => Ok((usize::MAX, Some(code))),
        begun => begun.map(|longest| (longest, None)),
    };
    match begun {
        Ok((longest, refusal)) => {
            let firmware = &objects.firmware;
            let block_size = if firmware.has(Fault::SdoBlockSizeZeroOffered) { 0 } else { usual_block_size(firmware) };
            let crc = crc && !firmware.takes(Liberty::BlocksWithoutCrc);
            let response = Response::InitiateBlockDownload {
                multiplexer: object,
                crc: !firmware.takes(Liberty::BlocksWithoutCrc),
                block_size,
            };
            let data = Vec::new();
            let download = BlockDownload { object, crc, size, longest, data, sequence: 0, received: 0, refusal, stale };
            Next::answer(Transfer::BlockDownload(download), response)
        }
        Err(code) => Next::abort(object, code),
    }
}

impl BlockDownload {
    /// Whether a segment was received.
    pub const fn has_begun(&self) -> bool {
        self.sequence > 0
    }

    /// Handles a segment of the block.
    pub fn on_segment(mut self, segment: BlockSegment, firmware: &Firmware) -> Next {
        if segment.sequence == 0 {
            return match firmware.has(Fault::SdoBlockSequenceZeroIgnored) {
                true => Next::silence(Transfer::BlockDownload(self)),
                false => Next::abort(self.object, AbortCode::SEQUENCE_NUMBER),
            };
        }
        self.received = self.received.saturating_add(1);
        let repeated = segment.sequence == self.sequence && firmware.has(Fault::SdoBlockRepeatedAppended);
        let skipped = segment.sequence > self.sequence && firmware.has(Fault::SdoBlockGapAccepted);
        let taken = segment.sequence == self.sequence + 1 || repeated || skipped;
        if taken {
            self.sequence = segment.sequence;
            if self.refusal.is_none() {
                self.data.extend_from_slice(&segment.data);
            }
            if self.data.len() >= self.size.unwrap_or(self.longest).min(self.longest).saturating_add(7) {
                return Next::abort(self.object, AbortCode::LENGTH_TOO_HIGH);
            }
        }
        // A repeated segment does not end the transfer.
        let is_end = segment.last && taken;
        let block_size = usual_block_size(firmware);
        if !is_end && !segment.last && segment.sequence < block_size && self.received < block_size {
            return Next::silence(Transfer::BlockDownload(self));
        }
        let too_few = u8::from(firmware.has(Fault::SdoBlockCountOffByOne));
        let sequence = self.sequence.saturating_sub(too_few);
        let response = Response::ConfirmBlockDownload { sequence, block_size };
        self.sequence = 0;
        self.received = 0;
        match is_end {
            true => Next::answer(Transfer::BlockDownloadEnd(BlockDownloadEnd(self)), response),
            false => Next::answer(Transfer::BlockDownload(self), response),
        }
    }
}

impl BlockDownloadEnd {
    /// The object of the transfer.
    pub const fn object(&self) -> Multiplexer {
        self.0.object
    }

    /// Handles the client's end of the transfer: the number of unused bytes in the last segment, and the CRC.
    pub fn on_end(self, now: Timestamp, unused: u8, crc: u16, objects: &mut Objects) -> Next {
        let firmware = objects.firmware;
        let unused = if firmware.has(Fault::SdoBlockPaddingKept) { 0 } else { unused };
        let BlockDownload { object, crc: has_crc, size, mut data, refusal, stale, .. } = self.0;
        if let Some(code) = refusal {
            return Next::abort(object, code);
        }
        let of_all = has_crc && firmware.has(Fault::SdoBlockCrcOfFilling);
        let checksum_of_all = if of_all { Some(crc16(0, &data)) } else { None };
        data.truncate(data.len().saturating_sub(usize::from(unused)));
        let right = checksum_of_all.unwrap_or_else(|| crc16(0, &data));
        let too_short =
            size.is_some_and(|size| data.len() < size) && !firmware.has(Fault::SdoBlockSizeMismatchAccepted);
        if too_short && firmware.takes(Liberty::LengthBeforeCrc) {
            return Next::abort(object, AbortCode::LENGTH_TOO_LOW);
        }
        if has_crc && crc != right && !firmware.has(Fault::SdoBlockCrcIgnored) {
            if firmware.has(Fault::SdoBlockWrittenBeforeCheck) {
                // The value is already written when the server refuses the transfer.
                let _ = objects.download(now, object, &data);
            }
            return Next::abort(object, AbortCode::CRC);
        }
        match size {
            _ if firmware.has(Fault::SdoBlockSizeMismatchAccepted) => {
                // Missing bytes become zeros, surplus bytes are dropped.
                data.resize(objects.size(object).unwrap_or(data.len()), 0);
            }
            Some(size) if data.len() > size => return Next::abort(object, AbortCode::LENGTH_TOO_HIGH),
            Some(size) if data.len() < size => return Next::abort(object, AbortCode::LENGTH_TOO_LOW),
            _ => {}
        }
        let is_full = data.len() >= 14 && data.len().is_multiple_of(7);
        if is_full && !has_crc && firmware.has(Fault::SdoBlockSevenWithoutCrcTruncated) {
            data.pop();
        }
        if let Some(mut stale) = stale {
            stale.resize(data.len(), 0);
            data = stale;
        }
        match objects.download(now, object, &data) {
            Ok(()) if firmware.has(Fault::SdoBlockEndSilent) => Next::silence(Transfer::Idle),
            Ok(()) => Next::end(Response::EndBlockDownload),
            Err(AbortCode::READ_ONLY) if firmware.has(Fault::SdoBlockReadOnlyAccepted) => {
                Next::end(Response::EndBlockDownload)
            }
            Err(code) => Next::abort(object, code),
        }
    }
}

/// The block size that the server requests.
const fn usual_block_size(firmware: &Firmware) -> u8 {
    if firmware.takes(Liberty::SmallBlocks) { SMALL_BLOCK } else { BLOCK_SIZE }
}
