//! The addresses of buses over a network.

use std::fmt;
use std::net::{IpAddr, SocketAddr};

/// The address of a bus over a network.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NetworkAddress {
    pub carrier: Carrier,
    /// The bit rate of the bus at the other end in bit/s, if the address gives it: the protocols do not tell it.
    pub bit_rate: Option<u32>,
}

/// How frames come over the network.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Carrier {
    /// An interface such as `can0` of a machine with socketcand: `HOST:PORT`.
    Socketcand { server: String, interface: String },
    /// cannelloni as a server: `HOST:PORT`.
    CannelloniTcp { server: String },
    /// cannelloni by datagrams: `HOST:PORT`, and the port of this computer.
    CannelloniUdp { remote: String, local: u16 },
    /// python-can's `udp_multicast`.
    Multicast { group: SocketAddr },
}

/// The ports that the programs use by default.
const SOCKETCAND: u16 = 29536;
const CANNELLONI: u16 = 20000;
const MULTICAST: u16 = 43113;

impl Carrier {
    /// Parses `HOST[:PORT]/INTERFACE`.
    ///
    /// # Errors
    /// The expected form.
    pub fn socketcand(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').filter(|(host, interface)| !host.is_empty() && !interface.is_empty());
        let (host, interface) = parts
            .ok_or_else(|| format!("expected socketcand://HOST[:PORT]/INTERFACE, found \"socketcand://{text}\""))?;
        // 15 characters are the limit of Linux; others would end the command to the server.
        if interface.len() > 15 || !interface.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c)) {
            return Err(format!("expected the name of a CAN interface, such as can0, found \"{interface}\""));
        }
        Ok(Self::Socketcand { server: with_port(host, SOCKETCAND)?, interface: interface.to_owned() })
    }

    /// Parses `tcp://HOST[:PORT]` or `udp://HOST[:PORT][+LOCALPORT]`.
    ///
    /// # Errors
    /// The expected form.
    pub fn cannelloni(text: &str) -> Result<Self, String> {
        if let Some(server) = text.strip_prefix("tcp://") {
            return Ok(Self::CannelloniTcp { server: with_port(server, CANNELLONI)? });
        }
        let Some(rest) = text.strip_prefix("udp://") else {
            return Err(format!(
                "expected cannelloni:tcp://HOST[:PORT] or cannelloni:udp://HOST[:PORT][+LOCALPORT], found \
                 \"cannelloni:{text}\""
            ));
        };
        let (host, local) = match rest.split_once('+') {
            Some((host, port)) => (host, Some(port.parse().map_err(|_| format!("expected a port, found \"{port}\""))?)),
            None => (rest, None),
        };
        let remote = with_port(host, CANNELLONI)?;
        // Both ends use one port by default.
        let same = remote.rsplit_once(':').and_then(|(_, port)| port.parse().ok());
        Ok(Self::CannelloniUdp { local: local.or(same).unwrap_or(CANNELLONI), remote })
    }

    /// Parses `GROUP[:PORT]`: an IP address for groups; one of version 6 with a port is in square brackets.
    ///
    /// # Errors
    /// The expected form.
    pub fn multicast(text: &str) -> Result<Self, String> {
        let alone = text.trim_matches(['[', ']']).parse::<IpAddr>().map(|ip| SocketAddr::new(ip, MULTICAST));
        let group = alone.or_else(|_| text.parse::<SocketAddr>()).ok().filter(|group| group.ip().is_multicast());
        group.map(|group| Self::Multicast { group }).ok_or_else(|| {
            format!("expected udp://GROUP[:PORT] with an IP address for groups, such as 239.74.163.2, found \"udp://{text}\"")
        })
    }
}

/// `HOST:PORT`, with a default port.
fn with_port(text: &str, default: u16) -> Result<String, String> {
    // The colons of an address of version 6 are in square brackets.
    let behind = text.rsplit_once(']').map_or(text, |(_, behind)| behind);
    let host_is_empty = text.is_empty() || text.starts_with(':');
    match behind.rsplit_once(':') {
        _ if host_is_empty => Err("expected the name or address of a machine".to_owned()),
        Some((_, port)) if port.parse::<u16>().is_ok() => Ok(text.to_owned()),
        Some((_, port)) => Err(format!("expected a port from 1 to 65535, found \"{port}\"")),
        None => Ok(format!("{text}:{default}")),
    }
}

/// As it is typed on the command line, without the bit rate.
impl fmt::Display for NetworkAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.carrier {
            Carrier::Socketcand { server, interface } => write!(f, "socketcand://{server}/{interface}"),
            Carrier::CannelloniTcp { server } => write!(f, "cannelloni:tcp://{server}"),
            Carrier::CannelloniUdp { remote, .. } => write!(f, "cannelloni:udp://{remote}"),
            Carrier::Multicast { group } => write!(f, "udp://{group}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_and_its_defaults() {
        let told = |carrier: Carrier| NetworkAddress { carrier, bit_rate: None }.to_string();
        assert_eq!(told(Carrier::socketcand("pi.local/can0").unwrap()), "socketcand://pi.local:29536/can0");
        assert_eq!(told(Carrier::socketcand("10.0.0.2:4000/vcan1").unwrap()), "socketcand://10.0.0.2:4000/vcan1");
        assert_eq!(told(Carrier::cannelloni("tcp://[::1]").unwrap()), "cannelloni:tcp://[::1]:20000");
        assert_eq!(
            Carrier::cannelloni("udp://pi:20001").unwrap(),
            Carrier::CannelloniUdp { remote: "pi:20001".to_owned(), local: 20001 }
        );
        assert_eq!(
            Carrier::cannelloni("udp://pi:20001+20002").unwrap(),
            Carrier::CannelloniUdp { remote: "pi:20001".to_owned(), local: 20002 }
        );
        assert_eq!(told(Carrier::multicast("239.74.163.2").unwrap()), "udp://239.74.163.2:43113");
        assert_eq!(told(Carrier::multicast("[ff15::1]:5000").unwrap()), "udp://[ff15::1]:5000");
        assert_eq!(told(Carrier::multicast("ff15::1").unwrap()), "udp://[ff15::1]:43113");
    }

    #[test]
    fn what_is_no_address_says_what_was_expected() {
        let expected = |parsed: Result<Carrier, String>, text: &str| {
            let reason = parsed.unwrap_err();
            assert!(reason.contains(text), "{reason}");
        };
        expected(Carrier::socketcand("pi"), "/INTERFACE");
        expected(Carrier::socketcand("pi/can0 > < add"), "CAN interface");
        expected(Carrier::socketcand("pi:99999/can0"), "a port");
        expected(Carrier::cannelloni("pi"), "cannelloni:tcp://");
        expected(Carrier::cannelloni("udp://pi+x"), "a port");
        expected(Carrier::cannelloni("tcp://"), "name or address");
        expected(Carrier::multicast("10.0.0.1"), "for groups");
    }
}
