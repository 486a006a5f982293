//! Checks that the lengths inside a record fit into it.
//!
//! The crate's parser trusts the length of a text and allocates memory for it before it reads: a schema whose name
//! claims 4 GiB would end the program (mcap 0.26, `McapString`). So these checks come first. They also distinguish
//! records without messages from messages with a damaged code.

/// Skips a text, which follows its length; returns the rest.
fn text(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)
}

/// Skips a map of names and values, which follows its total length; returns the rest.
fn map(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    let (mut pairs, rest) = rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)?;
    while !pairs.is_empty() {
        pairs = text(text(pairs)?)?;
    }
    Some(rest)
}

/// Checks a schema record: number, name, encoding, data.
pub(crate) fn schema_fits(record: &[u8]) -> bool {
    let data = || text(text(text(record.get(2..)?)?)?);
    data().is_some()
}

/// Checks a channel record: number, schema, topic, encoding, metadata.
pub(crate) fn channel_fits(record: &[u8]) -> bool {
    let metadata = || map(text(text(record.get(4..)?)?)?);
    metadata().is_some()
}

/// Checks a metadata record: name, and a map of values by their names.
pub(crate) fn metadata_fits(record: &[u8]) -> bool {
    text(record).and_then(map).is_some_and(<[u8]>::is_empty)
}

/// Checks an attachment: two times, name, kind, data with its length, checksum. `head` is only the beginning of a long
/// record.
pub(crate) fn attachment_fits(head: &[u8], length: u64) -> bool {
    let data = || {
        let rest = text(text(head.get(16..)?)?)?;
        let before = head.len() - rest.len();
        let data = u64::from_le_bytes(*rest.first_chunk()?);
        data.checked_add(before as u64 + 12)
    };
    data() == Some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_the_record_does_not_fit() {
        let name = b"\x01\0\x02\0\0\0ab";
        assert!(schema_fits(&[&name[..], b"\0\0\0\0", b"\x01\0\0\0x"].concat()));
        assert!(!schema_fits(&[&name[..], b"\0\0\0\0", b"\x02\0\0\0x"].concat()));
        assert!(!schema_fits(b"\x01\0\xFF\xFF\xFF\xFFab"));
        assert!(channel_fits(b"\x01\0\x01\0\x01\0\0\0t\0\0\0\0\x0A\0\0\0\x01\0\0\0k\x01\0\0\0v"));
        assert!(!channel_fits(b"\x01\0\x01\0\x01\0\0\0t\0\0\0\0\x0A\0\0\0\xFF\xFF\xFF\xFFk\x01\0\0\0v"));
        assert!(!channel_fits(b"\x01\0\x01\0\x01\0\0\0t\0\0\0\0\x0B\0\0\0\x01\0\0\0k\x01\0\0\0v"));
        assert!(metadata_fits(b"\x01\0\0\0n\0\0\0\0"));
        assert!(!metadata_fits(b"\x01\0\0\0n\0\0\0\0x"));
        let attachment = [&[0; 16][..], b"\x01\0\0\0n\0\0\0\0", &3_u64.to_le_bytes(), b"abc", &[0; 4]].concat();
        assert!(attachment_fits(&attachment, attachment.len() as u64));
        assert!(!attachment_fits(&attachment, attachment.len() as u64 + 1));
    }
}
