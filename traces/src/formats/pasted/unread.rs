//! Texts and files that people have and that hold no readable frames, so that the message can say what is missing.

use crate::lines::head_lines;

/// Why a source of a known kind is not read.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Unread {
    /// A measurement file of ASAM.
    #[error("is an ASAM MDF file of a version before 4, which is not read: export it as MF4, Vector ASC or BLF")]
    Mdf,
    /// Lines of a packet list: identifiers without data.
    #[error(
        "shows identifiers but no data bytes: expected lines with the data, such as those of `candump`, or the capture \
         itself (pcapng)"
    )]
    NoBytes,
}

/// The known kind of a source that no format fits.
pub(crate) fn unread(head: &[u8]) -> Option<Unread> {
    if head.starts_with(b"MDF     ") || head.starts_with(b"UnFinMF ") {
        return Some(Unread::Mdf);
    }
    let is_packet = |line: &[u8]| {
        let has = |text: &[u8]| line.windows(text.len()).any(|window| window == text);
        has(b"(0x") && (has(b" CANopen ") || has(b" CAN ")) || has(b" CAN ") && has(b"ID: ") && !has(b"DLC")
    };
    head_lines(head).take(100).any(|(line, _)| is_packet(line)).then_some(Unread::NoBytes)
}
