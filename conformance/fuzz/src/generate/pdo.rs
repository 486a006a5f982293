//! PDO dialogues: configuration, then traffic.

use super::Script;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::Request;
use canvass_traces::Frame;

/// An identifier that no service uses in the predefined connection set.
const FREE: u32 = 0x6A0;

impl Script<'_> {
    pub(super) fn pdo_dialogue(&mut self) {
        let Some(index) = self.parameters() else { return self.sync_dialogue() };
        match self.dice.below(15) {
            14 => self.without_pause(index),
            12 => self.outputs(),
            13 => {
                let start = self.dice.byte();
                self.parameter(index, 6, start.into());
            }
            0 => self.identifier(index),
            1 => self.transmission(index),
            2 | 3 => self.timer(index),
            4 => self.mapping_entry(index),
            5 | 6 => self.remap(index),
            7 => {
                self.start();
                self.sync();
            }
            8 => {
                self.start();
                self.pause(60);
            }
            9 => self.remote(index),
            10 => self.synchronous(index),
            _ => {
                let own = self.node() as u8;
                let command = self.dice.one_of([2, 128]);
                self.ask(Self::data(0, &[command, own]));
                self.sync();
                self.remote(index);
            }
        }
    }

    /// Changes the communication parameters of a PDO.
    fn parameters(&mut self) -> Option<u16> {
        let transmit = !self.dice.one_in(4);
        let range = if transmit { 0x1800..0x1A00 } else { 0x1400..0x1600 };
        let found = self.object_where(|known| known.at.sub.0 == 1 && range.contains(&known.at.index.0));
        let index = found.map(|known| known.at.index.0);
        index.or_else(|| {
            self.object_where(|known| known.at.sub.0 == 1 && object::is_tpdo_communication(known.at.index.0))
                .map(|known| known.at.index.0)
        })
    }

    fn start(&mut self) {
        let own = self.node() as u8;
        self.ask(Self::data(0, &[1, own]));
    }

    fn own_identifier(&self, index: u16) -> u32 {
        let known = self.knowledge().entry(Multiplexer::new(index, 1));
        known.and_then(|known| known.power_on).map_or(0x180 + u32::from(self.node()), |raw| raw as u32)
    }

    fn parameter(&mut self, index: u16, sub: u8, value: u32) {
        let at = Multiplexer::new(index, sub);
        let size = self.knowledge().entry(at).and_then(|known| known.size).unwrap_or(4).min(4);
        self.sdo(Request::download(at, &value.to_le_bytes()[..size]));
    }

    fn identifier(&mut self, index: u16) {
        let own = self.own_identifier(index);
        if self.dice.flip() {
            self.parameter(index, 1, own | 1 << 31);
        }
        let restricted = self.dice.one_of([0, 1, 0x7F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7FF]);
        // No service uses 6A0h in the predefined connection set.
        let other = if self.dice.flip() { FREE } else { 0x181 + self.dice.below(0x400) as u32 };
        let flags = own & 0x4000_0000;
        let value = self.dice.one_of([
            own,
            own ^ 1 << 31,
            restricted | flags,
            restricted | flags,
            other | flags,
            other | flags,
        ]);
        let timed = self.dice.one_in(3);
        if timed {
            self.parameter(index, 5, 10);
        }
        self.parameter(index, 1, value);
        if !timed && self.dice.flip() {
            return self.sdo(Request::upload(Multiplexer::new(index, 1)));
        }
        self.start();
        match self.dice.below(3) {
            _ if timed => self.pause(30),
            0 => self.sync(),
            1 => self.remote(index),
            _ => self.pause(30),
        }
    }

    /// RPDOs change mapped values faster than the inhibit time of a TPDO allows to send them.
    fn without_pause(&mut self, index: u16) {
        let Some(outputs) = self.dice.pick(&self.plan.knowledge.rpdos).copied() else { return self.timer(index) };
        let own = self.own_identifier(index);
        self.parameter(index, 1, own | 1 << 31);
        self.parameter(index, 3, 500);
        self.parameter(index, 1, own & 0x7FFF_FFFF);
        self.start();
        let id = Self::standard(self.own_identifier(outputs) as u16 & 0x7FF);
        let entries = self.knowledge().entries();
        let objects = entries.iter().filter(|known| known.at.index.0 == outputs + 0x200 && known.at.sub.0 > 0);
        let bits: u64 = objects.filter_map(|known| known.power_on).map(|entry| entry & 0xFF).sum();
        let len = bits.div_ceil(8).min(8) as usize;
        for _ in 0..4 {
            let bytes = self.dice.number().to_le_bytes();
            Frame::new(id, &bytes[..len]).into_iter().for_each(|frame| self.ask(frame));
        }
    }

    /// Reads the objects that an RPDO writes, before and after it, in any NMT state.
    fn outputs(&mut self) {
        let Some(index) = self.dice.pick(&self.plan.knowledge.rpdos).copied() else { return self.sync() };
        let mapped = self.knowledge().entry(Multiplexer::new(index + 0x200, 1)).and_then(|known| known.power_on);
        let mapped = mapped.map_or(0, |entry| entry as u32);
        let at = Multiplexer::new((mapped >> 16) as u16, (mapped >> 8) as u8);
        let mut own = self.own_identifier(index);
        match self.dice.below(6) {
            0 => self.parameter(index, 1, own | 1 << 31),
            1 => {
                let other = if self.dice.flip() { FREE } else { (own & 0x7FFF_FFFF) ^ 1 };
                self.parameter(index, 1, own | 1 << 31);
                self.parameter(index, 1, other);
                own = if self.dice.flip() { other } else { own };
            }
            2 => {
                let size = self.knowledge().entry(at).and_then(|known| known.size).unwrap_or(1).min(4);
                let value = self.dice.number().to_le_bytes();
                self.sdo(Request::download(at, &value[..size]));
            }
            _ => {}
        }
        let node = self.node() as u8;
        let command = self.dice.one_of([1, 1, 2, 128]);
        self.ask(Self::data(0, &[command, node]));
        let entries = self.knowledge().entries();
        let objects = entries.iter().filter(|known| known.at.index.0 == index + 0x200 && known.at.sub.0 > 0);
        let bits: u64 = objects.filter_map(|known| known.power_on).map(|entry| entry & 0xFF).sum();
        self.sdo(Request::upload(at));
        let bytes = self.dice.number().to_le_bytes();
        let id = Self::standard(own as u16 & 0x7FF);
        let len = if self.dice.one_in(4) { self.dice.below(9) } else { bits.div_ceil(8).min(8) as usize };
        let frame = match self.dice.below(4) {
            0 => Frame::remote(id, len as u8),
            _ => Frame::new(id, &bytes[..len]),
        };
        frame.into_iter().for_each(|frame| self.ask(frame));
        if command == 2 {
            self.ask(Self::data(0, &[128, node]));
        }
        self.sdo(Request::upload(at));
    }

    fn transmission(&mut self, index: u16) {
        let random = self.dice.byte();
        let value = self.dice.one_of([0, 1, 2, 3, 240, 241, 251, 252, 253, 254, 255, random]);
        self.parameter(index, 2, value.into());
    }

    fn timer(&mut self, index: u16) {
        if self.dice.flip() {
            let kind = self.dice.one_of([254, 255]);
            self.parameter(index, 2, kind);
        }
        let time = self.dice.one_of([0, 5, 10, 20]);
        self.parameter(index, 5, time);
        if self.dice.one_in(3) {
            let inhibit = self.dice.one_of([0, 50, 100, 200]);
            self.parameter(index, 3, inhibit);
        }
        self.start();
        self.pause(u64::from(time) * 4 + 15);
        if self.dice.one_in(4) {
            self.remote(index);
        }
    }

    fn synchronous(&mut self, index: u16) {
        let own = self.own_identifier(index);
        let kind = self.dice.one_of([1, 2, 3, 0]);
        self.parameter(index, 2, kind);
        self.parameter(index, 1, own & 0x7FFF_FFFF);
        self.start();
        self.sync();
    }

    fn remote(&mut self, index: u16) {
        let id = self.own_identifier(index) & 0x7FF;
        if let Some(frame) = Frame::remote(Self::standard(id as u16), 8) {
            self.ask(frame);
        }
    }

    /// A random mapping entry: an existing object, or one that can't be mapped.
    fn mapped(&mut self) -> u32 {
        let entry = |at: Multiplexer, bits: u32| u32::from(at.index.0) << 16 | u32::from(at.sub.0) << 8 | bits;
        if self.dice.one_in(4) {
            let at = self.object();
            let bits = self.knowledge().entry(at).and_then(|known| known.size).unwrap_or(4) as u32 * 8;
            let bits = if self.dice.flip() { bits } else { self.dice.one_of([0, 1, bits + 8, 64, 65]) };
            let dummy = self.dice.one_in(4);
            return if dummy { 0x0005_0008 } else { entry(at, bits & 0xFF) };
        }
        match self.object_where(|known| known.tpdo_mappable) {
            Some(known) => {
                let (at, bits) = (known.at, known.size.unwrap_or(4) as u32 * 8);
                entry(at, if self.dice.one_in(8) { bits + 8 } else { bits })
            }
            None => 0x6004_0020,
        }
    }

    fn mapping_entry(&mut self, index: u16) {
        let sub = 1 + self.dice.below(8) as u8;
        let entry = self.mapped();
        self.parameter(index + 0x200, sub, entry);
    }

    /// The mapping procedure of CiA 301: PDO invalid, count 0, entries, count, PDO valid. Now and then a step is left
    /// out.
    fn remap(&mut self, index: u16) {
        let own = self.own_identifier(index);
        let mapping = index + 0x200;
        let left_out = if self.dice.flip() { self.dice.below(4) } else { usize::MAX };
        if left_out != 0 {
            self.parameter(index, 1, own | 1 << 31);
        }
        if left_out != 1 {
            self.parameter(mapping, 0, 0);
        }
        let count = 1 + self.dice.below(4) as u8;
        for sub in 1..=count {
            let entry = self.mapped();
            self.parameter(mapping, sub, entry);
        }
        if left_out != 2 {
            let more = u8::from(self.dice.one_in(6));
            self.parameter(mapping, 0, (count + more).into());
        }
        if left_out != 3 {
            self.parameter(index, 1, own & 0x7FFF_FFFF);
        }
        if self.dice.flip() {
            self.start();
            self.remote(index);
            self.sync();
        }
    }
}
