//! NMT, error control, SYNC and EMCY dialogues.

use super::Script;
use crate::Known;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::sdo::Request;
use canvass_traces::{CanId, Frame};

impl Script<'_> {
    pub(super) fn nmt_dialogue(&mut self) {
        match self.dice.below(12) {
            0 if self.dice.one_in(8) => self.resets(),
            0..=3 => self.nmt_command(),
            4 => self.nmt_to_others(),
            5 => self.odd_nmt(),
            6 | 7 => self.heartbeat(),
            8 | 9 => self.guarding(),
            10 => {
                self.nmt_command();
                self.sdo(Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0)));
            }
            _ => {
                for _ in 0..3 {
                    self.nmt_command();
                }
                self.guard();
            }
        }
    }

    fn nmt(&mut self, command: u8, node: u8) {
        self.ask(Self::data(0, &[command, node]));
    }

    fn nmt_command(&mut self) {
        let own = self.node() as u8;
        let command = self.dice.one_of([1, 1, 2, 2, 128, 128, 129, 130]);
        let node = if self.dice.one_in(4) { 0 } else { own };
        self.nmt(command, node);
        if self.dice.one_in(3) {
            self.guard();
        }
    }

    fn nmt_to_others(&mut self) {
        let own = self.node() as u8;
        let node = self.dice.one_of([own.wrapping_add(1), own ^ 2, 128, 255, own | 128]);
        let command = self.dice.one_of([1, 2, 128, 129, 130]);
        self.nmt(command, node);
        self.guard();
        self.sdo(Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0)));
    }

    fn odd_nmt(&mut self) {
        let own = self.node() as u8;
        let frame = match self.dice.below(5) {
            0 => Some(Self::data(0, &[self.dice.byte(), own])),
            1 => Some(Self::data(0, &[self.dice.one_of([1, 2, 128, 129, 130])])),
            2 => Some(Self::data(0, &[])),
            3 => CanId::extended(0).and_then(|id| Frame::new(id, &[129, own])),
            _ => Frame::remote(Self::standard(0), 2),
        };
        if let Some(frame) = frame {
            self.ask(frame);
        }
        self.guard();
        self.sdo(Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0)));
    }

    fn guard(&mut self) {
        if let Some(frame) = Frame::remote(Self::standard(error_control::CAN_ID_BASE + self.node()), 1) {
            self.ask(frame);
        }
    }

    /// Adds several resets in a row.
    fn resets(&mut self) {
        let own = self.node() as u8;
        let command = self.dice.one_of([129, 130]);
        for _ in 0..8 {
            self.nmt(command, own);
        }
    }

    fn heartbeat(&mut self) {
        if self.dice.one_in(4) {
            // The heartbeat time changes while heartbeats are sent.
            let time = self.dice.one_of([5_u16, 50, 100]);
            self.sdo(Request::download(Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), &time.to_le_bytes()));
            self.pause(u64::from(time) * 2 + 20);
        }
        let time = self.dice.one_of([0_u16, 0, 5, 10, 50, 100]);
        self.sdo(Request::download(Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), &time.to_le_bytes()));
        if self.dice.flip() {
            self.pause(u64::from(time) * 4 + 20);
        }
        if self.dice.flip() {
            self.nmt_command();
            self.pause(u64::from(time) * 3 + 20);
        }
    }

    fn guarding(&mut self) {
        for _ in 0..1 + self.dice.below(4) {
            self.guard();
        }
    }

    pub(super) fn sync_dialogue(&mut self) {
        match self.dice.below(12) {
            10 => self.held_identifier(),
            11 => self.counter_in_use(),
            0..=2 => self.sync(),
            3 => self.short_pdos(),
            4 => self.consumer(),
            5 => self.nmt_command(),
            6 => self.write_number(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0, 1),
            7 => self.write_number(object::COB_ID_SYNC, 0, 4),
            8 => self.error_history(),
            _ => self.provoke(),
        }
    }

    pub(super) fn sync(&mut self) {
        for n in 0..1 + self.dice.below(5) {
            let bytes = [n as u8 + 1];
            let len = usize::from(self.dice.one_in(4));
            self.ask(Self::data(0x80, &bytes[..len]));
        }
    }

    /// Changes the identifier of a service that is in use.
    fn held_identifier(&mut self) {
        let (index, sub) = self.dice.one_of([
            (object::COB_ID_SYNC, 0),
            (object::COB_ID_TIME, 0),
            (object::COB_ID_EMCY, 0),
            (object::FURTHER_SDO_SERVER_PARAMETER, 1),
            (object::FURTHER_SDO_SERVER_PARAMETER, 2),
        ]);
        let at = Multiplexer::new(index, sub);
        let Some(own) = self.knowledge().entry(at).filter(|known| known.writable).and_then(|known| known.power_on)
        else {
            return self.sync();
        };
        let flag = self.dice.one_of([0, 1 << 30, 1 << 31]);
        let free = 0x181 + self.dice.below(0x3F0) as u32;
        let own = if index == object::FURTHER_SDO_SERVER_PARAMETER { free } else { own as u32 & 0x7FFF_FFFF | flag };
        self.sdo(Request::download(at, &own.to_le_bytes()));
        let other = own ^ 1 << self.dice.below(11);
        self.sdo(Request::download(at, &other.to_le_bytes()));
        self.sdo(Request::upload(at));
    }

    /// Writes 1019h while the device produces SYNC.
    fn counter_in_use(&mut self) {
        let period = self.dice.one_of([10_000_u32, 50_000]);
        self.sdo(Request::download(Multiplexer::new(object::COMMUNICATION_CYCLE_PERIOD, 0), &period.to_le_bytes()));
        let counter = self.dice.one_of([0_u8, 2, 10, 240]);
        self.sdo(Request::download(Multiplexer::new(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0), &[counter]));
    }

    fn short_pdos(&mut self) {
        let node = self.node();
        self.nmt(1, node as u8);
        let base = self.dice.one_of([0x200, 0x300, 0x400, 0x500]);
        let len = self.dice.below(9);
        let bytes = self.dice.number().to_le_bytes();
        for _ in 0..1 + self.dice.below(3) {
            self.ask(Self::data(base + node, &bytes[..len]));
        }
    }

    fn consumer(&mut self) {
        let node = (self.node() as u8 % 126) + 1;
        let sub = 1 + self.dice.below(3) as u8;
        let time = self.dice.one_of([0_u32, 50, 100]);
        let value = u32::from(node) << 16 | time;
        self.sdo(Request::download(Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, sub), &value.to_le_bytes()));
        let len = if self.dice.one_in(4) { self.dice.below(4) } else { 1 };
        self.ask(Self::data(0x700 + u16::from(node), &[5; 4][..len]));
        if self.dice.flip() {
            self.pause(250);
        }
    }

    fn write_number(&mut self, index: u16, sub: u8, size: usize) {
        let at = Multiplexer::new(index, sub);
        let value = match self.knowledge().entry(at).cloned() {
            Some(known) => self.value_of(&known),
            None => self.dice.number(),
        };
        self.sdo(Request::download(at, &value.to_le_bytes()[..size]));
    }

    fn error_history(&mut self) {
        self.sdo(Request::upload(Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 0)));
        let value = self.dice.one_of([0, 0, 1, 255]);
        self.sdo(Request::download(Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 0), &[value]));
        self.sdo(Request::upload(Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 1)));
        self.sdo(Request::upload(Multiplexer::new(object::ERROR_REGISTER, 0)));
    }

    /// Sets limits that the present value exceeds, so that the device reports an error.
    fn provoke(&mut self) {
        let profiles = self.knowledge().profiles();
        let provokes = |known: &Known| known.writable && profiles.iter().any(|profile| profile.provokes(known.at));
        let Some(known) = self.object_where(provokes).cloned() else { return self.short_pdos() };
        let value = known.limits.1.map_or(0, |high| high as u64).to_le_bytes();
        let low = known.limits.0.map_or(0, |low| low as u64).to_le_bytes();
        let size = known.size.unwrap_or(1).min(4);
        let first = self.dice.flip();
        self.sdo(Request::download(known.at, if first { &value[..size] } else { &low[..size] }));
        self.sdo(Request::download(known.at, if first { &low[..size] } else { &value[..size] }));
        self.sdo(Request::upload(Multiplexer::new(object::ERROR_REGISTER, 0)));
    }
}
