//! The status that every function of PCAN-Basic returns, with its meaning and remedy.

use std::fmt;

/// A status. Most bits are independent; [`Status::HANDLE`] is a field with values.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct Status(pub u32);

/// A known status.
struct Known {
    status: Status,
    /// The name in PEAK's header, without `PCAN_ERROR_`.
    name: &'static str,
    meaning: &'static str,
    /// The remedy; empty if canvass itself handles the status.
    remedy: &'static str,
}

const fn known(status: Status, name: &'static str, meaning: &'static str, remedy: &'static str) -> Known {
    Known { status, name, meaning, remedy }
}

const WIRING: &str =
    "check the wiring, the termination and the bit rate, and that another node is there to acknowledge";
const PLUG: &str = "plug it in, and see with canvass doctor which channels there are";
const OURS: &str = "this is a mistake of canvass: please report it with this line";

#[rustfmt::skip]
const KNOWN: [Known; 24] = [
    known(Status::TRANSMIT_BUFFER_FULL, "XMTFULL", "the controller's transmit buffer is full", WIRING),
    known(Status::OVERRUN, "OVERRUN", "the controller was read too late", "close other programs, or use a faster machine or adapter"),
    known(Status::BUS_LIGHT, "BUSLIGHT", "error counters have reached the first limit", WIRING),
    known(Status::BUS_HEAVY, "BUSHEAVY", "error counters have reached the warning limit", WIRING),
    known(Status::BUS_OFF, "BUSOFF", "the controller is bus-off", WIRING),
    known(Status::EMPTY, "QRCVEMPTY", "nothing was received", ""),
    known(Status::QUEUE_OVERRUN, "QOVERRUN", "the receive queue was read too late", "close other programs that keep this machine busy"),
    known(Status::TRANSMIT_QUEUE_FULL, "QXMTFULL", "the transmit queue is full", WIRING),
    known(Status(0x0100), "REGTEST", "the controller does not answer", "unplug the adapter and plug it in again"),
    known(Status::NO_DRIVER, "NODRIVER", "PEAK's driver is not loaded", "install it, or load it: PCAN-Basic only gives access to it"),
    known(Status::IN_USE, "HWINUSE", "another program has the adapter, at another bit rate", "close that program (PCAN-View?), or use its bit rate"),
    known(Status(0x0800), "NETINUSE", "another program is connected to the channel", "close that program (PCAN-View?)"),
    known(Status::NO_HARDWARE, "ILLHW", "there is no such adapter", PLUG),
    known(Status(0x1800), "ILLNET", "there is no such net", PLUG),
    known(Status::HANDLE, "ILLHANDLE", "there is no such channel", PLUG),
    known(Status(0x2000), "RESOURCE", "the driver lacks memory or another resource", "close other programs that use adapters"),
    known(Status::UNKNOWN_PARAMETER, "ILLPARAMTYPE", "the library or the adapter does not know this parameter", "install the current version of PCAN-Basic"),
    known(Status(0x8000), "ILLPARAMVAL", "a parameter has a value that is not allowed", OURS),
    known(Status(0x1_0000), "UNKNOWN", "the driver reports an unknown error", "unplug the adapter and plug it in again"),
    known(Status(0x2_0000), "ILLDATA", "the library refuses the frame or the call", OURS),
    known(Status::BUS_PASSIVE, "BUSPASSIVE", "the controller is error-passive", WIRING),
    known(Status(0x200_0000), "CAUTION", "the function succeeded, but not exactly as requested", "install the current version of PCAN-Basic"),
    known(Status::NOT_INITIALIZED, "INITIALIZE", "the channel is not open, or does not exist", PLUG),
    known(Status(0x800_0000), "ILLOPERATION", "the library does not allow this now", "close other programs that use the adapter"),
];

impl Status {
    /// Success.
    pub const OK: Self = Self(0);
    /// `PCAN_ERROR_XMTFULL`.
    pub(crate) const TRANSMIT_BUFFER_FULL: Self = Self(0x01);
    /// `PCAN_ERROR_OVERRUN`.
    pub(crate) const OVERRUN: Self = Self(0x02);
    /// `PCAN_ERROR_BUSLIGHT`.
    pub(crate) const BUS_LIGHT: Self = Self(0x04);
    /// `PCAN_ERROR_BUSHEAVY`, also `PCAN_ERROR_BUSWARNING`.
    pub(crate) const BUS_HEAVY: Self = Self(0x08);
    /// `PCAN_ERROR_BUSOFF`.
    pub const BUS_OFF: Self = Self(0x10);
    /// `PCAN_ERROR_QRCVEMPTY`.
    pub const EMPTY: Self = Self(0x20);
    /// `PCAN_ERROR_QOVERRUN`.
    pub(crate) const QUEUE_OVERRUN: Self = Self(0x40);
    /// `PCAN_ERROR_QXMTFULL`.
    pub(crate) const TRANSMIT_QUEUE_FULL: Self = Self(0x80);
    /// `PCAN_ERROR_NODRIVER`.
    pub(crate) const NO_DRIVER: Self = Self(0x200);
    /// `PCAN_ERROR_HWINUSE`.
    pub const IN_USE: Self = Self(0x400);
    /// `PCAN_ERROR_ILLHW`.
    pub(crate) const NO_HARDWARE: Self = Self(0x1400);
    /// `PCAN_ERROR_ILLHANDLE`; also the mask of the field in which five other statuses have their values.
    pub const HANDLE: Self = Self(0x1C00);
    /// `PCAN_ERROR_ILLPARAMTYPE`.
    pub(crate) const UNKNOWN_PARAMETER: Self = Self(0x4000);
    /// `PCAN_ERROR_BUSPASSIVE`.
    pub(crate) const BUS_PASSIVE: Self = Self(0x4_0000);
    /// `PCAN_ERROR_INITIALIZE`.
    pub(crate) const NOT_INITIALIZED: Self = Self(0x400_0000);

