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

            /// What is demanded, why, and how it is judged.
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
    /// After any input on the device's CAN-IDs, reading 1000h:00 succeeds within the response time. A server that
    /// a client can wedge stops a machine. Every sequence of the fuzzer ends with this read.
    Responsive = "PROP-01" "the SDO server can't be wedged",
    /// Every frame of the SDO server is one that a server may send in the state that the dialogue has reached: the
    /// right command specifier, toggle bit, sequence number, multiplexer, length, reserved bits, abort code. An
    /// answer that is due and does not come is as much a violation as one that is wrong.
    LegalSdo = "PROP-02" "every SDO response is legal in its state",
    /// The server sends one frame for each frame of the client; in a block upload at most as many segments as the
    /// client's block size allows.
    OneAnswer = "PROP-03" "one answer for each request",
    /// An abort of the client, a remote frame, a frame with a 29-bit identifier, and whatever comes in the NMT state
    /// stopped or during initialisation is not answered.
    Silent = "PROP-04" "no answer where none is due",
    /// A transfer that ends in an abort leaves the object as it was.
    AbortedUnchanged = "PROP-05" "an aborted transfer changes nothing",
    /// What was written and confirmed is what is read next, by any of the three kinds of transfer and in any
    /// segmentation.
    ReadBack = "PROP-06" "what was written is read back",
    /// The same request in the same state gets the same kind of answer; an object that the description promises
    /// exists, and constants are constant.
    Consistent = "PROP-07" "the device agrees with its description and with itself",
    /// The NMT state that heartbeats and guarding show is the one that the commands lead to; heartbeats come in time.
    NmtState = "PROP-08" "the NMT state follows the commands",
    /// PDOs, SYNC and TIME are sent only on identifiers that the device was told to use, only in operational, with
    /// the length of their mapping, and not faster than their inhibit time and event timer allow. Configurations that
    /// CiA 301 forbids are refused: identifiers change only while the PDO is invalid, restricted identifiers and
    /// reserved transmission types don't exist, mappings change only while they are disabled and hold 64 bits at most.
    Pdo = "PROP-09" "PDOs as configured",
    /// The LSS slave answers exactly as CiA 305 demands in its state, whatever is interleaved.
    LegalLss = "PROP-10" "every LSS response is legal in its state",
    /// Fastscan identifies, and switches to configuration, only after all 128 bits of the address have matched.
    Fastscan = "PROP-11" "Fastscan compares every bit",
    /// Whatever comes in, EMCY messages stay few, and each error is reported once.
    EmcyRate = "PROP-12" "no storm of EMCY messages",
    /// No boot-up message without a reset: the device did not restart by itself.
    NoRestart = "PROP-13" "no restart by itself",
    /// After a reset every object that was not stored has the value of power-on again: what a sequence wrote leaves no
    /// trace. Reset node brings all back, reset communication 1000h to 1FFFh.
    Restored = "PROP-14" "a reset brings the values back",
    /// The device lives: after every sequence the first reset brings it back, with its boot-up message where it has one.
    /// What needs a further reset, or the power switched off and on, had stopped.
    Alive = "PROP-16" "a reset brings the device back",
}

/// A property that a device profile demands of its devices.
#[derive(PartialEq, Eq, Hash, Debug)]
pub struct ProfileProperty {
    /// The stable id.
    pub id: &'static str,
    /// The title in one line.
    pub title: &'static str,
    /// What is demanded, why, and how it is judged.
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
        assert!("PROP-17".parse::<Property>().is_err());
    }
}
