//! A TCP connection to an SLCAN adapter that can be cut and restored, like a gateway that restarts or a cable that is
//! pulled.

#![cfg_attr(not(unix), allow(dead_code, reason = "what cuts the way needs signals"))]

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A TCP proxy before an adapter, which runs as long as this process lives.
#[derive(Clone)]
pub struct Proxy {
    /// The address to which a program connects.
    pub address: SocketAddr,
    way: Arc<Mutex<Way>>,
}

struct Way {
    is_cut: bool,
    /// Both ends of all open connections.
    ends: Vec<TcpStream>,
    adapter: Option<TcpStream>,
    /// All bytes that programs have sent.
    sent: Vec<u8>,
}

impl Proxy {
    /// Starts a proxy for the adapter with this address.
    pub fn start(adapter: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let way = Way { is_cut: false, ends: Vec::new(), adapter: None, sent: Vec::new() };
        let proxy = Self { address: listener.local_addr()?, way: Arc::new(Mutex::new(way)) };
        let serving = proxy.clone();
        std::thread::spawn(move || {
            for program in listener.incoming().flatten() {
                // If the adapter is not available, the connection of the program is closed.
                let _ = serving.connect(program, adapter);
            }
        });
        Ok(proxy)
    }

    /// The bus address of the proxy.
    pub fn bus(&self) -> String {
        format!("slcan:tcp://{}", self.address)
    }

    fn way(&self) -> MutexGuard<'_, Way> {
        self.way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn connect(&self, program: TcpStream, adapter: SocketAddr) -> io::Result<()> {
        let mut way = self.way();
        if way.is_cut {
            return Ok(());
        }
        let adapter = TcpStream::connect(adapter)?;
        adapter.set_nodelay(true)?;
        program.set_nodelay(true)?;
        way.adapter = Some(adapter.try_clone()?);
        way.ends.extend([program.try_clone()?, adapter.try_clone()?]);
        let (there, back) = (self.clone(), self.clone());
        let (from_program, to_adapter) = (program.try_clone()?, adapter.try_clone()?);
        std::thread::spawn(move || there.carry(from_program, to_adapter, true));
        std::thread::spawn(move || back.carry(adapter, program, false));
        Ok(())
    }

    /// Copies bytes from one end to the other until either is closed.
    fn carry(&self, mut from: TcpStream, mut to: TcpStream, is_sent: bool) {
        let mut bytes = [0; 4096];
        while let Ok(read @ 1..) = from.read(&mut bytes) {
            let carried = &bytes[..read];
            if is_sent {
                self.way().sent.extend_from_slice(carried);
            }
            if to.write_all(carried).is_err() {
                break;
            }
        }
        // A disconnection of one end is passed on to the other.
        let _ = to.shutdown(Shutdown::Both);
        let _ = from.shutdown(Shutdown::Both);
    }

    /// Cuts the connections; new connections are closed at once.
    pub fn cut(&self) {
        let mut way = self.way();
        way.is_cut = true;
        way.adapter = None;
        for end in way.ends.drain(..) {
            // The end may be closed already.
            let _ = end.shutdown(Shutdown::Both);
        }
    }

    /// Cuts the connections for this time.
    pub fn cut_for(&self, span: Duration) {
        self.cut();
        std::thread::sleep(span);
        self.way().is_cut = false;
    }

    /// Sends a line to the adapter, as another node of the bus does.
    pub fn inject(&self, line: &str) -> io::Result<()> {
        let adapter = self.way().adapter.as_ref().map(TcpStream::try_clone).transpose()?;
        adapter.map_or(Ok(()), |mut adapter| adapter.write_all(format!("{line}\r").as_bytes()))
    }

    /// Number of lines that programs have sent so far.
    pub fn lines(&self) -> usize {
        self.way().sent.iter().filter(|&&byte| byte == b'\r').count()
    }

    /// Whether programs have sent this text at least `times` times.
    pub fn has_sent(&self, text: &str, times: usize) -> bool {
        String::from_utf8_lossy(&self.way().sent).matches(text).count() >= times
    }

    /// The lines from programs that begin with this text, without the text.
    pub fn frames(&self, begin: &str) -> Vec<String> {
        let sent = String::from_utf8_lossy(&self.way().sent).into_owned();
        sent.split('\r').filter_map(|line| line.strip_prefix(begin)).map(str::to_owned).collect()
    }

    /// Waits until `more` further lines were sent.
    pub fn wait_for_lines(&self, more: usize) {
        let goal = self.lines() + more;
        self.wait(&format!("{more} more lines"), || self.lines() >= goal);
    }

    /// Waits until the condition holds.
    pub fn wait(&self, what: &str, is_so: impl Fn() -> bool) {
        let begun = Instant::now();
        while !is_so() {
            assert!(begun.elapsed() < Duration::from_secs(120), "{what}, after {} lines", self.lines());
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
