//! A simulated device in one process, the tester in another, and the transport between them.

use super::options::{Options, Starved, Transport};
use super::tally::Run;
use anyhow::{Context, Result, ensure};
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// The node-ID of every device.
const NODE: &str = "63";
/// All permissions: the devices are simulated and alone on their buses.
const ALLOWED: &str = "nvm,node-id,bit-rate,other-nodes,factory-defaults,preset";
/// SLCAN adapters have one bit rate, which the simulated devices get.
const BIT_RATE: &str = "250k";

/// A device in another process, and its address.
pub struct Pair {
    device: Child,
    tester: Command,
    /// Dropped after the device.
    _interface: Option<Interface>,
}

/// The verdicts of the simulated bus, where time is virtual.
///
/// # Errors
/// If the program prints no report.
pub fn simulated(program: &str, model: &str, options: &Options) -> Result<Run> {
    let mut command = tester(program, &format!("sim:{model}:{NODE}@{BIT_RATE}"), model, options);
    report(&mut command)
}

impl Pair {
    /// Starts the device.
    ///
    /// # Errors
    /// If the device does not start.
    pub fn start(program: &str, model: &str, options: &Options) -> Result<Self> {
        let mut interface = None;
        let (end, other) = match &options.transport {
            Transport::Interface(name) => (name.clone(), name.clone()),
            Transport::Virtual => {
                let name = &interface.insert(Interface::create()?).0;
                (name.clone(), name.clone())
            }
            Transport::Slcan => {
                let port = free_port()?;
                (format!("slcan:listen://{port}"), format!("slcan:tcp://127.0.0.1:{port}@{BIT_RATE}"))
            }
        };
        let mut command = match options.starved {
            Starved::Tester => prompt(program),
            Starved::Device => starved(program),
        };
        command.args(["simulate", model, &end, "--node", NODE]);
        let mut device = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| format!("can't run {program}"))?;
        // The device prints a line when it is ready; its further output must not fill the pipe.
        if let Some(stderr) = device.stderr.take() {
            let mut lines = BufReader::new(stderr).lines();
            lines.next().transpose()?;
            std::thread::spawn(move || lines.for_each(drop));
        }
        Ok(Self { device, tester: tester(program, &other, model, options), _interface: interface })
    }

    /// Runs the suite.
    ///
    /// # Errors
    /// If the program prints no report.
    pub fn test(mut self) -> Result<Run> {
        report(&mut self.tester)
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        // The device may have ended.
        let _ = self.device.kill();
        let _ = self.device.wait();
    }
}

/// A virtual CAN interface.
struct Interface(String);

impl Interface {
    fn create() -> Result<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("flaky{}", NEXT.fetch_add(1, Ordering::Relaxed));
        ip(&["add", "dev", &name, "type", "vcan"])?;
        let interface = Self(name);
        ip(&["set", &interface.0, "up"])?;
        Ok(interface)
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        // The interface is no longer needed, and a remaining interface does no harm.
        let _ = ip(&["del", &self.0]);
    }
}

fn ip(words: &[&str]) -> Result<()> {
    let output = Command::new("ip").arg("link").args(words).output().context("can't run ip")?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "ip link {}: {}", words.join(" "), said.trim());
    Ok(())
}

/// Runs the device before other work, if this user may set the priority: the device should be as prompt as a real
/// device, so that only the tester is late.
fn prompt(program: &str) -> Command {
    let may = Command::new("chrt").args(["--fifo", "10", "true"]).stderr(Stdio::null()).status();
    if !may.is_ok_and(|status| status.success()) {
        return Command::new(program);
    }
    let mut command = Command::new("chrt");
    command.args(["--fifo", "10", program]);
    command
}

/// Runs the device at the lowest priority, so that it is late while other work needs the processor.
fn starved(program: &str) -> Command {
    let mut command = Command::new("nice");
    command.args(["-n", "19", program]);
    command
}

fn tester(program: &str, bus: &str, model: &str, options: &Options) -> Command {
    let mut command = Command::new(program);
    command.args(["test", bus, "--node", NODE, "--allow", ALLOWED, "--format", "json"]);
    if !bus.starts_with("sim:") {
        command.args(["--device", model]);
    }
    if let Some(select) = &options.select {
        command.args(["--select", select]);
    }
    command
}

fn report(command: &mut Command) -> Result<Run> {
    let output = command.stdin(Stdio::null()).output().with_context(|| format!("can't run {command:?}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(!output.stdout.is_empty(), "{command:?} reported nothing: {said}");
    Run::read(&output.stdout).with_context(|| format!("{command:?}: {said}"))
}

/// A port that is free at the moment.
fn free_port() -> Result<u16> {
    Ok(TcpListener::bind("127.0.0.1:0")?.local_addr()?.port())
}
