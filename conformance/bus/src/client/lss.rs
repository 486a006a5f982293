//! The LSS master's Fastscan (CiA 305): finds the address of one slave without a node-ID, bit by bit.
//!
//! Many slaves may take part and answer at once, with the same frame. The scan finds the lowest address: if no slave
//! answers to the question for a 0 bit, all remaining slaves have a 1.

use canvass_analyzer::wire::lss::{Part, Request};

/// The vendor-ID, product code, revision number and serial number of a slave.
pub type LssAddress = [u32; 4];

/// The state of a scan.
#[derive(Clone, Debug)]
pub struct Fastscan {
    address: LssAddress,
    stage: Stage,
}

#[derive(Clone, Copy, Debug)]
enum Stage {
    /// The master asked whether any slave without node-ID exists.
    Begin,
    /// The master asked whether bit `bit` of part `part` of the LSS address is 0.
    Bit { part: usize, bit: u8 },
    /// The master asked whether part `part` of the LSS address is right; slaves with another value leave the scan.
    Verify { part: usize },
}

/// The step after an answer or a timeout.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum ScanStep {
    /// Send the request, and wait for an answer.
    Ask(Request),
    /// The slave was found, and is in configuration.
    Found(LssAddress),
    /// There is no slave without a node-ID.
    Nobody,
    /// The slave did not confirm the part: an answer was lost, or the slave left.
    Lost(Part),
}

/// The value of "bit check" in the request that begins a scan.
const BEGIN: u8 = 0x80;

impl Fastscan {
    /// A new scan, and its first request.
    pub fn begin() -> (Self, Request) {
        let request = Request::Fastscan { id: 0, bit_check: BEGIN, sub: 0, next: 0 };
        (Self { address: [0; 4], stage: Stage::Begin }, request)
    }

    /// Handles the result of the last request; `answered` tells whether a slave answered.
    pub fn handle(&mut self, answered: bool) -> ScanStep {
        match self.stage {
            Stage::Begin if answered => self.ask_bit(0, 31),
            Stage::Begin => ScanStep::Nobody,
            Stage::Bit { part, bit } => {
                if !answered && let Some(value) = self.address.get_mut(part) {
                    *value |= 1 << bit;
                }
                if bit > 0 { self.ask_bit(part, bit - 1) } else { self.verify(part) }
            }
            Stage::Verify { part } if !answered => ScanStep::Lost(*Part::ALL.get(part).unwrap_or(&Part::VendorId)),
            Stage::Verify { part } if part + 1 < self.address.len() => self.ask_bit(part + 1, 31),
            Stage::Verify { .. } => ScanStep::Found(self.address),
        }
    }

    fn ask_bit(&mut self, part: usize, bit: u8) -> ScanStep {
        self.stage = Stage::Bit { part, bit };
        self.request(part, bit, part)
    }

    /// Verifies a part of the address. The request also names the next part; after the last part it names the first
    /// one, which ends the scan for the slave.
    fn verify(&mut self, part: usize) -> ScanStep {
        self.stage = Stage::Verify { part };
        self.request(part, 0, (part + 1) % self.address.len())
    }

    fn request(&self, part: usize, bit_check: u8, next: usize) -> ScanStep {
        debug_assert!(part < Part::ALL.len() && next < Part::ALL.len() && bit_check < 32, "{:?}", self.stage);
        let id = self.address.get(part).copied().unwrap_or_default();
        ScanStep::Ask(Request::Fastscan { id, bit_check, sub: part as u8, next: next as u8 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A slave by CiA 305: it compares the bits from bit 31 down to the requested bit.
    struct Slave {
        address: LssAddress,
        part: u8,
        configuring: bool,
    }

    impl Slave {
        fn answers(&mut self, request: &Request) -> bool {
            let Request::Fastscan { id, bit_check, sub, next } = *request else { return false };
            if bit_check == BEGIN {
                self.part = 0;
                return true;
            }
            if sub != self.part || (self.address[usize::from(sub)] ^ id) >> bit_check != 0 {
                return false;
            }
            if bit_check == 0 && next != sub {
                self.part = next;
                self.configuring = next < sub;
            }
            true
        }
    }

    fn scan(slaves: &mut [Slave]) -> ScanStep {
        let (mut scan, mut request) = Fastscan::begin();
        for _ in 0..200 {
            // All slaves receive the request.
            let answered = slaves.iter_mut().map(|slave| slave.answers(&request)).fold(false, |a, b| a | b);
            match scan.handle(answered) {
                ScanStep::Ask(next) => request = next,
                end => return end,
            }
        }
        panic!("the scan does not end");
    }

    proptest! {
        #[test]
        fn one_slave_is_found_whatever_its_address(addresses in prop::collection::vec(any::<LssAddress>(), 1..4)) {
            let mut slaves: Vec<Slave> =
                addresses.iter().map(|&address| Slave { address, part: 0, configuring: false }).collect();
            let lowest = *addresses.iter().min().unwrap();
            prop_assert_eq!(scan(&mut slaves), ScanStep::Found(lowest));
            for slave in slaves {
                prop_assert_eq!(slave.configuring, slave.address == lowest);
            }
        }
    }

    #[test]
    fn nobody_and_lost() {
        assert_eq!(scan(&mut []), ScanStep::Nobody);
        let (mut scan, _) = Fastscan::begin();
        let mut step = scan.handle(true);
        // The slave is unplugged: the master finds no bit that is 0, and no slave confirms the part.
        for _ in 0..33 {
            assert!(matches!(step, ScanStep::Ask(_)));
            step = scan.handle(false);
        }
        assert_eq!(step, ScanStep::Lost(Part::VendorId));
    }
}
