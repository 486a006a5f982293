//! Debian's kernel and its CAN modules.

use super::FOLDER;
use crate::run::run;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A kernel, unpacked.
pub struct Kernel {
    /// The image that QEMU starts.
    pub image: PathBuf,
    version: String,
}

/// The modules, in the order of their dependencies: SocketCAN, virtual interfaces, a controller that QEMU emulates,
/// SLCAN. python-can sends heartbeats by can-bcm.
const MODULES: [&str; 7] = ["can", "can-raw", "can-bcm", "can-dev", "vcan", "kvaser_pci", "slcan"];

impl Kernel {
    /// Debian's newest kernel, fetched by apt-get the first time.
    pub fn fetch() -> Result<Self> {
        let modules = format!("{FOLDER}/kernel/lib/modules");
        if !Path::new(&modules).exists() {
            unpack(&download()?)?;
        }
        let version = fs::read_dir(&modules)?.flatten().next().context("the kernel has no modules")?;
        let version = version.file_name().to_string_lossy().into_owned();
        if !Path::new(&format!("{modules}/{version}/modules.dep")).exists() {
            run("depmod", &["-b", &format!("{FOLDER}/kernel"), &version])?;
        }
        Ok(Self { image: format!("{FOLDER}/kernel/boot/vmlinuz-{version}").into(), version })
    }

    /// The files of the modules and their dependencies, in the order in which they are loaded.
    pub fn modules(&self) -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        for module in MODULES {
            let base = format!("{FOLDER}/kernel");
            let args = ["-d", &base, "-S", &self.version, "--show-depends", module];
            let output = Command::new("modprobe").args(args).output()?;
            ensure!(output.status.success(), "Debian's kernel has no module {module}");
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            for file in text.lines().filter_map(|line| line.trim().strip_prefix("insmod ")) {
                let file = PathBuf::from(file.trim());
                if !files.contains(&file) {
                    files.push(file);
                }
            }
        }
        Ok(files)
    }
}

/// Downloads the package into the folder.
fn download() -> Result<PathBuf> {
    let newest = || -> Result<Option<String>> {
        let depends = Command::new("apt-cache").args(["depends", "linux-image-amd64"]).output()?;
        let depends = String::from_utf8_lossy(&depends.stdout).into_owned();
        Ok(depends.lines().find_map(|line| line.trim().strip_prefix("Depends: ").map(str::to_owned)))
    };
    let package = match newest()? {
        Some(package) => package,
        None => {
            run("apt-get", &["update", "-qq"])?;
            newest()?.context("apt knows no linux-image-amd64: Debian's package sources are needed for its kernel")?
        }
    };
    fs::create_dir_all(FOLDER)?;
    eprintln!("$ apt-get download {package}");
    let status = Command::new("apt-get").args(["download", "-qq", &package]).current_dir(FOLDER).status()?;
    ensure!(status.success(), "{package} could not be fetched: {status}; is Debian's mirror reachable?");
    let mut files = fs::read_dir(FOLDER)?.flatten().map(|entry| entry.path());
    files
        .find(|path| path.extension().is_some_and(|extension| extension == "deb"))
        .context("apt-get fetched no package")
}

/// Unpacks the package under another name first, so that an interrupted run leaves no incomplete kernel.
fn unpack(package: &Path) -> Result<()> {
    let unfinished = format!("{FOLDER}/unpacked");
    let _ = fs::remove_dir_all(&unfinished);
    run("dpkg-deb", &["--extract", &package.to_string_lossy(), &unfinished])?;
    fs::rename(&unfinished, format!("{FOLDER}/kernel"))?;
    fs::remove_file(package)?;
    Ok(())
}
