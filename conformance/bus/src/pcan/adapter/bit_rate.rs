//! Bit rates in the form of PCAN-Basic: the registers BTR0 and BTR1 of an SJA1000 with a clock of 8 MHz.
//!
//! ```text
//! BTR0  ssbbbbbb   synchronisation jump width - 1, prescaler - 1
//! BTR1  nttteeee   three samples, time segment 2 - 1, time segment 1 - 1
//! ```

/// The registers of each bit rate in bit/s, with BTR0 in the upper byte. PEAK's own programs use the same values, so an
/// adapter has the same sample point as one that these programs use.
const KNOWN: [(u32, u16); 14] = [
    (1_000_000, 0x0014),
    (800_000, 0x0016),
    (500_000, 0x001C),
    (250_000, 0x011C),
    (125_000, 0x031C),
    (100_000, 0x432F),
    (95_238, 0xC34E),
    (83_333, 0x852B),
    (50_000, 0x472F),
    (47_619, 0x1414),
    (33_333, 0x8B2F),
    (20_000, 0x532F),
    (10_000, 0x672F),
    (5_000, 0x7F7F),
];

/// The registers for a bit rate in bit/s, if it is in the table.
pub(super) fn registers(bit_rate: u32) -> Option<u16> {
    KNOWN.iter().find(|(known, _)| *known == bit_rate).map(|(_, registers)| *registers)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bit rate in bit/s, rounded down, computed from the meaning of the registers.
    fn bit_rate(registers: u16) -> u32 {
        let [btr0, btr1] = registers.to_be_bytes().map(u32::from);
        let prescaler = (btr0 & 0x3F) + 1;
        let quanta = 1 + (btr1 & 0x0F) + 1 + (btr1 >> 4 & 0x07) + 1;
        8_000_000 / (prescaler * quanta)
    }

    #[test]
    fn the_registers_give_the_bit_rate() {
        for (rate, registers) in KNOWN {
            assert_eq!(bit_rate(registers), rate, "{registers:04X}h");
        }
    }

    #[test]
    fn all_bit_rates_of_canopen_are_known() {
        for rate in [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000] {
            assert!(registers(rate).is_some(), "{rate}");
        }
        assert_eq!(registers(123_456), None);
    }
}
