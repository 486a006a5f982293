//! `cargo xtask vcan`: the tests on real SocketCAN, on this kernel if it has vcan, else on Debian's in QEMU.
//! `cargo xtask vcan-load`: a minute of the highest load, measured there.

use crate::packages::{Package, install};
use crate::run::{is_there, run};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where Debian's kernel and the way into it are.
const FOLDER: &str = "target/vcan";
/// What the tests bring out of the kernel in QEMU.
const OUT: &str = "target/vcan/out";
const PROBE: &str = "canvassprobe";

const IPROUTE: Package = Package { program: "ip", probe: &["-V"], package: "iproute2" };
const QEMU: [Package; 5] = [
    Package { program: "qemu-system-x86_64", probe: &["--version"], package: "qemu-system-x86" },
    Package { program: "busybox", probe: &["true"], package: "busybox-static" },
    Package { program: "modprobe", probe: &["--version"], package: "kmod" },
    Package { program: "cpio", probe: &["--version"], package: "cpio" },
    Package { program: "dpkg-deb", probe: &["--version"], package: "dpkg" },
];

/// The modules in the order of their needs: to mount this machine's files, and for CAN.
const BASE: &[&str] = &["virtio_pci", "9pnet_virtio", "9p", "overlay"];
const CAN: &[&str] = &["can", "can-raw", "can-dev", "vcan"];

/// Runs the tests of `tests/vcan`; those whose names begin with `load` only where `loads` says so.
pub fn test(loads: bool) -> Result<()> {
    install(&[IPROUTE])?;
    let binary = build()?;
    // More at once would take the processor from each other.
    let filter: &[&str] = if loads { &["load_", "--ignored"] } else { &["--test-threads", "3"] };
    if has_vcan() {
        eprintln!("$ {} (this kernel has vcan)", binary.display());
        let status = Command::new(&binary).args(filter).arg("--nocapture").status()?;
        ensure!(status.success(), "the tests on vcan ended with {status}");
        return Ok(());
    }
    in_qemu(&binary, filter)
}

/// Builds the program and its tests; gives the path of the tests.
fn build() -> Result<PathBuf> {
    let args = ["test", "--locked", "--features", "vcan", "--test", "vcan", "--no-run", "--message-format", "json"];
    eprintln!("$ cargo {}", args.join(" "));
    // An emulated processor is slow; what others wrote is optimised anyway.
    let optimised = ("CARGO_PROFILE_DEV_OPT_LEVEL", "1");
    let output = Command::new("cargo").args(args).env(optimised.0, optimised.1).stderr(Stdio::inherit()).output()?;
    ensure!(output.status.success(), "the tests could not be built: {}", output.status);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut executables = text.lines().filter_map(|line| line.split_once("\"executable\":\"")?.1.split('"').next());
    let is_test =
        |path: &&str| Path::new(path).file_name().is_some_and(|name| name.to_string_lossy().starts_with("vcan-"));
    executables.rfind(is_test).map(PathBuf::from).context("cargo names no test to run")
}

/// Whether a virtual CAN interface can be made here.
fn has_vcan() -> bool {
    let made = is_there("ip", &["link", "add", "dev", PROBE, "type", "vcan"]);
    made && is_there("ip", &["link", "del", PROBE])
}

fn in_qemu(binary: &Path, filter: &[&str]) -> Result<()> {
    install(&QEMU)?;
    fs::create_dir_all(OUT)?;
    let kernel = kernel()?;
    initial_files(&kernel)?;
    let root = std::env::current_dir()?;
    let script = root.join(FOLDER).join("script");
    // Before CAN is loaded, what the doctor says is kept: a test looks at it.
    let program = binary.parent().and_then(Path::parent).context("the tests have no folder")?.join("canvass");
    fs::write(
        &script,
        format!(
            "cd {}\nif [ \"$1\" = before ]; then {} doctor > /out/doctor-without-can 2>&1; exit; fi\n\
             CANVASS_VCAN_OUT=/out {} {} --nocapture\n",
            root.display(),
            program.display(),
            binary.display(),
            filter.join(" ")
        ),
    )?;
    let _ = fs::remove_file(format!("{OUT}/status"));
    boot(&kernel, &script)?;
    let status = fs::read_to_string(format!("{OUT}/status")).unwrap_or_else(|_| "no end".to_owned());
    ensure!(status.trim() == "0", "the tests on vcan in QEMU ended with {}", status.trim());
    Ok(())
}

/// Debian's kernel and its modules, unpacked.
struct Kernel {
    image: PathBuf,
    version: String,
}

