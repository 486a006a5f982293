//! The machine in QEMU. Its clock counts instructions, one for each nanosecond, and jumps where it has nothing to do but
//! wait: however slow or busy this machine is, that one is never late, and every run is as the one before. A minute of
//! waiting takes no time.

use super::kernel::Kernel;
use super::{Built, FOLDER, files};
use crate::packages::{Package, install};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

const QEMU: [Package; 6] = [
    Package { program: "qemu-system-x86_64", probe: &["--version"], package: "qemu-system-x86" },
    Package { program: "busybox", probe: &["true"], package: "busybox-static" },
    Package { program: "modprobe", probe: &["--version"], package: "kmod" },
    Package { program: "cpio", probe: &["--version"], package: "cpio" },
    Package { program: "dpkg-deb", probe: &["--version"], package: "dpkg" },
    Package { program: "strip", probe: &["--version"], package: "binutils" },
];

/// What the machine says last, with the status of its tests.
const END: &str = "tests on vcan ended with status ";

/// After so many seconds a machine is given up.
const PATIENCE: &str = "1500";

/// Runs the tests of those names, dealt out to as many machines as there are processors.
/// `settings`: variables of their environment.
pub fn run(built: &Built, names: &[String], settings: &[(&str, &str)]) -> Result<()> {
    install(&QEMU)?;
    fs::create_dir_all(FOLDER)?;
    let kernel = Kernel::fetch()?;
    let machines = std::thread::available_parallelism().map_or(1, usize::from).min(names.len());
    let mut dealt = vec![Vec::new(); machines];
    for (name, machine) in names.iter().zip((0..machines).cycle()) {
        dealt[machine].push(name.clone());
    }
    let archive = files::archive(&kernel, built, &dealt, settings)?;
    eprintln!("$ qemu-system-x86_64 -kernel {} ({machines} times)", kernel.image.display());
    let statuses: Vec<Result<String>> = std::thread::scope(|scope| {
        let boot = |machine| {
            let (image, archive) = (&kernel.image, &archive);
            scope.spawn(move || boot(machine, image, archive))
        };
        let running: Vec<_> = (0..machines).map(boot).collect();
        running.into_iter().map(|machine| machine.join().unwrap_or_else(|_| Ok("none".to_owned()))).collect()
    });
    for status in statuses {
        let status = status?;
        ensure!(status == "0", "they ended with status {status}");
    }
    Ok(())
}

/// Runs a machine until it switches itself off; gives the status of its tests.
fn boot(machine: usize, image: &Path, archive: &Path) -> Result<String> {
    let line =
        format!("console=ttyS0 quiet panic=-1 no_timer_check clocksource=tsc tsc=reliable canvass_machine={machine}");
    let mut qemu = Command::new("timeout")
        .args([
            PATIENCE,
            "qemu-system-x86_64",
            "-accel",
            "tcg",
            "-icount",
            "shift=0,sleep=off",
            "-smp",
            "1",
            "-m",
            "1536",
        ])
        .args([
            "-nodefaults",
            "-no-user-config",
            "-no-reboot",
            "-display",
            "none",
            "-serial",
            "stdio",
            "-rtc",
            "clock=vm",
        ])
        .arg("-kernel")
        .arg(image)
        .arg("-initrd")
        .arg(archive)
        .args(["-append", &line])
        // Two interfaces with controllers, on one bus.
        .args([
            "-object",
            "can-bus,id=wires",
            "-device",
            "kvaser_pci,canbus=wires",
            "-device",
            "kvaser_pci,canbus=wires",
        ])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("qemu-system-x86_64")?;
    let mut status = None;
    let output = qemu.stdout.take().context("QEMU has no output")?;
    for line in BufReader::new(output).split(b'\n') {
        let line = String::from_utf8_lossy(&line?).trim_end().to_owned();
        if let Some((_, code)) = line.split_once(END) {
            status = Some(code.to_owned());
        } else if !line.is_empty() {
            eprintln!("[{machine}] {line}");
        }
    }
    let ended = qemu.wait()?;
    ensure!(ended.success(), "QEMU ended with {ended}{}", if ended.code() == Some(124) { ": out of time" } else { "" });
    status.context("the machine has switched itself off before its tests ended")
}
