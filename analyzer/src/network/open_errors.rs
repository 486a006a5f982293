//! Errors of a node that were reported by EMCY and not yet taken back.

use crate::wire::emcy::{Emcy, EmcyCode};

/// The present errors of a node, each with data about its first message.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct OpenErrors<T> {
    rows: Vec<(EmcyCode, T)>,
}

impl<T> Default for OpenErrors<T> {
    fn default() -> Self {
        Self { rows: Vec::new() }
    }
}

impl<T> OpenErrors<T> {
    /// Maximum number of present errors; more different errors without any end are a storm.
    pub const MOST: usize = 16;

    /// Handles an EMCY message, and returns the errors that it ends. A repeated error keeps its age.
    ///
    /// The code 00xxh does not tell which error is gone. If the error register in the message is 0, all errors are
    /// gone. Otherwise an error is gone if the register has no bit of its class. A single present error is gone
    /// whatever the register says.
    pub fn handle(&mut self, emcy: &Emcy, what: impl FnOnce() -> T) -> Vec<(EmcyCode, T)> {
        let Some(code) = emcy.code() else { return Vec::new() };
        if !code.is_reset() {
            let known = self.rows.iter().any(|row| row.0 == code);
            if !known && self.rows.len() < Self::MOST {
                self.rows.push((code, what()));
            }
            debug_assert!(self.rows.len() <= Self::MOST);
            return Vec::new();
        }
        let register = emcy.register().map_or(0, |register| register.0);
        if register == 0 || self.rows.len() == 1 {
            return std::mem::take(&mut self.rows);
        }
        let gone = |row: &mut (EmcyCode, T)| row.0.register_bits() & !register != 0;
        self.rows.extract_if(.., gone).collect()
    }

    /// The present errors.
    pub fn iter(&self) -> impl Iterator<Item = (EmcyCode, &T)> {
        self.rows.iter().map(|row| (row.0, &row.1))
    }

    /// Removes all errors, at a restart of the node.
    pub fn clear(&mut self) {
        self.rows.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Wire;

    fn ends(errors: &mut OpenErrors<u32>, n: u32, payload: [u8; 3]) -> Vec<(u16, u32)> {
        let emcy = Emcy::read(&[payload[0], payload[1], payload[2], 0, 0, 0, 0, 0]).unwrap();
        errors.handle(&emcy, || n).into_iter().map(|(code, n)| (code.0, n)).collect()
    }

    #[test]
    fn the_register_tells_which_error_is_gone() {
        let mut errors = OpenErrors::default();
        assert_eq!(ends(&mut errors, 1, [0x30, 0x81, 0x11]), []);
        assert_eq!(ends(&mut errors, 2, [0x00, 0x42, 0x19]), []);
        assert_eq!(ends(&mut errors, 3, [0x00, 0x42, 0x19]), []);
        assert_eq!(ends(&mut errors, 4, [0x00, 0x00, 0x09]), [(0x8130, 1)]);
        assert_eq!(ends(&mut errors, 5, [0x00, 0x00, 0x00]), [(0x4200, 2)]);
        assert_eq!(ends(&mut errors, 6, [0x00, 0x00, 0x00]), []);
    }

    #[test]
    fn what_can_not_be_told_stays() {
        let mut errors = OpenErrors::default();
        ends(&mut errors, 1, [0x00, 0xFF, 0x81]);
        ends(&mut errors, 2, [0x01, 0xFF, 0x81]);
        assert_eq!(ends(&mut errors, 3, [0x00, 0x00, 0x81]), []);
        assert_eq!(errors.iter().count(), 2);
        assert_eq!(ends(&mut errors, 4, [0x00, 0x00, 0x00]).len(), 2);
    }

    #[test]
    fn a_storm_is_bounded() {
        let mut errors = OpenErrors::default();
        for code in 0..20 {
            ends(&mut errors, u32::from(code), [code, 0xFF, 0x81]);
        }
        assert_eq!(errors.iter().map(|row| *row.1).collect::<Vec<_>>(), (0..16).collect::<Vec<_>>());
        // The only present error ends whatever the register says.
        let mut errors = OpenErrors::default();
        ends(&mut errors, 1, [0x00, 0xFF, 0x81]);
        assert_eq!(ends(&mut errors, 2, [0x00, 0x00, 0x81]), [(0xFF00, 1)]);
        ends(&mut errors, 3, [0x00, 0xFF, 0x81]);
        errors.clear();
        assert_eq!(errors.iter().count(), 0);
    }
}
