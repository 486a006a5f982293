//! Buses of python-can: every adapter that python-can knows.
//!
//! The program starts a small Python program, which opens the bus with python-can and is an SLCAN adapter at a TCP port
//! of this machine.

use super::{SlCan, SlCanError};
use std::io::{BufRead as _, BufReader, Read};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

/// The Python program: the bridge of the Python package, which needs nothing but python-can.
const BRIDGE: &str = include_str!("../../../../python/canvass/bridge.py");

/// The environment variable that names the Python interpreter.
const INTERPRETER: &str = "CANVASS_PYTHON";

/// The running Python program. It ends when its standard input is closed.
pub(super) struct Bridge {
    process: Child,
    input: Option<ChildStdin>,
    /// The last line of its standard error, which a thread reads: a full pipe would stop the program.
    complaint: Option<JoinHandle<String>>,
}

/// Opens a bus of python-can: the interface, such as `kvaser`, the channel, and the bit rate in bit/s.
///
/// # Errors
/// [`SlCanError::Python`] with the error of Python or of python-can.
pub fn open(interface: &str, channel: &str, bit_rate: Option<u32>) -> Result<SlCan, SlCanError> {
    let name = format!("python:{interface}:{channel}");
    let failed = |reason: String| SlCanError::Python { name: name.clone(), reason };
    let mut process = start(interface, channel, bit_rate).map_err(failed)?;
    let input = process.stdin.take();
    let (mut address, output) = (String::new(), process.stdout.take());
    let complaint = process.stderr.take().map(|stderr| std::thread::spawn(move || last_line(stderr)));
    let bridge = Bridge { process, input, complaint };
    let read = output.map(|output| BufReader::new(output).read_line(&mut address));
    let Some(place) = address.trim().strip_prefix("slcan:").filter(|_| matches!(read, Some(Ok(_)))) else {
        return Err(failed(bridge.complaint()));
    };
    let mut bus = SlCan::open(place, None)?;
    (bus.bit_rate, bus.bridge) = (bit_rate, Some(bridge));
    Ok(bus)
}

fn start(interface: &str, channel: &str, bit_rate: Option<u32>) -> Result<Child, String> {
    let named = std::env::var(INTERPRETER).ok();
    let interpreters = named.as_deref().map_or_else(|| vec!["python3", "python", "py"], |named| vec![named]);
    let mut reason = String::new();
    for interpreter in interpreters {
        let mut command = Command::new(interpreter);
        command.args(["-c", BRIDGE, "--interface", interface, "--channel", channel]);
        command.args(bit_rate.map(|rate| format!("--bitrate={rate}")));
        match command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn() {
            Ok(process) => return Ok(process),
            Err(error) => reason = format!("can't start {interpreter}: {error}; {INTERPRETER} names the interpreter"),
        }
    }
    Err(reason)
}

/// The last line with text.
fn last_line(text: impl Read) -> String {
    let lines = BufReader::new(text).lines().map_while(Result::ok);
    lines.filter(|line| !line.trim().is_empty()).last().unwrap_or_default()
}

impl Bridge {
    /// Why the Python program has ended, with a remedy.
    fn complaint(mut self) -> String {
        drop(self.input.take());
        let told = self.complaint.take().and_then(|thread| thread.join().ok()).filter(|line| !line.is_empty());
        let last = told.unwrap_or_else(|| "Python has ended without a message".to_owned());
        let remedy = if last.contains("No module named") { " (pip install python-can)" } else { "" };
        format!("{last}{remedy}")
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        drop(self.input.take());
        // It ends by itself, unless python-can hangs.
        for _ in 0..100 {
            if matches!(self.process.try_wait(), Ok(Some(_)) | Err(_)) {
                return;
            }
            std::thread::sleep(crate::connection::link::LOOK);
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
