//! LSS dialogues.

use super::Script;
use crate::coverage::{LssCommand, LssState};
use crate::stimulus::Start;
use canvass_analyzer::wire::lss::{Bound, Lss, MASTER_CAN_ID, Part, Request};

impl Script<'_> {
    pub(super) fn lss_dialogue(&mut self) {
        if self.sequence.stimuli.is_empty() {
            let unconfigured = self.plan.unconfigured && self.dice.flip();
            self.sequence.start = if unconfigured { Start::Unconfigured } else { Start::Configured };
            if !unconfigured && self.knowledge().services.lss_not_in_operational {
                let own = self.node() as u8;
                let command = self.dice.one_of([2, 128]);
                self.ask(Self::data(0, &[command, own]));
            }
        }
        if let Some((state, command)) = self.plan.lss_focus
            && self.dice.one_in(3)
        {
            self.reach_lss(state);
            return self.lss_command(command);
        }
        match self.dice.below(16) {
            0 | 1 => self.select(),
            2 | 3 => {
                self.inquire::<Lss>();
                self.tell(Request::InquireNodeId);
            }
            4..=6 => self.configure(),
            7 | 8 => self.identify(),
            9..=12 => self.fastscan(),
            13 => self.tell(Request::IdentifyNonConfigured),
            14 => self.switch::<Lss>(),
            _ => self.odd_lss_frame(),
        }
    }

    /// Brings the slave into a state. A state without node-ID is reached only if the sequence begins without node-ID.
    fn reach_lss(&mut self, state: LssState) {
        let [vendor, ..] = self.address();
        match state {
            LssState::Waiting | LssState::Unconfigured => self.tell(Request::SwitchGlobal { mode: 0 }),
            LssState::Selecting => {
                self.tell(Request::SwitchGlobal { mode: 0 });
                self.tell(Request::SwitchSelective { part: Part::VendorId, value: vendor });
            }
            LssState::Configuration => self.tell(Request::SwitchGlobal { mode: 1 }),
            LssState::Scanning => {
                self.tell(Request::SwitchGlobal { mode: 0 });
                self.tell(Request::Fastscan { id: 0, bit_check: 128, sub: 0, next: 0 });
            }
        }
    }

    /// Adds a frame of the class.
    fn lss_command(&mut self, command: LssCommand) {
        let [vendor, ..] = self.address();
        let request = match command {
            LssCommand::SwitchGlobal => return self.switch::<Lss>(),
            LssCommand::ConfigureNodeId => Request::ConfigureNodeId { node_id: self.dice.byte() },
            LssCommand::ConfigureBitTiming => Request::ConfigureBitTiming { table: 0, index: self.dice.byte() % 12 },
            LssCommand::ActivateBitTiming => Request::ActivateBitTiming { delay: 10 },
            LssCommand::Store => Request::StoreConfiguration,
            LssCommand::SwitchSelective => {
                Request::SwitchSelective { part: self.dice.one_of(Part::ALL), value: vendor }
            }
            LssCommand::IdentifyRemote => {
                Request::IdentifyRemote { bound: self.dice.one_of(Bound::ALL), value: vendor }
            }
            LssCommand::IdentifyNonConfigured => Request::IdentifyNonConfigured,
            LssCommand::Fastscan => Request::Fastscan {
                id: vendor,
                bit_check: self.dice.one_of([128, 31, 16, 1, 0]),
                sub: 0,
                next: self.dice.one_of([0, 1]),
            },
            LssCommand::Inquire => Request::Inquire { part: self.dice.one_of(Part::ALL) },
            LssCommand::InquireNodeId => Request::InquireNodeId,
            LssCommand::Unknown => {
                let command = self.dice.one_of([0x00, 0x10, 0x12, 0x18, 0x44, 0x4D, 0x50, 0x52, 0x5F, 0xFF]);
                return self.ask(Self::data(MASTER_CAN_ID, &[command, 0, 0, 0, 0, 0, 0, 0]));
            }
            LssCommand::Short => {
                let len = self.dice.below(8);
                let command = self.dice.one_of([0x04, 0x40, 0x5E, 0x5A]);
                return self.ask(Self::data(MASTER_CAN_ID, &[command, 1, 0, 0, 0, 0, 0, 0][..len]));
            }
        };
        self.tell(request);
    }

    fn address(&self) -> [u32; 4] {
        self.knowledge().address.unwrap_or([0; 4])
    }

    fn select(&mut self) {
        let address = self.address();
        let wrong = if self.dice.flip() { self.dice.below(4) } else { usize::MAX };
        let kind = self.dice.below(4);
        if self.dice.flip() {
            self.tell(Request::SwitchGlobal { mode: 0 });
        }
        for (n, part) in Part::ALL.into_iter().enumerate() {
            let mut value = address[n];
            if n == wrong {
                match kind {
                    0 => value ^= 1 << self.dice.below(32),
                    1 => continue,
                    // A part of another device's address comes in between.
                    2 => {
                        let other = value ^ 1 << self.dice.below(32);
                        self.tell(Request::SwitchSelective { part, value: other });
                    }
                    _ => self.odd_lss_frame(),
                }
            }
            self.tell(Request::SwitchSelective { part, value });
        }
        self.tell(Request::InquireNodeId);
    }

    fn configure(&mut self) {
        let own = self.node() as u8;
        if !self.dice.one_in(4) {
            self.tell(Request::SwitchGlobal { mode: 1 });
        }
        let request = match self.dice.below(8) {
            0..=3 => {
                let node_id = self.dice.one_of([own, own, 0, 1, 127, 128, 200, 254, 255]);
                Request::ConfigureNodeId { node_id }
            }
            4 | 5 => Request::ConfigureBitTiming { table: 0, index: self.dice.byte() % 12 },
            6 => Request::ConfigureBitTiming { table: self.dice.byte(), index: self.dice.byte() },
            _ => Request::InquireNodeId,
        };
        self.tell(request);
        if self.dice.flip() {
            self.tell(Request::InquireNodeId);
        }
        if self.dice.one_in(4) {
            // The pending node-ID must not take effect.
            self.tell(Request::ConfigureNodeId { node_id: own });
            self.tell(Request::SwitchGlobal { mode: 0 });
        }
        if self.dice.one_in(32) {
            self.tell(Request::StoreConfiguration);
        }
        if self.dice.one_in(64) {
            self.tell(Request::ActivateBitTiming { delay: 10 });
        }
    }

    fn identify(&mut self) {
        let [vendor, product, revision, serial] = self.address();
        let spread = self.dice.one_of([0, 0, 1, 1000]);
        let mut bounds = [
            vendor,
            product,
            revision.saturating_sub(spread),
            revision.saturating_add(spread),
            serial.saturating_sub(spread),
            serial.saturating_add(spread),
        ];
        if self.dice.flip() {
            let wrong = self.dice.below(6);
            // One bound just excludes the slave: a lower or equal bound is one too high, an upper bound is one too low.
            bounds[wrong] = match wrong {
                2 => revision.wrapping_add(1),
                3 => revision.wrapping_sub(1),
                4 => serial.wrapping_add(1),
                5 => serial.wrapping_sub(1),
                _ => bounds[wrong].wrapping_add(1),
            };
        }
        self.identify_within::<Lss>(bounds);
    }

    fn fastscan(&mut self) {
        let address = self.address();
        let scan = |id, bit_check, sub, next| Request::Fastscan { id, bit_check, sub, next };
        if !self.dice.one_in(8) {
            self.tell(scan(0, 128, 0, 0));
        }
        match self.dice.below(4) {
            0 => {
                // The correct parts in their order, now and then with one mistake.
                let wrong = if self.dice.flip() { self.dice.below(4) } else { usize::MAX };
                for (n, &id) in address.iter().enumerate() {
                    let id = if n == wrong { id ^ 1 << self.dice.below(32) } else { id };
                    let sub = n as u8;
                    self.tell(scan(id, 0, sub, (sub + 1) % 4));
                }
            }
            1 => {
                let sub = self.dice.below(5) as u8;
                let bit_check = self.dice.below(34) as u8;
                let id = address.get(usize::from(sub)).copied().unwrap_or(0)
                    ^ u32::from(self.dice.flip()) << (bit_check & 31);
                self.tell(scan(id, bit_check, sub, sub));
            }
            2 => {
                // The scan is completed before its last part.
                for sub in 0..=self.dice.below(3) as u8 {
                    let next = if self.dice.flip() { sub + 1 } else { 0 };
                    self.tell(scan(address[usize::from(sub)], 0, sub, next));
                }
            }
            _ => {
                let raw = self.dice.number().to_le_bytes();
                self.tell(scan(address[0], raw[0], raw[1] & 7, raw[2] & 7));
            }
        }
        self.tell(Request::InquireNodeId);
    }

    fn odd_lss_frame(&mut self) {
        let bytes = self.dice.number().to_le_bytes();
        self.odd_layer_frame(bytes);
    }
}
