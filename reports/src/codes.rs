//! The meaning of error codes of EMCY and of SDO abort codes.

use canvass_analyzer::dictionary::names::{ErrorName, error_names};
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::sdo::AbortCode;
use std::fmt::Write;

/// A code as users write it: `7121h`, `0x7121`, `0604 0041h`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Code {
    Emcy(u16),
    Abort(u32),
}

impl Code {
    fn parse(text: &str) -> Option<Self> {
        let compact: String = text.chars().filter(|character| !matches!(character, ' ' | '_')).collect();
        let compact = compact.to_ascii_lowercase();
        let digits = compact.strip_prefix("0x").or_else(|| compact.strip_suffix('h')).unwrap_or(&compact);
        let is_hex = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
        match digits.len() {
            4 if is_hex => u16::from_str_radix(digits, 16).ok().map(Self::Emcy),
            8 if is_hex => u32::from_str_radix(digits, 16).ok().map(Self::Abort),
            _ => None,
        }
    }
}

/// The meaning of an EMCY error code (four digits) or of an SDO abort code (eight digits); `None` if the text is
/// neither. With `profile`, only this device profile adds its meaning of an error code, otherwise every device profile
/// does.
pub fn explain(text: &str, profile: Option<u16>) -> Option<String> {
    match Code::parse(text)? {
        Code::Emcy(code) => Some(emcy(EmcyCode(code), profile)),
        Code::Abort(code) => Some(format!("{}\n\nSDO abort code (CiA 301).\n", AbortCode(code))),
    }
}

fn emcy(code: EmcyCode, profile: Option<u16>) -> String {
    let mut text = format!("{}\n\nError code of EMCY (CiA 301).\n", ErrorName { code, profile });
    let wanted = |row: &(u16, &str)| profile.is_none_or(|profile| profile == row.0);
    for (number, name) in error_names(code).into_iter().filter(wanted) {
        // Writing to a string can't fail.
        let _ = writeln!(text, "With device profile {number} (lower half of 1000h): {name}.");
    }
    if code.register_bits() != 0 {
        let register = canvass_analyzer::wire::emcy::ErrorRegister(code.register_bits());
        let _ = writeln!(text, "Bit of the error register (1001h): {register}.");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_read_as_they_are_written() {
        for text in ["7121h", "0x7121", "7121", "7121H"] {
            assert_eq!(Code::parse(text), Some(Code::Emcy(0x7121)), "{text}");
        }
        for text in ["0604 0041h", "0x06040041", "06040041h", "0604_0041"] {
            assert_eq!(Code::parse(text), Some(Code::Abort(0x0604_0041)), "{text}");
        }
        for text in ["712h", "nodes/lost", "0604 00", "sync", ""] {
            assert_eq!(Code::parse(text), None, "{text}");
        }
    }

    #[test]
    fn a_code_has_a_meaning_for_each_profile() {
        let all = explain("7121h", None).unwrap();
        assert!(all.starts_with("7121h additional modules\n"), "{all}");
        assert!(all.contains("With device profile 402 (lower half of 1000h): motor blocked."), "{all}");
        assert!(explain("7121h", Some(402)).unwrap().starts_with("7121h motor blocked\n"));
        assert!(!explain("2320h", Some(401)).unwrap().contains("402"));
        let text = explain("8140h", None).unwrap();
        assert!(text.starts_with("8140h recovered from bus off\n") && text.contains("communication"), "{text}");
        let text = explain("0604 0041h", None).unwrap();
        assert!(text.starts_with("0604 0041h object cannot be mapped to the PDO\n"), "{text}");
    }
}
