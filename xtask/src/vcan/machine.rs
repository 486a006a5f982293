//! The machine in QEMU. Its clock counts instructions, one for each nanosecond, and jumps while the machine only waits:
//! however slow or busy this computer is, the machine is never late, and every run is the same. A minute of waiting
//! takes no time.

use super::deal::{Costs, deal};
use super::kernel::Kernel;
use super::report::{Ended, Line, Report};
use super::{FOLDER, Job, files};
use crate::packages::{Package, install};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

const QEMU: [Package; 6] = [
    Package { program: "qemu-system-x86_64", probe: &["--version"], package: "qemu-system-x86" },
    Package { program: "busybox", probe: &["true"], package: "busybox-static" },
    Package { program: "modprobe", probe: &["--version"], package: "kmod" },
    Package { program: "cpio", probe: &["--version"], package: "cpio" },
    Package { program: "dpkg-deb", probe: &["--version"], package: "dpkg" },
    Package { program: "strip", probe: &["--version"], package: "binutils" },
];

/// Arguments of the kernel: it prints only errors, takes the time from the counter of instructions, which is always
/// right here, and has no mitigations of processor faults.
const KERNEL_ARGS: &str = "console=ttyS0 quiet panic=-1 no_timer_check clocksource=tsc tsc=reliable mitigations=off \
                           nokaslr init_on_alloc=0 nowatchdog lsm= canvass_machine=";

/// Arguments of QEMU: one processor whose clock counts instructions, and only the devices that the tests need.
const QEMU_ARGS: [&str; 21] = [
    "-accel",
    "tcg",
    "-icount",
    "shift=0,sleep=off",
    "-smp",
    "1",
    "-m",
    "4096",
    "-nodefaults",
    "-no-user-config",
    "-no-reboot",
    "-display",
    "none",
    "-serial",
    "stdio",
    "-rtc",
    "clock=vm",
    // Two interfaces with controllers, on one bus.
    "-object",
    "can-bus,id=wires",
    "-device",
    "kvaser_pci,canbus=wires",
];
const SECOND_CONTROLLER: [&str; 2] = ["-device", "kvaser_pci,canbus=wires"];

/// Installs QEMU.
///
/// # Errors
/// If QEMU can't be installed.
pub fn install_all() -> Result<()> {
    install(&QEMU).context("can't install QEMU and the packages that start a kernel in it")
}

/// Runs the tests with these names, distributed over as many machines as there are processors. `settings`: variables of
/// the tests' environment.
pub fn run(job: &Job, names: &[String], settings: &[(&str, &str)]) -> Result<()> {
    install_all()?;
    fs::create_dir_all(FOLDER)?;
    let kernel = Kernel::fetch()?;
    let machines = std::thread::available_parallelism().map_or(1, usize::from).min(names.len());
    let dealt = deal(names, machines, &Costs::read()?);
    let archive = files::archive(&kernel, job, &dealt, settings)?;
    eprintln!("$ qemu-system-x86_64 -kernel {} ({machines} times)", kernel.image.display());
    let begun = Instant::now();
    let ended: Vec<Result<Vec<Ended>>> = std::thread::scope(|scope| {
        let (image, archive, patience) = (&kernel.image, &archive, job.patience);
        let boot = |machine| scope.spawn(move || boot(machine, image, archive, patience));
        let running: Vec<_> = (0..machines).map(boot).collect();
        running.into_iter().map(|machine| machine.join().unwrap_or_else(|_| bail!("its thread panicked"))).collect()
    });
    let mut report = Report::default();
    for (machine, (ended, names)) in ended.into_iter().zip(&dealt).enumerate() {
        report.add(names, ended.with_context(|| format!("machine {machine}"))?);
    }
    report.finish(begun.elapsed())
}

/// Runs a machine until it switches itself off, or has printed nothing for longer than `patience`.
fn boot(machine: usize, image: &Path, archive: &Path, patience: Duration) -> Result<Vec<Ended>> {
    let mut qemu = Command::new("qemu-system-x86_64");
    qemu.args(QEMU_ARGS).args(SECOND_CONTROLLER).arg("-kernel").arg(image).arg("-initrd").arg(archive);
    qemu.args(["-append", &format!("{KERNEL_ARGS}{machine}")]).stdin(Stdio::null()).stdout(Stdio::piped());
    let mut qemu = qemu.spawn().context("qemu-system-x86_64")?;
    let (id, output) = (qemu.id(), qemu.stdout.take().context("QEMU has no output")?);
    let qemu = Mutex::new(qemu);
    let (alive, silence) = channel();
    std::thread::scope(|scope| {
        scope.spawn(|| give_up(&qemu, silence, patience));
        let ended = listen(machine, id, BufReader::new(output), alive);
        let status = qemu.lock().unwrap_or_else(PoisonError::into_inner).wait()?;
        ensure!(
            status.success(),
            "QEMU ended with {status} (it is killed if the machine prints nothing for {patience:?})"
        );
        ended
    })
}

/// Ends a machine that has printed nothing for longer than `patience`.
fn give_up(qemu: &Mutex<Child>, silence: Receiver<()>, patience: Duration) {
    loop {
        match silence.recv_timeout(patience) {
            Ok(()) => {}
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => return,
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {
                let _ = qemu.lock().unwrap_or_else(PoisonError::into_inner).kill();
                return;
            }
        }
    }
}

/// Reads the output of a machine: returns the tests that ended, and prints all other lines.
fn listen(machine: usize, id: u32, output: impl BufRead, alive: Sender<()>) -> Result<Vec<Ended>> {
    let (mut ended, mut since, mut switched_off) = (Vec::new(), (Instant::now(), cpu_time(id)), false);
    let mut begun = None;
    for line in output.split(b'\n') {
        let line = String::from_utf8_lossy(&line?).trim_end().to_owned();
        let _ = alive.send(());
        match Line::of(&line) {
            Some(Line::Begin(uptime)) => {
                if begun.is_none() {
                    eprintln!("[{machine}] booted in {:.1} s", since.0.elapsed().as_secs_f64());
                }
                (begun, since) = (Some(uptime), (Instant::now(), cpu_time(id)));
            }
            Some(Line::End { name, status, uptime }) => {
                let took = uptime.since(begun.unwrap_or_default());
                let wall = since.0.elapsed().as_secs_f64();
                let test = Ended { name, status, wall, cpu: cpu_time(id) - since.1, took };
                eprintln!("[{machine}] {test}");
                ended.push(test);
            }
            Some(Line::All) => switched_off = true,
            None if line.is_empty() => {}
            None => eprintln!("[{machine}] {line}"),
        }
    }
    ensure!(switched_off, "the machine went off before its tests ended");
    Ok(ended)
}

/// The seconds of processor time that a process has taken so far.
fn cpu_time(id: u32) -> f64 {
    /// The fields of `/proc/ID/stat` for user and system time, counted from the field after the name.
    const FIELDS: [usize; 2] = [11, 12];
    /// `USER_HZ`, the same on all of Linux.
    const TICKS: f64 = 100.0;
    let text = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    let fields: Vec<&str> = text.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    FIELDS.iter().filter_map(|&at| fields.get(at)?.parse::<f64>().ok()).sum::<f64>() / TICKS
}