    /// The bits of both statuses.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether one of the bits is set.
    pub const fn has(self, bits: Self) -> bool {
        self.0 & bits.0 != 0
    }

    /// The status without these bits.
    #[must_use]
    pub const fn without(self, bits: Self) -> Self {
        Self(self.0 & !bits.0)
    }

    /// Whether frames were lost before the program could fetch them.
    pub(crate) const fn has_lost(self) -> bool {
        self.has(Self::OVERRUN.and(Self::QUEUE_OVERRUN))
    }

    /// Whether there is no room for another frame to send.
    pub const fn is_full(self) -> bool {
        self.has(Self::TRANSMIT_BUFFER_FULL.and(Self::TRANSMIT_QUEUE_FULL))
    }

    /// The bits about the bus and the queues: a function that reports only these has succeeded.
    pub const fn news(self) -> Self {
        const NEWS: u32 = 0x4_007E;
        Self(self.0 & NEWS)
    }

    /// The bits other than [`Status::news`]: the reason why a function failed.
    pub const fn failure(self) -> Self {
        self.without(self.news())
    }

    /// The rows of the table for the set bits.
    fn rows(self) -> impl Iterator<Item = &'static Known> {
        let field = self.0 & Self::HANDLE.0;
        let (of_field, alone) = (move |row: &&Known| row.status.0 == field, self.without(Self::HANDLE));
        KNOWN.iter().filter(move |row| (field != 0 && of_field(row)) || alone.has(row.status.without(Self::HANDLE)))
    }
}

/// The name and meaning of each row, and the first remedy.
impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::OK {
            return f.write_str("no error");
        }
        let said: Vec<String> = self.rows().map(|row| format!("{} (PCAN_ERROR_{})", row.meaning, row.name)).collect();
        match said.is_empty() {
            true => write!(f, "status {:X}h, which PCAN-Basic does not document", self.0)?,
            false => f.write_str(&said.join(", "))?,
        }
        match self.rows().map(|row| row.remedy).find(|remedy| !remedy.is_empty()) {
            Some(remedy) => write!(f, ": {remedy}"),
            None => Ok(()),
        }
    }
}

impl fmt::Debug for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Status({:X}h)", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_says_what_it_is_and_what_to_do() {
        for row in &KNOWN {
            let text = row.status.to_string();
            assert!(text.contains(row.meaning) && text.contains(&format!("PCAN_ERROR_{}", row.name)), "{text}");
            assert!(text.ends_with(row.remedy), "{text}");
            assert_eq!(row.status.rows().count(), 1, "{text}");
            assert!(!row.remedy.is_empty() || row.status == Status::EMPTY, "{text}");
        }
    }

    #[test]
    fn several_at_once_are_all_told_and_handles_are_told_apart() {
        let text = Status::BUS_HEAVY.and(Status::QUEUE_OVERRUN).to_string();
        assert!(text.contains("BUSHEAVY") && text.contains("QOVERRUN"), "{text}");
        // The bits of this status are those of "in use" and of another status.
        let text = Status::NO_HARDWARE.to_string();
        assert!(text.contains("ILLHW") && !text.contains("HWINUSE"), "{text}");
        assert_eq!(Status(0x4000_0000).to_string(), "status 40000000h, which PCAN-Basic does not document");
        assert_eq!(Status::OK.to_string(), "no error");
    }

    #[test]
    fn news_are_no_failures() {
        let news = Status::BUS_OFF.and(Status::QUEUE_OVERRUN).and(Status::BUS_PASSIVE).and(Status::EMPTY);
        assert_eq!((news.failure(), news.has_lost(), news.is_full()), (Status::OK, true, false));
        assert_eq!(news.and(Status::NO_HARDWARE).failure(), Status::NO_HARDWARE);
        assert_eq!(Status::TRANSMIT_QUEUE_FULL.failure(), Status::TRANSMIT_QUEUE_FULL);
    }
}
