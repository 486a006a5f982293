//! A way over TCP to an SLCAN adapter, which can be cut and restored: a gateway that starts again, a cable that is pulled.

#![cfg_attr(not(unix), allow(dead_code, reason = "what cuts the way needs signals"))]

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A way that leads to an adapter as long as this process lives.
#[derive(Clone)]
pub struct Proxy {
    /// Where a program connects to it.
    pub address: SocketAddr,
    way: Arc<Mutex<Way>>,
}

struct Way {
    is_cut: bool,
    /// Both ends of the connections that there are.
    ends: Vec<TcpStream>,
    adapter: Option<TcpStream>,
    /// What programs have sent, all of it.
    sent: Vec<u8>,
}

impl Proxy {
    /// To the adapter at that address.
    pub fn start(adapter: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let way = Way { is_cut: false, ends: Vec::new(), adapter: None, sent: Vec::new() };
        let proxy = Self { address: listener.local_addr()?, way: Arc::new(Mutex::new(way)) };
        let serving = proxy.clone();
        std::thread::spawn(move || {
            for program in listener.incoming().flatten() {
                // Without an adapter the program is hung up on.
                let _ = serving.connect(program, adapter);
            }
        });
        Ok(proxy)
    }

    /// As a program names it.
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

    /// Carries bytes from one end to the other until either is closed.
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
        // Who hangs up hangs up for the other end, too.
        let _ = to.shutdown(Shutdown::Both);
        let _ = from.shutdown(Shutdown::Both);
    }

    /// Cuts the way; whoever connects is hung up on.
    pub fn cut(&self) {
        let mut way = self.way();
        way.is_cut = true;
        way.adapter = None;
        for end in way.ends.drain(..) {
            // One that is closed already is as good.
            let _ = end.shutdown(Shutdown::Both);
        }
    }

    /// Cuts the way for that long.
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

    /// How many lines programs have sent so far.
    pub fn lines(&self) -> usize {
        self.way().sent.iter().filter(|&&byte| byte == b'\r').count()
    }

    /// Whether programs have sent this text at least `times` times.
    pub fn has_sent(&self, text: &str, times: usize) -> bool {
        String::from_utf8_lossy(&self.way().sent).matches(text).count() >= times
    }

    /// What programs have sent in lines that begin so, without that begin.
    pub fn frames(&self, begin: &str) -> Vec<String> {
        let sent = String::from_utf8_lossy(&self.way().sent).into_owned();
        sent.split('\r').filter_map(|line| line.strip_prefix(begin)).map(str::to_owned).collect()
    }

    /// Waits until `more` further lines were sent.
    pub fn wait_for_lines(&self, more: usize) {
        let goal = self.lines() + more;
        self.wait(&format!("{more} more lines"), || self.lines() >= goal);
    }

    /// Waits until something is the case.
    pub fn wait(&self, what: &str, is_so: impl Fn() -> bool) {
        let begun = Instant::now();
        while !is_so() {
            assert!(begun.elapsed() < Duration::from_secs(120), "{what}, after {} lines", self.lines());
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
