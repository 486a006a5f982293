//! The channels of PCAN-Basic: PEAK's names for them, and their handles.

use std::fmt;
use std::str::FromStr;

/// A channel, by its handle in PCAN-Basic.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Channel(u16);

/// A kind of channels, numbered from 1. From the ninth on, their handles have another form.
struct Kind {
    /// The part of the name between `PCAN_` and the number.
    name: &'static str,
    /// The handle of channel n is this number plus n, for n from 1 to 8.
    first: u16,
    /// The handle of channel n is this number plus n, for n from 9 on.
    further: u16,
    /// Number of channels of this kind.
    count: u16,
}

/// The beginning of every channel's name.
const PREFIX: &str = "PCAN_";
const KINDS: [Kind; 6] = [
    Kind { name: "USBBUS", first: 0x50, further: 0x500, count: 16 },
    Kind { name: "PCIBUS", first: 0x40, further: 0x400, count: 16 },
    Kind { name: "LANBUS", first: 0x800, further: 0x800, count: 16 },
    Kind { name: "PCCBUS", first: 0x60, further: 0x60, count: 2 },
    Kind { name: "ISABUS", first: 0x20, further: 0x20, count: 8 },
    Kind { name: "DNGBUS", first: 0x30, further: 0x30, count: 1 },
];

/// Number of channels whose handles have the first form.
const SHORT: u16 = 8;

impl Kind {
    fn channel(&self, number: u16) -> Option<Channel> {
        let base = if number > SHORT { self.further } else { self.first };
        (1..=self.count).contains(&number).then_some(Channel(base + number))
    }

    fn channels(&self) -> impl Iterator<Item = (u16, Channel)> {
        (1..=self.count).filter_map(|number| Some((number, self.channel(number)?)))
    }
}

impl Channel {
    /// No channel: stands for the library itself when its parameters are read.
    #[cfg(any(windows, target_os = "linux"))]
    pub(super) const NONE: Self = Self(0);

    /// All channels with a name, in the order of PEAK's own lists: USB first.
    pub fn all() -> impl Iterator<Item = Self> {
        KINDS.iter().flat_map(Kind::channels).map(|(_, channel)| channel)
    }

    pub const fn handle(self) -> u16 {
        self.0
    }
}

/// The name of the channel: `PCAN_USBBUS1`.
impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbered = |kind: &'static Kind| kind.channels().map(move |(number, channel)| (kind, number, channel));
        match KINDS.iter().flat_map(numbered).find(|(_, _, channel)| channel == self) {
            Some((kind, number, _)) => write!(f, "{PREFIX}{}{number}", kind.name),
            None => write!(f, "PCAN channel {:X}h", self.0),
        }
    }
}

/// Parses a name in any case, with or without `PCAN_`.
impl FromStr for Channel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let upper = text.to_ascii_uppercase();
        let name = upper.strip_prefix(PREFIX).unwrap_or(&upper);
        let named = |kind: &Kind| {
            let digits = name.strip_prefix(kind.name)?;
            // The number in a name has no sign and no leading zero.
            let is_number = digits.bytes().all(|digit| digit.is_ascii_digit()) && !digits.starts_with('0');
            is_number.then(|| digits.parse().ok()).flatten().and_then(|number| kind.channel(number))
        };
        KINDS.iter().find_map(named).ok_or_else(|| {
            format!(
                "expected a channel of PCAN-Basic, such as PCAN_USBBUS1, found \"{text}\" (canvass doctor lists them)"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_the_handles_of_the_interface() {
        let known = [
            ("PCAN_USBBUS1", 0x51),
            ("PCAN_USBBUS8", 0x58),
            ("PCAN_USBBUS9", 0x509),
            ("PCAN_USBBUS16", 0x510),
            ("PCAN_PCIBUS1", 0x41),
            ("PCAN_PCIBUS9", 0x409),
            ("PCAN_LANBUS1", 0x801),
            ("PCAN_LANBUS9", 0x809),
            ("PCAN_PCCBUS2", 0x62),
            ("PCAN_ISABUS8", 0x28),
            ("PCAN_DNGBUS1", 0x31),
        ];
        for (name, handle) in known {
            assert_eq!(name.parse(), Ok(Channel(handle)));
            assert_eq!(Channel(handle).to_string(), name);
        }
        assert_eq!("usbbus1".parse(), "pcan_USBBUS1".parse::<Channel>());
    }

    #[test]
    fn every_channel_is_read_as_it_is_written() {
        let mut handles: Vec<u16> = Channel::all().map(Channel::handle).collect();
        assert!(Channel::all().all(|channel| channel.to_string().parse() == Ok(channel)));
        handles.sort_unstable();
        handles.dedup();
        assert_eq!(handles.len(), 16 * 3 + 2 + 8 + 1);
        for wrong in ["", "PCAN_", "PCAN_USBBUS", "PCAN_USBBUS0", "PCAN_USBBUS17", "PCAN_USBBUS+1", "USBBUS01", "COM3"]
        {
            assert!(wrong.parse::<Channel>().is_err_and(|error| error.contains("PCAN_USBBUS1")), "{wrong}");
        }
    }
}
