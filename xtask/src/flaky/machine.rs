//! A kernel with vcan, where this one has none: Debian's user-mode Linux, an ordinary process in which programs run as fast
//! as outside and see the same files. It has one processor and the same clock, so waits take as long as they say.

use super::options::Options;
use crate::packages::{Package, install};
use crate::run::{quoted, this_program};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;

const NEEDED: [Package; 4] = [
    Package { program: "linux.uml", probe: &["--version"], package: "user-mode-linux" },
    Package { program: "busybox", probe: &["true"], package: "busybox-static" },
    Package { program: "modprobe", probe: &["--version"], package: "kmod" },
    Package { program: "ip", probe: &["-V"], package: "iproute2" },
];
const FOLDER: &str = "target/flaky";
/// Where the package puts the modules, in a folder named by the kernel's version.
const MODULES: &str = "/usr/lib/uml/modules";
const NEEDED_MODULES: [&str; 4] =
    ["net/can/can", "net/can/can-raw", "drivers/net/can/dev/can-dev", "drivers/net/can/vcan"];
/// Memory of a machine for itself, and for each pair of processes in it, in MiB.
const MEMORY: [usize; 2] = [512, 64];
/// What the machine says last, with the exit status.
const ENDED: &str = "flaky: ended with ";

/// Runs them in as many machines as there are processors, each with its share of the runs.
///
/// # Errors
/// If a machine can't be started, or the measurement in it fails.
pub fn run(options: &Options) -> Result<()> {
    install(&NEEDED)?;
    fs::create_dir_all(FOLDER)?;
    let machines = thread::available_parallelism().map_or(1, |count| count.get() as u32).min(options.runs);
    let shares = (0..machines).map(|machine| options.runs / machines + u32::from(machine < options.runs % machines));
    let ended: Vec<Result<()>> = thread::scope(|scope| {
        let boot = |(machine, runs)| scope.spawn(move || boot(machine, runs, options));
        let running: Vec<_> = shares.enumerate().map(boot).collect();
        running.into_iter().map(|machine| machine.join().unwrap_or_else(|_| bail!("its thread panicked"))).collect()
    });
    for (machine, ended) in ended.into_iter().enumerate() {
        ended.with_context(|| format!("machine {machine}"))?;
    }
    Ok(())
}

/// Starts a machine, shows what it says, and waits until it switches itself off.
fn boot(machine: usize, runs: u32, options: &Options) -> Result<()> {
    let init = write_init(machine, &options.words(runs))?;
    let memory = MEMORY[0] + MEMORY[1] * options.at_once;
    let mut uml = Command::new("linux.uml");
    uml.arg(format!("mem={memory}M")).arg(format!("init={}", init.display()));
    uml.args(["rootfstype=hostfs", "ro", "rootflags=/", "con=null", "con0=null,fd:1", "quiet"]);
    let mut uml = uml.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().context("linux.uml")?;
    let output = uml.stdout.take().context("the machine has no console")?;
    let mut status = None;
    for line in BufReader::new(output).split(b'\n') {
        let line = String::from_utf8_lossy(&line?).trim_end().to_owned();
        match line.split_once(ENDED) {
            Some((_, said)) => status = said.trim().parse::<i32>().ok(),
            None if line.starts_with('|') => println!("{line}"),
            None if line.is_empty() => {}
            None => eprintln!("[{machine}] {line}"),
        }
    }
    uml.wait()?;
    ensure!(status == Some(0), "the measurement ended with {status:?}");
    Ok(())
}

/// The first process of the machine. It has this machine's files, and may write none of them.
fn write_init(machine: usize, words: &[String]) -> Result<PathBuf> {
    let project = std::env::current_dir()?;
    let version = fs::read_dir(MODULES)?.flatten().next().context("user-mode-linux has no modules")?;
    let modules: Vec<String> = NEEDED_MODULES
        .iter()
        .map(|name| version.path().join("kernel").join(format!("{name}.ko")))
        .map(|file| format!("insmod {}\n", quoted(&file.to_string_lossy())))
        .collect();
    let words: Vec<String> = words.iter().map(|word| quoted(word)).collect();
    let text = format!(
        "#!/bin/sh\n\
         export PATH={path} HOME=/mnt TMPDIR=/mnt\n\
         mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t tmpfs tmpfs /mnt; mount -t tmpfs tmpfs /run\n\
         {modules}\
         ip link set lo up\n\
         cd {project} && {xtask} flaky {words} < /dev/null\n\
         echo \"{ENDED}$?\"\n\
         busybox poweroff -f\n",
        path = quoted(&(std::env::var("PATH").unwrap_or_default() + ":/usr/sbin:/sbin")),
        modules = modules.concat(),
        project = quoted(&project.to_string_lossy()),
        xtask = quoted(&this_program()?.to_string_lossy()),
        words = words.join(" "),
    );
    let file = project.join(FOLDER).join(format!("init-{machine}"));
    fs::write(&file, text)?;
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755))?;
    Ok(file)
}
