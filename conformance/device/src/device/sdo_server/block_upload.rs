//! Uploads in blocks (CiA 301, 7.2.4.3.12 to 7.2.4.3.16).

use super::{Answer, Next, Transfer, upload};
use crate::device::objects::Objects;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, BlockSegment, Request, Response, crc16};
use canvass_traces::Timestamp;

#[derive(Clone, Debug)]
pub(super) struct BlockUpload {
    pub object: Multiplexer,
    value: Vec<u8>,
    crc: bool,
    block_size: u8,
    /// Number of segments that the client has confirmed.
    confirmed: usize,
    stage: Stage,
    firmware: Firmware,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// The client has not sent its start message yet.
    Announced,
    /// This many segments of the block were sent and wait for their confirmation.
    Sent(u8),
    /// All segments were sent and confirmed, and the server has announced the end.
    Ending,
}

/// Handles the initiate request of a block upload.
pub(super) fn initiate(
    now: Timestamp,
    object: Multiplexer,
    crc: bool,
    block_size: u8,
    threshold: u8,
    objects: &Objects,
) -> Next {
    let reading = match objects.upload(now, object) {
        Ok(reading) => reading,
        Err(code) => return Next::abort(object, code),
    };
    let bytes = reading.bytes();
    // Up to the threshold a normal upload is shorter. Without a threshold the client wants blocks, even for an empty
    // value.
    let switches =
        threshold > 0 && bytes.len() <= usize::from(threshold) && !objects.takes(Liberty::ProtocolNotSwitched);
    let unchecked =
        objects.has(Fault::SdoBlockSizeUnchecked) || switches && objects.takes(Liberty::ProtocolBeforeBlockSize);
    if !is_block_size(block_size) && !unchecked {
        return Next::abort(object, AbortCode::BLOCK_SIZE);
    }
    let block_size = block_size.clamp(1, BlockSegment::MAX);
    if switches {
        if objects.has(Fault::SdoBlockSwitchTruncates) {
            return upload::begin(object, bytes.get(1..).unwrap_or_default(), objects);
        }
        return upload::initiate(now, object, objects);
    }
    let more = u32::from(objects.has(Fault::SdoBlockAnnouncedSizeWrong));
    let size = (!objects.takes(Liberty::SizesUnannounced)).then_some(bytes.len() as u32 + more);
    let knows_crc = !objects.takes(Liberty::BlocksWithoutCrc);
    let response = Response::InitiateBlockUpload { multiplexer: object, crc: knows_crc, size };
    let value = bytes.to_vec();
    Next::answer(
        Transfer::BlockUpload(BlockUpload {
            object,
            value,
            crc: crc && knows_crc,
            block_size,
            confirmed: 0,
            stage: Stage::Announced,
            firmware: objects.firmware,
        }),
        response,
    )
}

const fn is_block_size(block_size: u8) -> bool {
    matches!(block_size, 1..=BlockSegment::MAX)
}

impl BlockUpload {
    /// The value of the object.
    pub fn value(&self) -> &[u8] {
        &self.value
    }

    /// Handles a further message of the client.
    pub fn on_request(self, request: Request) -> Next {
        match (self.stage, request) {
            (Stage::Announced, Request::StartBlockUpload) => self.send_block(),
            (Stage::Sent(count), Request::ConfirmBlockUpload { sequence, block_size }) => {
                self.on_confirm(count, sequence, block_size)
            }
            (Stage::Ending, Request::EndBlockUpload) => Next::silence(Transfer::Idle),
            _ => Next::abort(self.object, AbortCode::COMMAND_SPECIFIER),
        }
    }

    fn on_confirm(mut self, count: u8, sequence: u8, block_size: u8) -> Next {
        let firmware = &self.firmware;
        if sequence > count && !firmware.has(Fault::SdoBlockConfirmationUnchecked) {
            return Next::abort(self.object, AbortCode::SEQUENCE_NUMBER);
        }
        if !is_block_size(block_size) && !firmware.has(Fault::SdoBlockSizeUnchecked) {
            return Next::abort(self.object, AbortCode::BLOCK_SIZE);
        }
        let sequence = match sequence.min(count) {
            _ if firmware.has(Fault::SdoBlockConfirmationIgnored) => count,
            part if part < count && firmware.has(Fault::SdoBlockRepeatsAll) => 0,
            sequence => sequence,
        };
        self.confirmed += usize::from(sequence);
        if !firmware.has(Fault::SdoBlockNewSizeIgnored) {
            self.block_size = block_size.clamp(1, BlockSegment::MAX);
        }
        if self.confirmed < self.segments() {
            return self.send_block();
        }
        let wrong = usize::from(firmware.has(Fault::SdoBlockLastLengthWrong));
        let unused = match ((self.confirmed * 7 + wrong - self.value.len()) & 7) as u8 {
            0 if firmware.has(Fault::SdoBlockSevenEndsEmpty) => 7,
            unused => unused,
        };
        let start = if firmware.has(Fault::SdoBlockCrcStartWrong) { 0xFFFF } else { 0 };
        let crc = match crc16(start, &self.value) {
            crc if self.crc && firmware.has(Fault::SdoBlockCrcSwapped) => crc.swap_bytes(),
            crc if self.crc || firmware.has(Fault::SdoBlockCrcUnasked) => crc,
            _ => 0,
        };
        self.stage = Stage::Ending;
        Next::answer(Transfer::BlockUpload(self), Response::EndBlockUpload { unused, crc })
    }

    /// The number of segments of the whole value; even an empty value takes one segment.
    fn segments(&self) -> usize {
        self.value.len().div_ceil(7).max(1)
    }

    fn send_block(mut self) -> Next {
        let total = self.segments();
        let until = total.min(self.confirmed + usize::from(self.block_size));
        let segments: Vec<BlockSegment> = (self.confirmed..until)
            .zip(1..=BlockSegment::MAX)
            .map(|(n, sequence)| {
                let mut data = [0; 7];
                let bytes = self.value.iter().skip(n * 7).take(7);
                data.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
                let last = n + 1 == total && !self.firmware.has(Fault::SdoBlockEndUnmarked);
                let continued = self.firmware.has(Fault::SdoBlockNumbersContinue);
                let sequence = if continued { (n % 127) as u8 + 1 } else { sequence };
                BlockSegment { sequence, last, data }
            })
            .collect();
        self.stage = Stage::Sent(segments.len() as u8);
        Next { transfer: Transfer::BlockUpload(self), answer: Answer::Segments(segments) }
    }
}
