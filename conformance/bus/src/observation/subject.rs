//! The subject of an observation.

use canvass_analyzer::{Index, Multiplexer, Service, SubIndex};
use std::fmt;
use std::str::FromStr;

/// The part of a device that an observation concerns.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Subject {
    /// The device as a whole: its NMT state, its presence.
    Device,
    /// One entry of the object dictionary.
    Entry(Multiplexer),
    /// An object with all its entries.
    Object(Index),
    /// A service: its messages and their times.
    Service(Service),
    /// A PDO, by its number from 1.
    Pdo {
        /// `true` for a TPDO, `false` for an RPDO.
        transmit: bool,
        /// The number, from 1.
        number: u16,
    },
    /// An identifier on the bus.
    CanId(u32),
    /// The file that describes the device.
    Description,
}

/// The error for a text that names no subject.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "expected an object such as \"1016\" or \"1016:01\", a service such as \"heartbeat\" or \"lss\", \"TPDO 1\", \
     \"RPDO 1\", \"CAN-ID 181\", \"device\" or \"description\", found \"{0}\""
)]
pub struct BadSubject(pub String);

impl Subject {
    /// Whether a statement about this subject also holds for `other`: an object includes its entries.
    pub fn covers(self, other: Self) -> bool {
        match (self, other) {
            (Self::Object(index), Self::Entry(entry)) => entry.index == index,
            _ => self == other,
        }
    }
}

impl From<Multiplexer> for Subject {
    fn from(multiplexer: Multiplexer) -> Self {
        Self::Entry(multiplexer)
    }
}

impl From<Service> for Subject {
    fn from(service: Service) -> Self {
        Self::Service(service)
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device => f.write_str("device"),
            Self::Entry(multiplexer) => write!(f, "{multiplexer}"),
            Self::Object(index) => write!(f, "{:04X}h", index.0),
            Self::Service(service) => f.write_str(service.name()),
            Self::Pdo { transmit: true, number } => write!(f, "TPDO {number}"),
            Self::Pdo { transmit: false, number } => write!(f, "RPDO {number}"),
            Self::CanId(id) => write!(f, "CAN-ID {id:03X}"),
            Self::Description => f.write_str("description"),
        }
    }
}

impl FromStr for Subject {
    type Err = BadSubject;

    fn from_str(text: &str) -> Result<Self, BadSubject> {
        let bad = || BadSubject(text.to_owned());
        let words = text.trim();
        let after = |prefix: &str| words.strip_prefix(prefix).map(str::trim);
        if let Some(number) = after("TPDO") {
            return number.parse().map(|number| Self::Pdo { transmit: true, number }).map_err(|_| bad());
        }
        if let Some(number) = after("RPDO") {
            return number.parse().map(|number| Self::Pdo { transmit: false, number }).map_err(|_| bad());
        }
        if let Some(id) = after("CAN-ID") {
            return u32::from_str_radix(id.trim_end_matches(['h', 'H']), 16).map(Self::CanId).map_err(|_| bad());
        }
        match words {
            "device" => return Ok(Self::Device),
            "description" => return Ok(Self::Description),
            _ => {}
        }
        if let Some(service) = Service::ALL.into_iter().find(|service| service.name() == words) {
            return Ok(Self::Service(service));
        }
        object(words).ok_or_else(bad)
    }
}

/// Parses `1016`, `1016h` or `1016:*` (all entries), or `1016:01` or `1016h:01` (one entry).
fn object(text: &str) -> Option<Subject> {
    let (index, sub) = text.split_once(':').map_or((text, None), |(index, sub)| (index, Some(sub)));
    let index = index.trim_end_matches(['h', 'H']);
    let index = (index.len() == 4).then(|| u16::from_str_radix(index, 16).ok()).flatten().map(Index)?;
    match sub {
        None | Some("*") => Some(Subject::Object(index)),
        Some(sub) => {
            let sub = u8::from_str_radix(sub.trim_end_matches(['h', 'H']), 16).ok().map(SubIndex)?;
            Some(Subject::Entry(Multiplexer { index, sub }))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;

    #[test]
    fn subjects_are_read_as_they_are_written() {
        for text in ["device", "description", "1016h:01", "1016h", "heartbeat", "TPDO 2", "RPDO 1", "CAN-ID 181"] {
            assert_eq!(text.parse::<Subject>().unwrap().to_string(), text);
        }
        assert_eq!("1016:01".parse::<Subject>(), Ok(Multiplexer::new(object::CONSUMER_HEARTBEAT_TIME, 1).into()));
        for text in ["", "name", "12", "TPDO", "TPDO x", "1016:", "1016:001"] {
            assert!(text.parse::<Subject>().is_err() || text == "1016:001", "{text}");
        }
    }

    #[test]
    fn an_object_covers_its_entries_and_no_others() {
        let [object, entry, other] = ["1016", "1016:01", "1017:00"].map(|text| text.parse::<Subject>().unwrap());
        assert!(object.covers(entry) && entry.covers(entry) && !entry.covers(object) && !object.covers(other));
    }
}
