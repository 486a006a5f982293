//! LMT dialogues, for devices with LMT instead of LSS.

use super::Script;
use canvass_analyzer::wire::lmt::{Lmt, Part, Request, Seven};

impl Script<'_> {
    pub(super) fn lmt_dialogue(&mut self) {
        match self.dice.below(16) {
            0..=3 => self.lmt_select(),
            4..=6 => self.inquire::<Lmt>(),
            7..=9 => self.lmt_configure(),
            10..=13 => self.lmt_identify(),
            14 => self.switch::<Lmt>(),
            _ => self.lmt_nonsense(),
        }
    }

    fn lmt_part(&self, part: Part) -> Seven {
        let address = self.knowledge().lmt;
        let value = address.and_then(|address| match part {
            Part::ManufacturerName => Some(address.manufacturer_name),
            Part::ProductName => Some(address.product_name),
            Part::SerialNumber => address.serial_number,
        });
        value.unwrap_or(Seven([0; 7]))
    }

    /// Changes two digits of the serial number, or one bit of a name.
    fn lmt_distorted(&mut self, part: Part, value: Seven) -> Seven {
        let mut bytes = value.0;
        let at = self.dice.below(7);
        match part {
            Part::SerialNumber => bytes[at] = self.dice.byte() & 0x77,
            _ => bytes[at] ^= 1 << self.dice.below(8),
        }
        Seven(bytes)
    }

    fn lmt_select(&mut self) {
        let wrong = if self.dice.flip() { self.dice.below(3) } else { usize::MAX };
        self.tell(Request::SwitchGlobal { mode: 0 });
        for (n, part) in Part::ALL.into_iter().enumerate() {
            let mut value = self.lmt_part(part);
            if n == wrong {
                if self.dice.one_in(4) {
                    continue;
                }
                value = self.lmt_distorted(part, value);
            }
            self.tell(Request::SwitchSelective { part, value });
        }
        self.inquire_part::<Lmt>();
    }

    fn lmt_configure(&mut self) {
        if !self.dice.one_in(4) {
            self.tell(Request::SwitchGlobal { mode: 1 });
        }
        let own = self.node() as u8;
        let request = match self.dice.below(8) {
            0..=2 => {
                let node_id = self.dice.one_of([own, own, 1, 27, 127, 0, 128, 255]);
                Request::ConfigureNodeId { node_id }
            }
            3 | 4 => Request::ConfigureBitTiming { table: 0, index: self.dice.byte() % 10 },
            5 => Request::ConfigureBitTiming { table: self.dice.byte(), index: self.dice.byte() },
            6 => Request::StoreConfiguration,
            _ => Request::ActivateBitTiming { delay: 10 },
        };
        self.tell(request);
        self.read();
    }

    fn lmt_identify(&mut self) {
        let serial = self.lmt_part(Part::SerialNumber);
        let mut values = [self.lmt_part(Part::ManufacturerName), self.lmt_part(Part::ProductName), serial, serial];
        match self.dice.below(4) {
            0 | 1 => {
                let wrong = self.dice.below(4);
                let part = if wrong < 2 { Part::ProductName } else { Part::SerialNumber };
                values[wrong] = self.lmt_distorted(part, values[wrong]);
            }
            2 => (values[2], values[3]) = (Seven([0; 7]), Seven([0x99; 7])),
            _ => {}
        }
        self.identify_within::<Lmt>(values);
    }

    fn lmt_nonsense(&mut self) {
        let mut bytes = self.dice.number().to_le_bytes();
        if self.dice.flip() {
            bytes[0] = self.dice.one_of([0x00, 0x0A, 0x10, 0x27, 0x40, 0x46, 0x4C, 0x51, 0x5A, 0x5E, 0xFF]);
        }
        self.odd_layer_frame(bytes);
    }
}
