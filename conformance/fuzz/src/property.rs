//! Properties that hold for every device, whatever is sent to it.

use super::profile;
use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

/// Defines the properties: one row each, so that id, title and text can't drift apart.
macro_rules! properties {
    ($($(#[doc = $doc:literal])+ $variant:ident = $id:literal $title:literal,)*) => {
        /// A property that the fuzzer checks after every frame.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum Property {
            $($(#[doc = $doc])+ $variant,)*
            /// A property of a device profile.
            OfProfile(&'static ProfileProperty),
        }

        impl Property {
            /// The properties of every device.
            const OF_EVERY_DEVICE: &'static [Self] = &[$(Self::$variant),*];

            /// The stable id.
            pub const fn id(self) -> &'static str {
                match self { $(Self::$variant => $id,)* Self::OfProfile(property) => property.id }
            }

            /// The title in one line.
            pub const fn title(self) -> &'static str {
                match self { $(Self::$variant => $title,)* Self::OfProfile(property) => property.title }
            }

            /// The requirement, its reason, and how it is judged.
            pub const fn explanation(self) -> &'static str {
                match self {
                    $(Self::$variant => concat!($($doc, "\n"),+),)*
                    Self::OfProfile(property) => property.explanation,
                }
            }
        }
    };
}

properties! {
    /// After any input on the device's CAN-IDs, reading 1000h:00 succeeds within the response time. A server that stops
    /// answering because of a client stops a machine. Every sequence of the fuzzer ends with this read.
    Responsive = "PROP-01" "the SDO server keeps answering",
    /// Every frame of the SDO server is allowed in the current state of the transfer: it has the right command
    /// specifier, toggle bit, sequence number, multiplexer, length, reserved bits and abort code. A missing answer
    /// violates the property just like a wrong answer.
    LegalSdo = "PROP-02" "every SDO response is legal in its state",
    /// The server sends one frame for each frame of the client; in a block upload at most as many segments as the
    /// client's block size allows.
    OneAnswer = "PROP-03" "one answer for each request",
    /// The SDO server does not answer an abort of the client, a remote frame, a frame with a 29-bit identifier, or any
    /// frame in the NMT states stopped and initialisation.
    Silent = "PROP-04" "no answer where silence is required",
    /// A transfer that ends in an abort does not change the object.
    AbortedUnchanged = "PROP-05" "an aborted transfer changes nothing",
    /// An upload after a confirmed download returns the written value, with each of the three transfer types
    /// (expedited, segmented, block) and any segmentation.
    ReadBack = "PROP-06" "a written value is read back",
    /// The same request in the same state gets the same kind of answer. Every object of the description exists, and
    /// constants do not change.
    Consistent = "PROP-07" "the device agrees with its description and with itself",
    /// Heartbeats and guarding answers show the NMT state that follows from the NMT commands, and heartbeats come in
    /// time.
    NmtState = "PROP-08" "the NMT state follows the commands",
    /// The device sends PDOs only with their configured CAN-IDs, only in operational, with the length of their mapping,
    /// and not faster than their inhibit time and event timer allow. The device refuses configurations that CiA 301
    /// forbids: a new CAN-ID for a valid PDO, restricted CAN-IDs, reserved transmission types, changes of an enabled
    /// mapping, and mappings of more than 64 bits.
    Pdo = "PROP-09" "PDOs as configured",
    /// The LSS slave answers exactly as CiA 305 demands in its state, even if requests are interleaved with other
    /// frames.
    LegalLss = "PROP-10" "every LSS response is legal in its state",
    /// Fastscan identifies a slave, and switches it to configuration, only after all 128 bits of its address have
    /// matched.
    Fastscan = "PROP-11" "Fastscan compares every bit",
    /// The device sends few EMCY messages for any input, and reports each error once.
    EmcyRate = "PROP-12" "no storm of EMCY messages",
    /// The device sends no boot-up message without a reset: it does not restart by itself.
    NoRestart = "PROP-13" "no restart by itself",
    /// After a reset every object that was not stored has its power-on value again, so that a sequence has no lasting
    /// effect. Reset node restores all objects, reset communication those from 1000h to 1FFFh.
    Restored = "PROP-14" "a reset brings the values back",
    /// The device sends SYNC and TIME only as their producer (bit 30 of 1005h and of 1012h), and EMCY only while 1014h is
    /// valid.
    Produced = "PROP-17" "SYNC, TIME and EMCY as configured",
    /// The first reset after every sequence restarts the device, with a boot-up message if the device sends one. A
    /// device that needs another reset or a power cycle has stopped working.
    Alive = "PROP-16" "a reset brings the device back",
}

/// A property that a device profile demands of its devices.
#[derive(PartialEq, Eq, Hash, Debug)]
pub struct ProfileProperty {
    /// The stable id.
    pub id: &'static str,
    /// The title in one line.
    pub title: &'static str,
    /// The requirement, its reason, and how it is judged.
    pub explanation: &'static str,
}

impl Property {
    /// All properties, by id.
    pub fn all() -> impl Iterator<Item = Self> {
        static ALL: LazyLock<Vec<Property>> = LazyLock::new(|| {
            let of_profiles = profile::all().iter().flat_map(|profile| profile.properties());
            let of_profiles = of_profiles.map(|property| Property::OfProfile(property));
            let mut all: Vec<_> = Property::OF_EVERY_DEVICE.iter().copied().chain(of_profiles).collect();
            all.sort_unstable();
            all
        });
        ALL.iter().copied()
    }
}

/// Properties are sorted by id.
impl Ord for Property {
    fn cmp(&self, other: &Self) -> Ordering {
        self.id().cmp(other.id())
    }
}

impl PartialOrd for Property {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// No property has this id.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no property is called \"{0}\": `canvass list properties` names them")]
pub struct UnknownProperty(pub String);

impl FromStr for Property {
    type Err = UnknownProperty;

    fn from_str(id: &str) -> Result<Self, UnknownProperty> {
        let found = Self::all().find(|property| property.id().eq_ignore_ascii_case(id));
        found.ok_or_else(|| UnknownProperty(id.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_numbered_and_found() {
        for (n, property) in Property::all().enumerate() {
            assert_eq!(property.id(), format!("PROP-{:02}", n + 1));
            assert_eq!(property.id().to_lowercase().parse(), Ok(property));
            assert!(!property.explanation().trim().is_empty());
        }
        assert!("PROP-18".parse::<Property>().is_err());
    }
}
