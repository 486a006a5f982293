//! SLCAN adapters behind TCP that misbehave as no real adapter or device does. `cargo xtask attack` uses them, too.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

/// The behaviour of an adapter once its channel is open.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rogue {
    /// Sends nothing, not even answers to commands.
    Silent,
    /// Sends bytes that are no lines of the protocol.
    Garbage,
    /// Sends only the first half of each line.
    HalfLines,
    /// Sends frames of node 5 as fast as possible.
    Flood,
    /// Simulates a node that boots, and answers each SDO request with rubbish.
    Nonsense,
    /// Simulates a node that boots, and answers each upload with empty segments without end.
    Endless,
    /// Simulates a node that boots, announces 4 GiB for each object, and sends them as long as the client asks.
    Huge,
    /// Closes the connection in the middle of a frame, each time.
    Closing,
}

impl Rogue {
    /// All behaviours.
    pub const ALL: [Self; 8] = [
        Self::Silent,
        Self::Garbage,
        Self::HalfLines,
        Self::Flood,
        Self::Nonsense,
        Self::Endless,
        Self::Huge,
        Self::Closing,
    ];

    /// Starts an adapter that serves every connection as long as this process lives.
    pub fn start(self) -> std::io::Result<SocketAddr> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let address = listener.local_addr()?;
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                // The adapter begins anew with the next client.
                let _ = self.serve(stream);
            }
        });
        Ok(address)
    }

    fn serve(self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_read_timeout(Some(Duration::from_millis(1)))?;
        stream.set_write_timeout(Some(Duration::from_millis(500)))?;
        let (mut line, mut bytes) = (Vec::new(), [0; 4096]);
        loop {
            match stream.read(&mut bytes) {
                Ok(0) => return Ok(()),
                Ok(read) => {
                    for &byte in &bytes[..read] {
                        if byte == b'\r' {
                            self.answer(&mut stream, &std::mem::take(&mut line))?;
                        } else {
                            line.push(byte);
                        }
                    }
                }
                Err(error) if is_silence(&error) => {}
                Err(error) => return Err(error),
            }
            match self {
                Self::Garbage => stream.write_all(&[0xFF, b't', 0, b'\r', b'T', b'Z', 7, 0x1B, b'[', b'2', b'J'])?,
                Self::HalfLines => stream.write_all(b"t70510")?,
                Self::Flood => (0..200).try_for_each(|_| stream.write_all(b"t7051052341\rt18580102030405060708\r"))?,
                Self::Closing => {
                    stream.write_all(b"t58584300")?;
                    return Ok(());
                }
                Self::Silent | Self::Nonsense | Self::Endless | Self::Huge => {}
            }
        }
    }

    fn answer(self, stream: &mut TcpStream, line: &[u8]) -> std::io::Result<()> {
        match (self, line) {
            (Self::Silent, _) => Ok(()),
            (_, b"t00028105" | b"t00028205") => stream.write_all(b"\rt705100\r"),
            (Self::Nonsense, [b't', b'6', b'0', b'5', ..]) => stream.write_all(b"\rt5858EEEEEEEEEEEEEEEE\r"),
            // An upload begins; its segments are empty or full, and none is the last segment.
            (Self::Endless | Self::Huge, [b't', b'6', b'0', b'5', _, b'4', b'0', object @ ..]) => {
                let object = String::from_utf8_lossy(object.get(..6).unwrap_or_default()).into_owned();
                let (begin, size) = if self == Self::Huge { ("41", "FFFFFFFF") } else { ("40", "00000000") };
                stream.write_all(format!("\rt5858{begin}{object}{size}\r").as_bytes())
            }
            (Self::Endless | Self::Huge, [b't', b'6', b'0', b'5', _, toggle @ (b'6' | b'7'), ..]) => {
                let toggle = if *toggle == b'6' { '0' } else { '1' };
                let unused = if self == Self::Huge { '0' } else { 'E' };
                stream.write_all(format!("\rt5858{toggle}{unused}00000000000000\r").as_bytes())
            }
            _ => stream.write_all(b"\r"),
        }
    }
}

fn is_silence(error: &std::io::Error) -> bool {
    matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut)
}
