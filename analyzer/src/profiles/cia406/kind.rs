//! The kind of an encoder.

/// The motion of an encoder's shaft or rod, by the upper word of 1000h.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// Types 01h to 05h of CiA 406, and 0Bh of newer devices.
    Rotary,
    /// Types 08h and 09h.
    Linear,
}

impl Kind {
    /// The kind by the device type (1000h); `None` for any other type.
    pub const fn of(device_type: u32) -> Option<Self> {
        match device_type >> 16 {
            0x01..=0x05 | 0x0B => Some(Self::Rotary),
            0x08 | 0x09 => Some(Self::Linear),
            _ => None,
        }
    }
}

/// The name of the type of encoder in the high word of 1000h.
pub(super) const fn name(high_word: u16) -> Option<&'static str> {
    Some(match high_word {
        0x01 => "single-turn absolute rotary encoder",
        0x02 => "multi-turn absolute rotary encoder",
        0x08 => "absolute linear encoder",
        0x09 => "absolute linear encoder with cyclic coding",
        _ => return None,
    })
}
