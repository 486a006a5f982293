//! The connection to an adapter or program: a serial port, TCP in either direction, or UDP.

use std::io::{self, Read, Write};
#[cfg(not(target_family = "wasm"))]
use std::net::UdpSocket;
use std::net::{Ipv4Addr, TcpListener, TcpStream, ToSocketAddrs};
use std::time::Duration;

/// The place of an adapter.
#[derive(Debug)]
pub enum Place {
    /// The path of a serial port.
    Serial(String),
    /// TCP: `host:port`.
    Tcp(String),
}

/// The two directions of an open connection.
pub struct Link {
    pub reader: Box<dyn Read + Send>,
    pub writer: Box<dyn Write + Send>,
}

/// Maximum wait of a read, after which the thread checks whether it must end.
pub const LOOK: Duration = Duration::from_millis(20);
const CONNECT: Duration = Duration::from_secs(3);
const WRITE: Duration = Duration::from_secs(2);
/// Maximum wait for one of several programs to take a frame. All others wait meanwhile. A program has come to this only
/// when it has left hundreds of kilobytes unread.
const SHARED_WRITE: Duration = Duration::from_millis(100);
/// The usual baud rate of adapters with a real UART; USB adapters ignore it.
#[cfg(all(feature = "serial", not(target_family = "wasm")))]
const BAUD: u32 = 115_200;

impl Place {
    /// Parses the address after `slcan:`.
    pub fn parse(text: &str) -> Self {
        match text.strip_prefix("tcp://") {
            Some(address) => Self::Tcp(address.to_owned()),
            None => Self::Serial(text.to_owned()),
        }
    }

    /// Opens the connection.
    pub fn open(&self) -> io::Result<Link> {
        match self {
            Self::Serial(path) => serial(path),
            Self::Tcp(address) => connect(address),
        }
    }
}

/// Opens a TCP connection to `host:port`.
pub fn connect(address: &str) -> io::Result<Link> {
    let mut failure = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => return tcp(stream, WRITE),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// The two directions of UDP sockets: a read is one datagram, and so is a write.
#[cfg(not(target_family = "wasm"))]
pub fn datagrams(reader: UdpSocket, writer: UdpSocket) -> io::Result<Link> {
    reader.set_read_timeout(Some(LOOK))?;
    writer.set_write_timeout(Some(WRITE))?;
    Ok(Link { reader: Box::new(Datagrams(reader)), writer: Box::new(Datagrams(writer)) })
}

#[cfg(not(target_family = "wasm"))]
struct Datagrams(UdpSocket);

#[cfg(not(target_family = "wasm"))]
impl Read for Datagrams {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        // No bytes would mean the end of a stream.
        match self.0.recv(buffer)? {
            0 => Err(io::ErrorKind::Interrupted.into()),
            length => Ok(length),
        }
    }
}

#[cfg(not(target_family = "wasm"))]
impl Write for Datagrams {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.send(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Listens at `host:port`, or at `port` for programs on this machine. A program controls the bus without a password, so
/// other machines can connect only if the address names a host.
pub fn listen(address: &str) -> io::Result<TcpListener> {
    let listener = match address.strip_prefix(':').unwrap_or(address).parse::<u16>() {
        Ok(port) => TcpListener::bind((Ipv4Addr::LOCALHOST, port))?,
        Err(_) => TcpListener::bind(address)?,
    };
    listener.set_nonblocking(true)?;
    Ok(listener)
}

/// The next connection; `None` if no program has connected.
pub fn accept(listener: &TcpListener) -> io::Result<Option<Link>> {
    match listener.accept() {
        Ok((stream, _)) => {
            stream.set_nonblocking(false)?;
            tcp(stream, SHARED_WRITE).map(Some)
        }
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
        Err(error) => Err(error),
    }
}

fn tcp(stream: TcpStream, write: Duration) -> io::Result<Link> {
    // A frame must not wait for the next one, as with Nagle's algorithm.
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(LOOK))?;
    stream.set_write_timeout(Some(write))?;
    Ok(Link { reader: Box::new(stream.try_clone()?), writer: Box::new(stream) })
}

#[cfg(all(feature = "serial", not(target_family = "wasm")))]
fn serial(path: &str) -> io::Result<Link> {
    let port = serialport::new(path, BAUD).timeout(LOOK).open()?;
    let writer = port.try_clone()?;
    #[cfg(windows)]
    let port = Asked(port);
    Ok(Link { reader: Box::new(port), writer: Box::new(writer) })
}

/// A serial port of Windows. Reading and writing use one handle, so a write would wait for a read in progress. So a
/// read begins only after the port reports bytes.
#[cfg(all(feature = "serial", windows))]
struct Asked(Box<dyn serialport::SerialPort>);

#[cfg(all(feature = "serial", windows))]
impl Read for Asked {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        const PAUSE: Duration = Duration::from_millis(1);
        let begun = std::time::Instant::now();
        while self.0.bytes_to_read()? == 0 {
            if begun.elapsed() >= LOOK {
                return Err(io::ErrorKind::TimedOut.into());
            }
            std::thread::sleep(PAUSE);
        }
        self.0.read(buffer)
    }
}

/// The names of the serial ports.
#[cfg(windows)]
pub fn ports() -> Vec<String> {
    #[cfg(feature = "serial")]
    let found = serialport::available_ports().unwrap_or_default().into_iter().map(|port| port.port_name);
    #[cfg(not(feature = "serial"))]
    let found = std::iter::empty();
    let mut names: Vec<String> = found.collect();
    // This order puts COM10 after COM9.
    names.sort_by_key(|name| (name.len(), name.clone()));
    names
}

#[cfg(not(all(feature = "serial", not(target_family = "wasm"))))]
fn serial(_: &str) -> io::Result<Link> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "this build has no serial ports (feature serial)"))
}

/// Whether the error only means that a read timed out.
pub fn is_silence(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_listener_without_a_host_is_reached_from_this_machine_only() {
        let bound = |address: &str| listen(address).unwrap().local_addr().unwrap().ip();
        assert!(bound("0").is_loopback() && bound(":0").is_loopback());
        assert!(bound("0.0.0.0:0").is_unspecified(), "where a host is named, that one");
    }
}
