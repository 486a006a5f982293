//! SDO dialogues, valid and with mistakes.

use super::super::coverage::{Command, SdoState};
use super::super::knowledge::Known;
use super::super::stimulus::Then;
use super::Script;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, BlockSegment, Payload, REQUEST_BASE, Request, Segment, crc16};
use canvass_traces::{CanId, Frame};

impl Script<'_> {
    pub(super) fn sdo_dialogue(&mut self) {
        if let Some((state, command)) = self.plan.focus
            && self.dice.one_in(4)
        {
            self.reach(state);
            self.command(command);
            return;
        }
        match self.dice.below(32) {
            0..=5 => self.read(),
            6..=11 => self.write_object(),
            12 | 13 => self.write_wrong_length(),
            14..=16 => self.segmented_download(),
            17..=19 => self.segmented_upload(),
            20..=22 => self.block_download(),
            23..=25 => self.block_upload(),
            26 => self.read_write_read(),
            27 | 28 => self.stray(),
            29 => self.odd_frame(),
            30 => match self.dice.below(8) {
                0 | 1 => self.state_and_read(),
                2 | 3 => self.write_and_reset(),
                4 if self.plan.patient => self.abandoned(),
                5 => self.other_node(),
                _ => self.profile_dialogue(),
            },
            _ => self.random_bytes(),
        }
    }

    /// Writes an object and resets the device, which must lose the value.
    fn write_and_reset(&mut self) {
        let Some(known) = self.writable() else { return };
        let value = self.bytes_for(&known);
        if value.is_empty() || value.len() > 4 {
            return;
        }
        let command = self.dice.one_of([129, 130]);
        let own = self.node() as u8;
        self.sdo(Request::download(known.at, &value));
        self.ask(Self::data(0, &[command, own]));
        self.sdo(Request::upload(known.at));
    }

    /// The client abandons a transfer. When the client sends requests again, the server has to serve them.
    fn abandoned(&mut self) {
        let state = self.dice.one_of([SdoState::Download, SdoState::Upload, SdoState::BlockDownload]);
        self.reach(state);
        let seconds = self.dice.one_of([2, 12]);
        self.pause(seconds * 1_000);
        self.sdo(Request::abort(Multiplexer::new(0, 0), AbortCode::TIMEOUT));
        self.read();
    }

    /// Adds a request to another node-ID.
    fn other_node(&mut self) {
        let other = self.dice.one_of([self.node() + 1, self.node() - 1, self.node() ^ 0x20]);
        let id = REQUEST_BASE + (other & 0x7F);
        let at = self.object();
        self.ask(Request::upload(at).to_frame(id));
    }

    /// Adds a dialogue of the device's profile.
    fn profile_dialogue(&mut self) {
        let profiles = self.knowledge().profiles();
        if !profiles.iter().any(|profile| profile.dialogue(self)) {
            self.read();
        }
    }

    pub(super) fn read(&mut self) {
        let at = self.object();
        self.sdo(Request::upload(at));
    }

    fn writable(&mut self) -> Option<Known> {
        for _ in 0..4 {
            let found = self.object_where(|known| known.writable).cloned();
            if found.as_ref().is_some_and(|known| self.may_write(known.at)) {
                return found;
            }
        }
        None
    }

    fn write_object(&mut self) {
        let read_only = self.dice.one_in(8);
        let known = if read_only { self.object_where(|known| !known.writable).cloned() } else { self.writable() };
        let Some(known) = known else { return self.read() };
        let value = self.bytes_for(&known);
        let unsized_value = self.dice.one_in(12) && value.len() <= 4;
        let request = if unsized_value {
            let mut four = [0; 4];
            four[..value.len()].copy_from_slice(&value);
            Request::InitiateDownload { multiplexer: known.at, payload: Payload::ExpeditedUnsized(four) }
        } else {
            Request::download(known.at, &value)
        };
        let segmented = matches!(request, Request::InitiateDownload { payload: Payload::Segmented(_), .. });
        self.sdo(request);
        if segmented {
            self.segments(&value, false);
        }
        if self.dice.flip() {
            self.sdo(Request::upload(known.at));
        }
    }

    fn write_wrong_length(&mut self) {
        let Some(known) = self.writable() else { return };
        let size = known.size.unwrap_or(4);
        let len = match self.dice.below(3) {
            0 => size + 1,
            1 => size.saturating_sub(1),
            _ => 1 + self.dice.below(4),
        };
        let value: Vec<u8> = (0..len.clamp(1, 4)).map(|_| self.dice.byte() & 1).collect();
        self.sdo(Request::download(known.at, &value));
        self.sdo(Request::upload(known.at));
    }

    /// Reads, writes a possibly wrong value, and reads again: only a confirmed write may change the value.
    fn read_write_read(&mut self) {
        let Some(known) = self.writable() else { return };
        self.sdo(Request::upload(known.at));
        let value = self.bytes_for(&known);
        self.sdo(Request::download(known.at, &value));
        self.sdo(Request::upload(known.at));
    }

    fn segments(&mut self, value: &[u8], wrong: bool) {
        let chunks: Vec<&[u8]> = if value.is_empty() { vec![&[]] } else { value.chunks(7).collect() };
        let mistake = if wrong { self.dice.below(chunks.len() + 1) } else { usize::MAX };
        let kind = self.dice.below(6);
        let mut toggle = false;
        for (n, chunk) in chunks.iter().enumerate() {
            let mut last = n + 1 == chunks.len();
            let mut sent = toggle;
            if n == mistake {
                match kind {
                    0 | 1 => sent = !toggle,
                    2 => last = !last,
                    3 => return self.stray(),
                    4 => return self.sdo(Request::abort(Multiplexer::new(0, 0), AbortCode::GENERAL)),
                    _ => {
                        let again = Segment::new(toggle, chunk, false);
                        again.into_iter().for_each(|segment| self.sdo(Request::DownloadSegment(segment)));
                    }
                }
            }
            if let Some(segment) = Segment::new(sent, chunk, last) {
                self.sdo(Request::DownloadSegment(segment));
            }
            toggle = !toggle;
        }
    }

    fn segmented_download(&mut self) {
        // Few objects have values of variable length, so one of these objects is preferred now and then.
        let text = if self.dice.one_in(4) {
            self.object_where(|known| known.writable && known.size.is_none()).cloned()
        } else {
            None
        };
        let text = text.filter(|known| self.may_write(known.at));
        let Some(known) = text.or_else(|| self.writable()) else { return };
        let mut value = self.bytes_for(&known);
        let announced = match self.dice.below(6) {
            0 => Payload::SegmentedUnsized,
            1 => Payload::Segmented(value.len() as u32 + 1),
            2 => Payload::Segmented((value.len() as u32).saturating_sub(1)),
            _ => Payload::Segmented(value.len() as u32),
        };
        if self.dice.one_in(6) {
            value.push(self.dice.byte());
        }
        let read = self.dice.flip();
        if read && self.dice.flip() {
            self.sdo(Request::upload(known.at));
        }
        self.sdo(Request::InitiateDownload { multiplexer: known.at, payload: announced });
        let wrong = self.dice.flip();
        self.segments(&value, wrong);
        if read {
            self.sdo(Request::upload(known.at));
        }
    }

    fn text(&mut self) -> Option<Multiplexer> {
        self.object_where(|known| known.size.is_none_or(|size| size > 4) && known.readable).map(|known| known.at)
    }

    /// An object for a block upload: one with more than four bytes, or any object if there is none.
    fn for_blocks(&mut self) -> Option<Multiplexer> {
        match self.text() {
            None => self.object_where(|known| known.readable).map(|known| known.at),
            text => text,
        }
    }

    fn segmented_upload(&mut self) {
        let Some(at) = self.text() else { return self.read() };
        self.sdo(Request::upload(at));
        let count = 1 + self.dice.below(6);
        let mistake = if self.dice.flip() { self.dice.below(count) } else { usize::MAX };
        let mut toggle = false;
        for n in 0..count {
            if n == mistake {
                match self.dice.below(4) {
                    0 | 1 => toggle = !toggle,
                    2 => return self.stray(),
                    _ => return self.sdo(Request::abort(at, AbortCode::GENERAL)),
                }
            }
            self.sdo(Request::UploadSegment { toggle });
            toggle = !toggle;
        }
    }

    fn block_download(&mut self) {
        let Some(known) = self.writable() else { return };
        let value = self.bytes_for(&known);
        let crc = !self.dice.one_in(4);
        let size = match self.dice.below(6) {
            0 => None,
            1 => Some(value.len() as u32 + 1),
            _ => Some(value.len() as u32),
        };
        self.sdo(Request::InitiateBlockDownload { multiplexer: known.at, crc, size });
        if self.dice.one_in(16) {
            self.sdo(Request::abort(known.at, AbortCode::GENERAL));
            return self.read();
        }
        let unused = self.block_segments(&value);
        let mut sum = crc16(0, &value);
        match self.dice.below(8) {
            0 => sum ^= 1 << self.dice.below(16),
            1 => sum = sum.swap_bytes(),
            2 => return self.stray(),
            _ => {}
        }
        let unused = if self.dice.one_in(8) { self.dice.byte() & 7 } else { unused };
        self.sdo(Request::EndBlockDownload { unused, crc: sum });
        if self.dice.flip() {
            self.sdo(Request::upload(known.at));
        }
    }

    /// Adds the segments of a block. Returns the number of unused bytes in the last segment.
    fn block_segments(&mut self, value: &[u8]) -> u8 {
        let count = value.len().div_ceil(7).max(1);
        let mistake = if self.dice.one_in(3) { self.dice.below(count) } else { usize::MAX };
        let kind = self.dice.below(4);
        for n in 0..count {
            let mut data = [0; 7];
            let chunk = value.get(n * 7..value.len().min(n * 7 + 7)).unwrap_or(&[]);
            data[..chunk.len()].copy_from_slice(chunk);
            let mut segment = BlockSegment { sequence: n as u8 + 1, last: n + 1 == count, data };
            if n == mistake {
                match kind {
                    0 => segment.sequence = segment.sequence.wrapping_add(1),
                    1 => segment.sequence = self.dice.byte() & 0x7F,
                    2 => continue,
                    _ => self.block_segment(segment, Then::AtOnce),
                }
            }
            // Only the last segment of a block is answered.
            let then = if n + 1 == count { Then::Settle } else { Then::AtOnce };
            self.block_segment(segment, then);
        }
        if mistake != usize::MAX {
            // The server asks for the rest of the block again.
            for n in mistake..count {
                let mut data = [0; 7];
                let chunk = value.get(n * 7..value.len().min(n * 7 + 7)).unwrap_or(&[]);
                data[..chunk.len()].copy_from_slice(chunk);
                let sequence = (n - mistake) as u8 + 1;
                let last = n + 1 == count;
                self.block_segment(
                    BlockSegment { sequence, last, data },
                    if last { Then::Settle } else { Then::AtOnce },
                );
            }
        }
        (count * 7 - value.len()).min(7) as u8
    }

    fn block_segment(&mut self, segment: BlockSegment, then: Then) {
        let frame = segment.to_frame(REQUEST_BASE + self.node());
        self.push(frame, then);
    }

    fn block_upload(&mut self) {
        let at = match self.dice.below(4) {
            0 => self.object(),
            _ => self.for_blocks().unwrap_or(Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0)),
        };
        let block_size = self.dice.one_of([1, 2, 3, 7, 127, 127, 127, 0, 128, 255]);
        let threshold = self.dice.one_of([0, 0, 0, 4, 255]);
        let crc = self.dice.flip();
        self.sdo(Request::InitiateBlockUpload { multiplexer: at, crc, block_size, threshold });
        if self.dice.one_in(8) {
            return self.stray();
        }
        self.sdo(Request::StartBlockUpload);
        let segments = self.segments_of(at);
        let mut left = segments;
        for _ in 0..4 {
            let sent = left.min(u32::from(block_size.clamp(1, 127))) as u8;
            let confirmed = match self.dice.below(10) {
                0 => sent.wrapping_sub(1),
                1 => sent.wrapping_add(1),
                2 => self.dice.byte(),
                _ => sent,
            };
            let next = match self.dice.below(12) {
                0 => self.dice.one_of([0, 128, 255]),
                1 | 2 => self.dice.one_of([1, 2, 3, 7, 127]),
                _ => block_size,
            };
            self.sdo(Request::ConfirmBlockUpload { sequence: confirmed, block_size: next });
            left = left.saturating_sub(u32::from(confirmed.min(sent)));
            if left == 0 {
                break;
            }
        }
        self.sdo(Request::EndBlockUpload);
    }

    /// Number of segments for the value of an object, as far as its length is known.
    fn segments_of(&self, at: Multiplexer) -> u32 {
        let known = self.knowledge().entry(at);
        let len = known.map_or(4, |known| known.size.unwrap_or(known.usual_length));
        (len.div_ceil(7) as u32).max(1)
    }

    /// Adds a command that does not fit the state.
    fn stray(&mut self) {
        let command = *self.dice.pick(Command::ALL).unwrap_or(&Command::Unknown);
        self.command(command);
    }

    /// Adds NMT commands before and after a read.
    fn state_and_read(&mut self) {
        let node = self.node() as u8;
        let command = self.dice.one_of([1, 2, 128, 129, 130]);
        self.ask(Self::data(0, &[command, node]));
        let at = self.object();
        self.sdo(Request::upload(at));
        self.sdo(Request::abort(at, AbortCode::GENERAL));
    }

    /// Adds a frame that is no request for this server, or that the standard does not describe.
    fn odd_frame(&mut self) {
        let id = REQUEST_BASE + self.node();
        let at = self.object();
        let mut buffer = [0; 8];
        Request::upload(at).emit(&mut buffer);
        let frame = match self.dice.below(3) {
            0 => CanId::extended(u32::from(id)).and_then(|id| Frame::new(id, &buffer)),
            1 => Frame::remote(Self::standard(id), 8),
            _ => Frame::new(Self::standard(id), &buffer[..self.dice.below(8)]),
        };
        if let Some(frame) = frame {
            self.ask(frame);
        }
    }

    fn random_bytes(&mut self) {
        let mut bytes = self.dice.number().to_le_bytes();
        if self.dice.flip() {
            bytes[1..4].copy_from_slice(&self.object().to_bytes());
        }
        let frame = Self::data(REQUEST_BASE + self.node(), &bytes);
        self.ask(frame);
    }

    /// Brings the server into a state.
    fn reach(&mut self, state: SdoState) {
        match state {
            SdoState::Idle => {}
            SdoState::Download => {
                if let Some(known) = self.writable() {
                    let size = known.size.unwrap_or(20) as u32;
                    self.sdo(Request::InitiateDownload { multiplexer: known.at, payload: Payload::Segmented(size) });
                }
            }
            SdoState::Upload => {
                if let Some(at) = self.text() {
                    self.sdo(Request::upload(at));
                }
            }
            SdoState::BlockDownload | SdoState::BlockDownloadEnd => {
                let Some(known) = self.writable() else { return };
                let size = known.size.unwrap_or(7) as u32;
                self.sdo(Request::InitiateBlockDownload { multiplexer: known.at, crc: true, size: Some(size) });
                if state == SdoState::BlockDownloadEnd {
                    self.block_segment(BlockSegment { sequence: 1, last: true, data: [0; 7] }, Then::Settle);
                }
            }
            SdoState::BlockUploadReady | SdoState::BlockUpload | SdoState::BlockUploadEnd => {
                let Some(at) = self.for_blocks() else { return };
                let begin = Request::InitiateBlockUpload { multiplexer: at, crc: true, block_size: 127, threshold: 0 };
                self.sdo(begin);
                if state != SdoState::BlockUploadReady {
                    self.sdo(Request::StartBlockUpload);
                }
                if state == SdoState::BlockUploadEnd {
                    let sequence = self.segments_of(at).min(127) as u8;
                    self.sdo(Request::ConfirmBlockUpload { sequence, block_size: 127 });
                }
            }
        }
    }

    /// Adds a frame of the class.
    fn command(&mut self, command: Command) {
        let at = self.object();
        let id = REQUEST_BASE + self.node();
        let toggle = self.dice.flip();
        let request = match command {
            Command::Expedited => Request::download(at, &[self.dice.byte() & 1]),
            Command::BeginDownload => {
                Request::InitiateDownload { multiplexer: at, payload: Payload::Segmented(self.dice.below(30) as u32) }
            }
            Command::BeginUpload => Request::upload(at),
            Command::DownloadSegment => {
                let data = [0x55; 7];
                let len = self.dice.below(8);
                match Segment::new(toggle, &data[..len], self.dice.flip()) {
                    Some(segment) => Request::DownloadSegment(segment),
                    None => return,
                }
            }
            Command::UploadSegment => Request::UploadSegment { toggle },
            Command::Abort => Request::abort(at, AbortCode::GENERAL),
            Command::BeginBlockUpload => {
                let block_size = self.dice.one_of([1, 7, 127, 0, 128]);
                Request::InitiateBlockUpload { multiplexer: at, crc: toggle, block_size, threshold: 0 }
            }
            Command::StartBlockUpload => Request::StartBlockUpload,
            Command::ConfirmBlockUpload => {
                Request::ConfirmBlockUpload { sequence: self.dice.byte() & 0x7F, block_size: 127 }
            }
            Command::EndBlockUpload => Request::EndBlockUpload,
            Command::BeginBlockDownload => {
                Request::InitiateBlockDownload { multiplexer: at, crc: toggle, size: Some(self.dice.below(30) as u32) }
            }
            Command::EndBlockDownload => {
                Request::EndBlockDownload { unused: self.dice.byte() & 7, crc: self.dice.number() as u16 }
            }
            Command::BlockSegment => {
                let segment = BlockSegment { sequence: 1 + (self.dice.byte() & 3), last: toggle, data: [0x55; 7] };
                return self.block_segment(segment, Then::Settle);
            }
            Command::Unknown => Request::Unknown { command: 0xE0 | self.dice.byte() & 0x1F, tail: [0; 7] },
            Command::Short => {
                let bytes = self.dice.number().to_le_bytes();
                let len = self.dice.below(8);
                return self.ask(Self::data(id, &bytes[..len]));
            }
            Command::Extended => {
                let mut buffer = [0; 8];
                Request::upload(at).emit(&mut buffer);
                if let Some(frame) = CanId::extended(u32::from(id)).and_then(|id| Frame::new(id, &buffer)) {
                    self.ask(frame);
                }
                return;
            }
        };
        self.sdo(request);
    }
}
