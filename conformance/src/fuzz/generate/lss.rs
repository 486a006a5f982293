//! LSS dialogues.

use super::Script;
use crate::fuzz::stimulus::Start;
use canvass_analyzer::wire::lss::{Bound, MASTER_CAN_ID, Part, Request};

impl Script<'_> {
    pub(super) fn lss_dialogue(&mut self) {
        if self.sequence.stimuli.is_empty() {
            let unconfigured = self.plan.unconfigured && self.dice.flip();
            self.sequence.start = if unconfigured { Start::Unconfigured } else { Start::Configured };
        }
        match self.dice.below(16) {
            0 | 1 => self.select(),
            2 | 3 => self.inquire(),
            4..=6 => self.configure(),
            7 | 8 => self.identify(),
            9..=12 => self.fastscan(),
            13 => self.lss(Request::IdentifyNonConfigured),
            14 => self.switch(),
            _ => self.odd_lss_frame(),
        }
    }

    fn address(&self) -> [u32; 4] {
        self.knowledge().address.unwrap_or([0; 4])
    }

    fn switch(&mut self) {
        let mode = self.dice.one_of([0, 0, 1, 1, 1, 2, 255]);
        self.lss(Request::SwitchGlobal { mode });
    }

    fn select(&mut self) {
        let address = self.address();
        let wrong = if self.dice.flip() { self.dice.below(4) } else { usize::MAX };
        let kind = self.dice.below(3);
        if self.dice.flip() {
            self.lss(Request::SwitchGlobal { mode: 0 });
        }
        for (n, part) in Part::ALL.into_iter().enumerate() {
            let mut value = address[n];
            if n == wrong {
                match kind {
                    0 => value ^= 1 << self.dice.below(32),
                    1 => continue,
                    _ => self.odd_lss_frame(),
                }
            }
            self.lss(Request::SwitchSelective { part, value });
        }
        self.lss(Request::InquireNodeId);
    }

    fn inquire(&mut self) {
        if self.dice.flip() {
            self.switch();
        }
        let part = self.dice.one_of(Part::ALL);
        self.lss(Request::Inquire { part });
        self.lss(Request::InquireNodeId);
    }

    fn configure(&mut self) {
        let own = self.node() as u8;
        if !self.dice.one_in(4) {
            self.lss(Request::SwitchGlobal { mode: 1 });
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
        self.lss(request);
        if self.dice.flip() {
            self.lss(Request::InquireNodeId);
        }
        if self.dice.one_in(4) {
            // What is pending must not come into force.
            self.lss(Request::ConfigureNodeId { node_id: own });
            self.lss(Request::SwitchGlobal { mode: 0 });
        }
        if self.dice.one_in(32) {
            self.lss(Request::StoreConfiguration);
        }
        if self.dice.one_in(64) {
            self.lss(Request::ActivateBitTiming { delay: 10 });
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
            // Just outside: the lower bound one above, the upper one below.
            bounds[wrong] = match wrong {
                2 => revision.wrapping_add(1),
                3 => revision.wrapping_sub(1),
                4 => serial.wrapping_add(1),
                5 => serial.wrapping_sub(1),
                _ => bounds[wrong].wrapping_add(1),
            };
        }
        for (bound, value) in Bound::ALL.into_iter().zip(bounds) {
            self.lss(Request::IdentifyRemote { bound, value });
        }
    }

    fn fastscan(&mut self) {
        let address = self.address();
        let scan = |id, bit_check, sub, next| Request::Fastscan { id, bit_check, sub, next };
        if !self.dice.one_in(8) {
            self.lss(scan(0, 128, 0, 0));
        }
        match self.dice.below(4) {
            0 => {
                // The right values, part by part, with one mistake now and then.
                let wrong = if self.dice.flip() { self.dice.below(4) } else { usize::MAX };
                for (n, &id) in address.iter().enumerate() {
                    let id = if n == wrong { id ^ 1 << self.dice.below(32) } else { id };
                    let sub = n as u8;
                    self.lss(scan(id, 0, sub, (sub + 1) % 4));
                }
            }
            1 => {
                let sub = self.dice.below(5) as u8;
                let bit_check = self.dice.below(34) as u8;
                let id = address.get(usize::from(sub)).copied().unwrap_or(0)
                    ^ u32::from(self.dice.flip()) << (bit_check & 31);
                self.lss(scan(id, bit_check, sub, sub));
            }
            2 => {
                // Completion before the last part.
                for sub in 0..=self.dice.below(3) as u8 {
                    let next = if self.dice.flip() { sub + 1 } else { 0 };
                    self.lss(scan(address[usize::from(sub)], 0, sub, next));
                }
            }
            _ => {
                let raw = self.dice.number().to_le_bytes();
                self.lss(scan(address[0], raw[0], raw[1] & 7, raw[2] & 7));
            }
        }
        self.lss(Request::InquireNodeId);
    }

    fn odd_lss_frame(&mut self) {
        let bytes = self.dice.number().to_le_bytes();
        let len = if self.dice.one_in(4) { self.dice.below(8) } else { 8 };
        self.ask(Self::data(MASTER_CAN_ID, &bytes[..len]));
    }
}