fn kernel() -> Result<Kernel> {
    let modules = format!("{FOLDER}/kernel/lib/modules");
    if !Path::new(&modules).exists() {
        let depends = Command::new("apt-cache").args(["depends", "linux-image-amd64"]).output()?;
        let depends = String::from_utf8_lossy(&depends.stdout).into_owned();
        let package = depends.lines().find_map(|line| line.trim().strip_prefix("Depends: linux-image-"));
        let package = format!("linux-image-{}", package.context("apt knows no linux-image-amd64: run apt-get update")?);
        eprintln!("$ apt-get download {package}");
        let status = Command::new("apt-get").args(["download", &package]).current_dir(FOLDER).status()?;
        ensure!(status.success(), "{package} could not be fetched: {status}");
        let archive = fs::read_dir(FOLDER)?.flatten().map(|entry| entry.path());
        let archive = archive.into_iter().find(|path| path.extension().is_some_and(|extension| extension == "deb"));
        let archive = archive.context("apt-get has fetched no package")?;
        run("dpkg-deb", &["--extract", &archive.to_string_lossy(), &format!("{FOLDER}/kernel")])?;
        fs::remove_file(archive)?;
    }
    let version = fs::read_dir(&modules)?.flatten().next().context("the kernel has no modules")?;
    let version = version.file_name().to_string_lossy().into_owned();
    if !Path::new(&format!("{modules}/{version}/modules.dep")).exists() {
        run("depmod", &["-b", &format!("{FOLDER}/kernel"), &version])?;
    }
    Ok(Kernel { image: format!("{FOLDER}/kernel/boot/vmlinuz-{version}").into(), version })
}

/// The files that the kernel starts with: busybox, the modules, and `tests/vcan/init`.
fn initial_files(kernel: &Kernel) -> Result<()> {
    let root = PathBuf::from(format!("{FOLDER}/initial"));
    let _ = fs::remove_dir_all(&root);
    for folder in ["bin", "proc", "sys", "dev", "modules"] {
        fs::create_dir_all(root.join(folder))?;
    }
    let busybox = Command::new("sh").args(["-c", "command -v busybox"]).output()?;
    fs::copy(String::from_utf8_lossy(&busybox.stdout).trim(), root.join("bin/busybox"))?;
    fs::copy("tests/vcan/init", root.join("init"))?;
    fs::set_permissions(root.join("init"), fs::Permissions::from_mode(0o755))?;
    let mut known = Vec::new();
    for (list, names) in [("order.base", BASE), ("order.can", CAN)] {
        let mut order = String::new();
        for name in names {
            for path in needed(kernel, name)? {
                let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                if !known.contains(&file) {
                    fs::copy(&path, root.join("modules").join(&file))?;
                    order += &format!("{file}\n");
                    known.push(file);
                }
            }
        }
        fs::write(root.join("modules").join(list), order)?;
    }
    let pack = format!("cd {} && find . | cpio -o -H newc --quiet | gzip -1 > ../initial.gz", root.display());
    run("sh", &["-c", &pack])
}

/// The files of a module and of all that it needs, in the order in which they are loaded.
fn needed(kernel: &Kernel, module: &str) -> Result<Vec<PathBuf>> {
    let base = format!("{FOLDER}/kernel");
    let args = ["-d", &base, "-S", &kernel.version, "--show-depends", module];
    let output = Command::new("modprobe").args(args).output()?;
    ensure!(output.status.success(), "the kernel has no module {module}");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    Ok(text.lines().filter_map(|line| line.trim().strip_prefix("insmod ")).map(|path| path.trim().into()).collect())
}

fn boot(kernel: &Kernel, script: &Path) -> Result<()> {
    let path = std::env::var("PATH").unwrap_or_default();
    // Where other programs keep this machine busy, the emulated timer is late and the kernel takes it for broken.
    let line = format!(
        "console=ttyS0 quiet panic=-1 no_timer_check canvass_script={} canvass_path={path}:/usr/sbin:/sbin",
        script.display()
    );
    let out = fs::canonicalize(OUT)?;
    let out = format!("local,path={},mount_tag=out,security_model=none", out.display());
    let image = kernel.image.to_string_lossy().into_owned();
    let initial = format!("{FOLDER}/initial.gz");
    eprintln!("$ qemu-system-x86_64 -kernel {image}");
    let status = Command::new("timeout")
        .args(["900", "qemu-system-x86_64", "-accel", "tcg,thread=multi", "-smp", "2", "-m", "2048"])
        .args(["-nographic", "-no-reboot", "-kernel", &image, "-initrd", &initial, "-append", &line])
        .args(["-virtfs", "local,path=/,mount_tag=files,security_model=none,readonly=on,multidevs=remap"])
        .args(["-virtfs", &out])
        .stdin(Stdio::null())
        .status()?;
    if !status.success() {
        bail!("qemu-system-x86_64 ended with {status}");
    }
    Ok(())
}
