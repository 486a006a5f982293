//! `canvass doctor`: capabilities of this machine.

#[cfg(target_os = "linux")]
mod kernel;

use crate::output::{TextOrJson, print};
use crate::status::{Failure, Status};
use canvass_reports::escape::Printable;
use serde_json::json;
use std::fmt::Write;
use std::fs;
use std::time::{Duration, Instant};

/// Show which live buses this machine can use, which parts are missing, and how to get them
///
/// Checks the kernel's CAN support, its CAN interfaces, serial ports, and the precision of timers.
#[derive(clap::Args)]
pub struct Args {
    /// How to print the findings
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
    /// Same as --format json (former name)
    #[arg(long, hide = true)]
    json: bool,
}

/// A checked capability of the machine.
struct Finding {
    what: &'static str,
    good: bool,
    text: String,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let mut findings = vec![system()];
        findings.extend(socketcan());
        findings.push(serial_ports());
        findings.extend(pcan());
        findings.push(wake_up());
        findings.push(processors());
        if self.json || matches!(self.format, TextOrJson::Json) {
            let rows: Vec<_> = findings
                .iter()
                .map(|finding| json!({"what": finding.what, "good": finding.good, "text": finding.text}))
                .collect();
            print(&Printable::pretty_json(&json!({"schema": "canvass/doctor/1", "findings": rows})))?;
            return Ok(Status::Good);
        }
        let mut text = String::new();
        for finding in &findings {
            // Writing to a string can't fail.
            let _ = writeln!(text, "{} {:12} {}", if finding.good { "✔" } else { "✘" }, finding.what, finding.text);
        }
        print(&Printable::document(&text))?;
        Ok(Status::Good)
    }
}

/// The addresses of the buses that this computer seems to have. Adapters that need a bit rate get a usual one.
pub fn buses() -> Vec<String> {
    #[cfg(target_os = "linux")]
    let mut buses = canvass_bus::socketcan::Link::can_interfaces();
    #[cfg(not(target_os = "linux"))]
    let mut buses = Vec::new();
    buses.extend(ports().into_iter().map(|port| format!("slcan:{port}@250k")));
    #[cfg(any(windows, target_os = "linux"))]
    if let Ok(installed) = canvass_bus::pcan::installed() {
        buses.extend(installed.channels.iter().map(|present| format!("pcan:{}@250k", present.channel)));
    }
    buses
}

fn read(path: &str) -> Option<String> {
    fs::read_to_string(path).ok().map(|text| text.trim().to_owned())
}

fn system() -> Finding {
    let release = read("/proc/sys/kernel/osrelease").unwrap_or_else(|| std::env::consts::OS.to_owned());
    Finding { what: "system", good: true, text: format!("{} {release}", std::env::consts::OS) }
}

#[cfg(target_os = "linux")]
fn socketcan() -> Vec<Finding> {
    use canvass_bus::socketcan::{Link, SocketCan, SocketCanError};
    let mut findings = Vec::new();
    let support = SocketCan::support();
    let good = support.is_ok();
    let text = match support {
        Ok(()) => "the kernel has AF_CAN and CAN_RAW".to_owned(),
        Err(SocketCanError::NoCan) => kernel::why_no_can(),
        Err(error) => error.to_string(),
    };
    findings.push(Finding { what: "SocketCAN", good, text });
    let interfaces = Link::can_interfaces();
    if interfaces.is_empty() {
        let text = if good {
            "none; a virtual one: ip link add dev vcan0 type vcan && ip link set vcan0 up".to_owned()
        } else {
            "none".to_owned()
        };
        findings.push(Finding { what: "interfaces", good: false, text });
    }
    for name in interfaces {
        let link = Link::find(&name).ok().flatten();
        let good = link.as_ref().is_some_and(|link| link.is_up);
        let remedy = link.as_ref().filter(|link| !link.is_up).map(|link| format!(": {}", link.up_command(&name)));
        let text = link.map_or_else(|| "unreadable".to_owned(), |link| link.to_string());
        findings.push(Finding {
            what: "interface",
            good,
            text: format!("{name}: {text}{}", remedy.unwrap_or_default()),
        });
    }
    if good && let Some(bytes) = read("/proc/sys/net/core/rmem_max").and_then(|text| text.parse::<u64>().ok()) {
        // A frame takes about 1 KiB of the kernel's queue, and root may exceed the limit.
        let enough = bytes >= 4 << 20;
        let remedy = if enough { "" } else { ": sysctl net.core.rmem_max=8388608 (not needed as root)" };
        let text = format!("holds about {} frames while this program does not run{remedy}", bytes / 1024);
        findings.push(Finding { what: "kernel queue", good: enough, text });
    }
    findings
}

