//! Messages to and from the kernel's routing socket about one link (`linux/netlink.h`, `linux/rtnetlink.h`).
//!
//! ```text
//! length u32, type u16, flags u16, sequence u32, port u32        every message
//! family u8, 0, ARPHRD u16, index i32, flags u32, change u32     about a link
//! length u16, type u16, data, filled up to four bytes            attributes, also nested
//! ```

use std::io;

pub(super) const RTM_NEWLINK: u16 = 16;
pub(super) const RTM_GETLINK: u16 = 18;
const NLMSG_ERROR: u16 = 2;
pub(super) const NLM_F_REQUEST: u16 = 1;
pub(super) const NLM_F_ACK: u16 = 4;
/// What every message begins with.
pub(super) const HEADER: usize = 16;
/// What every message about a link goes on with.
pub(super) const LINK_HEADER: usize = 16;
pub(super) const IFF_UP: u32 = 1;
/// Nested attributes have the highest bit set, or not, depending on the kernel.
const TYPE_MASK: u16 = 0x3FFF;

/// A message about the link of that index, or 0 where an attribute names it. `change` says which of `flags` count.
pub(super) fn message(kind: u16, how: u16, index: u32, (flags, change): (u32, u32), attributes: &[u8]) -> Vec<u8> {
    let length = HEADER + LINK_HEADER + attributes.len();
    let mut message = Vec::with_capacity(length);
    message.extend_from_slice(&(length as u32).to_ne_bytes());
    message.extend_from_slice(&kind.to_ne_bytes());
    message.extend_from_slice(&how.to_ne_bytes());
    message.extend_from_slice(&[0; 8 + 4]);
    for number in [index, flags, change] {
        message.extend_from_slice(&number.to_ne_bytes());
    }
    message.extend_from_slice(attributes);
    message
}

/// An attribute, filled up.
pub(super) fn attribute(kind: u16, data: &[u8]) -> Vec<u8> {
    let length = 4 + data.len();
    let mut attribute = Vec::with_capacity(length.next_multiple_of(4));
    attribute.extend_from_slice(&(length as u16).to_ne_bytes());
    attribute.extend_from_slice(&kind.to_ne_bytes());
    attribute.extend_from_slice(data);
    attribute.resize(length.next_multiple_of(4), 0);
    attribute
}

/// The attributes in a row.
pub(super) fn attributes(mut rest: &[u8]) -> impl Iterator<Item = (u16, &[u8])> {
    std::iter::from_fn(move || {
        let length = usize::from(u16_at(rest, 0)?);
        let kind = u16_at(rest, 2)? & TYPE_MASK;
        let data = rest.get(4..length)?;
        rest = rest.get(length.next_multiple_of(4)..).unwrap_or_default();
        Some((kind, data))
    })
}

/// The type of a message that tells something.
///
/// # Errors
/// What the kernel says went wrong, or that the message is none.
pub(super) fn kind(answer: &[u8]) -> io::Result<u16> {
    let kind = u16_at(answer, 4).ok_or_else(malformed)?;
    if kind != NLMSG_ERROR {
        return Ok(kind);
    }
    match u32_at(answer, HEADER).ok_or_else(malformed)? as i32 {
        0 => Ok(kind),
        code => Err(io::Error::from_raw_os_error(code.saturating_neg())),
    }
}

pub(super) fn malformed() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "an unreadable answer of the kernel's routing socket")
}

pub(super) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|bytes| u16::from_ne_bytes(*bytes))
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|bytes| u32::from_ne_bytes(*bytes))
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk().map(|bytes| u64::from_ne_bytes(*bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_tells_or_says_what_went_wrong() {
        let answer = |code: i32| [&message(NLMSG_ERROR, 0, 0, (0, 0), &[])[..HEADER], &code.to_ne_bytes()].concat();
        assert_eq!(kind(&answer(0)).unwrap(), NLMSG_ERROR);
        assert_eq!(kind(&answer(-libc::EPERM)).unwrap_err().kind(), io::ErrorKind::PermissionDenied);
        assert!(kind(&answer(i32::MIN)).is_err());
        assert_eq!(kind(&answer(0)[..HEADER]).unwrap_err().kind(), io::ErrorKind::InvalidData);
        assert_eq!(kind(&message(RTM_NEWLINK, 0, 7, (0, 0), &[])).unwrap(), RTM_NEWLINK);
    }

    #[test]
    fn attributes_come_back() {
        let row = [attribute(3, b"can0\0"), attribute(0x8000 | 18, &attribute(1, b"can"))].concat();
        let found: Vec<_> = attributes(&row).collect();
        assert_eq!(found[0], (3, &b"can0\0"[..]));
        assert_eq!((found[1].0, attributes(found[1].1).collect::<Vec<_>>()), (18, vec![(1, &b"can"[..])]));
    }
}
