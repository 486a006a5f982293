//! A picture of a PDO in 80 columns: a character for each bit, a letter for each field.

use canvass_analyzer::dictionary::layout::PdoField;

/// The letters of the fields. A PDO has at most as many fields as bits.
const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789#@";

/// Maximum number of bits in a PDO.
const BITS: u32 = 64;

/// The letter of a field by its number.
pub(super) fn letter(number: usize) -> char {
    LETTERS.get(number).map_or('?', |&letter| char::from(letter))
}

/// Two lines: the numbers of the bytes, and below them the bits, bit 0 of each byte first.
pub(super) fn lines(fields: &[PdoField<'_>]) -> [String; 2] {
    let end = fields.last().map_or(0, PdoField::end).min(BITS);
    let bytes = end.div_ceil(8);
    let header: String = (0..bytes).map(|byte| format!("{byte:<8}")).collect();
    let mut bits = vec!['.'; bytes as usize * 8];
    for (number, field) in fields.iter().enumerate() {
        let last = field.end().saturating_sub(1);
        for bit in field.offset..field.end().min(BITS) {
            let Some(place) = bits.get_mut(bit as usize) else { continue };
            *place = match bit {
                _ if bit == field.offset => letter(number),
                _ if bit == last => '┤',
                _ => '─',
            };
        }
    }
    [format!("byte {}", header.trim_end()), format!("     {}", bits.into_iter().collect::<String>())]
}
