//! Values of objects as numbers.

/// The number in 1 to 4 bytes.
pub fn number(data: &[u8]) -> Option<u32> {
    let mut bytes = [0; 4];
    bytes.get_mut(..data.len())?.copy_from_slice(data);
    (!data.is_empty()).then(|| u32::from_le_bytes(bytes))
}