#[cfg(not(target_os = "linux"))]
fn socketcan() -> Vec<Finding> {
    vec![Finding {
        what: "SocketCAN",
        good: false,
        text: "only Linux has SocketCAN: use slcan:PORT or pcan:CHANNEL".to_owned(),
    }]
}

/// Checks adapters of PEAK, through PEAK's own library.
#[cfg(any(windows, target_os = "linux"))]
fn pcan() -> Option<Finding> {
    use canvass_bus::pcan::{PcanError, installed};
    let (good, text) = match installed() {
        Ok(found) => {
            let channels: Vec<String> = found.channels.iter().map(ToString::to_string).collect();
            let version = found.version.map_or_else(String::new, |version| format!("version {version}: "));
            let none = "no adapter is plugged in".to_owned();
            (true, version + &if channels.is_empty() { none } else { channels.join("; ") })
        }
        // Most users have no such adapter, and on Linux the kernel's driver serves it without this library.
        Err(PcanError::NoLibrary { .. }) => (true, "not installed: only pcan:CHANNEL needs it".to_owned()),
        Err(error) => (false, error.to_string()),
    };
    Some(Finding { what: "PCAN-Basic", good, text })
}

#[cfg(not(any(windows, target_os = "linux")))]
fn pcan() -> Option<Finding> {
    None
}

/// All serial ports of Windows: the system does not tell which are CAN adapters.
#[cfg(windows)]
fn ports() -> Vec<String> {
    canvass_bus::slcan::ports()
}

#[cfg(windows)]
fn serial_ports() -> Finding {
    let ports = ports();
    let text = if ports.is_empty() { NO_PORTS.to_owned() } else { ports.join(", ") };
    Finding { what: "serial ports", good: true, text }
}

const NO_PORTS: &str = "none (slcan:tcp://HOST:PORT works without them)";

/// The serial ports under whose names CAN adapters appear.
#[cfg(not(windows))]
fn ports() -> Vec<String> {
    let entries = fs::read_dir("/dev").into_iter().flatten().flatten();
    let mut ports: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| ["ttyACM", "ttyUSB"].iter().any(|prefix| name.starts_with(prefix)))
        .map(|name| format!("/dev/{name}"))
        .collect();
    ports.sort();
    ports
}

#[cfg(not(windows))]
fn serial_ports() -> Finding {
    let ports = ports();
    let locked = |port: &&String| fs::OpenOptions::new().read(true).write(true).open(port).is_err();
    let denied: Vec<&String> = ports.iter().filter(locked).collect();
    let (good, text) = match (&*ports, &*denied) {
        ([], _) => (true, NO_PORTS.to_owned()),
        (_, []) => (true, ports.join(", ")),
        (_, [first, ..]) => {
            (false, format!("{first} can't be opened: join its group, usually `usermod -aG dialout $USER`"))
        }
    };
    Finding { what: "serial ports", good, text }
}

/// Measures how late the system wakes the program: the tester can't measure reaction times more precisely.
fn wake_up() -> Finding {
    let asked = Duration::from_millis(1);
    let mut delays: Vec<Duration> = (0..200)
        .map(|_| {
            let begun = Instant::now();
            std::thread::sleep(asked);
            begun.elapsed().saturating_sub(asked)
        })
        .collect();
    delays.sort_unstable();
    let at = |share: usize| delays.get(delays.len() * share / 100).copied().unwrap_or_default();
    let worst = delays.last().copied().unwrap_or_default();
    let text = format!(
        "half of all waits end within {} of the requested time, 99 % within {}, all within {}",
        shown(at(50)),
        shown(at(99)),
        shown(worst)
    );
    Finding { what: "wake-up", good: at(99) < Duration::from_millis(10), text }
}

fn shown(span: Duration) -> String {
    if span < Duration::from_millis(1) {
        format!("{} µs", span.as_micros())
    } else {
        format!("{:.1} ms", span.as_secs_f64() * 1e3)
    }
}

fn processors() -> Finding {
    let n = std::thread::available_parallelism().map_or(1, usize::from);
    let text = if n > 1 { format!("{n}") } else { "1: receiving and judging share it".to_owned() };
    Finding { what: "processors", good: n > 1, text }
}
