//! Reasons why a kernel offers no CAN.

use flate2::read::GzDecoder;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Facts about the running kernel, from files of this machine.
#[derive(Default)]
struct Kernel {
    /// The release of the kernel, as `uname -r` prints it.
    release: String,
    /// The build configuration, if the kernel publishes it in `/proc/config.gz` or `/boot/config-RELEASE`.
    config: Option<String>,
    /// Whether the kernel can load modules.
    has_modules: bool,
    /// Whether modules of this kernel are installed.
    has_folder: bool,
    /// Whether the module `can-raw` is installed.
    has_module: bool,
}

/// Why there is no CAN, and what to do.
pub fn why_no_can() -> String {
    Kernel::here().why_no_can()
}

impl Kernel {
    fn here() -> Self {
        let release = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default().trim().to_owned();
        let folder = format!("/lib/modules/{release}");
        let is_there = |ending: &&str| Path::new(&format!("{folder}/kernel/net/can/can-raw.ko{ending}")).exists();
        Self {
            config: unpacked("/proc/config.gz").or_else(|| fs::read_to_string(format!("/boot/config-{release}")).ok()),
            has_modules: Path::new("/proc/modules").exists(),
            has_folder: Path::new(&folder).exists(),
            has_module: ["", ".xz", ".zst", ".gz"].iter().any(is_there),
            release,
        }
    }

    /// The value of a build option: `y`, `m`, or `n` if not set; `None` if the configuration is unknown.
    fn option(&self, name: &str) -> Option<&str> {
        let config = self.config.as_deref()?;
        let value = |line: &'_ str| line.strip_prefix(name).is_some_and(|rest| rest.starts_with('='));
        Some(config.lines().find(|line| value(line)).and_then(|line| line.split('=').nth(1)).unwrap_or("n"))
    }

    fn why_no_can(&self) -> String {
        const ELSE: &str = "boot a kernel with CAN, or use a serial adapter by slcan:PORT";
        let release = &self.release;
        let missing = ["CONFIG_CAN", "CONFIG_CAN_RAW"].into_iter().find(|name| self.option(name) == Some("n"));
        if let Some(missing) = missing {
            return format!("kernel {release} was built without CAN ({missing} is not set): {ELSE}");
        }
        if !self.has_modules {
            return format!("kernel {release} has no CAN and can't load modules (there is no /proc/modules): {ELSE}");
        }
        if self.has_module {
            return "the kernel's module can-raw is installed but not loaded: run modprobe can-raw as root".to_owned();
        }
        if self.has_folder {
            return format!("kernel {release} has no module net/can/can-raw.ko in /lib/modules/{release}: {ELSE}");
        }
        format!(
            "no CAN is loaded, and the modules of kernel {release} are not installed (/lib/modules/{release} does not exist): \
             install them; in a container, modprobe can-raw on its host"
        )
    }
}

/// Limit for reading a kernel's configuration, which usually has some 200 KiB.
const LONGEST: u64 = 16 << 20;

fn unpacked(path: &str) -> Option<String> {
    let mut text = String::new();
    GzDecoder::new(File::open(path).ok()?).take(LONGEST).read_to_string(&mut text).ok()?;
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(config: &str) -> Kernel {
        Kernel { release: "6.1.0".to_owned(), config: Some(config.to_owned()), ..Kernel::default() }
    }

    #[test]
    fn every_reason_is_told_apart() {
        let unset = kernel("CONFIG_NET=y\n# CONFIG_CAN is not set\nCONFIG_CANDY=y\n").why_no_can();
        assert!(unset.starts_with("kernel 6.1.0 was built without CAN (CONFIG_CAN is not set)"), "{unset}");
        let no_raw = kernel("CONFIG_CAN=m\n# CONFIG_CAN_RAW is not set\n").why_no_can();
        assert!(no_raw.contains("(CONFIG_CAN_RAW is not set)"), "{no_raw}");
        let modular = || kernel("CONFIG_CAN=m\nCONFIG_CAN_RAW=m\n");
        assert!(modular().why_no_can().contains("can't load modules"));
        let not_installed = Kernel { has_modules: true, ..modular() }.why_no_can();
        assert!(not_installed.contains("/lib/modules/6.1.0 does not exist"), "{not_installed}");
        let lacking = Kernel { has_modules: true, has_folder: true, ..modular() }.why_no_can();
        assert!(lacking.contains("no module net/can/can-raw.ko"), "{lacking}");
        let idle = Kernel { has_modules: true, has_folder: true, has_module: true, ..modular() }.why_no_can();
        assert!(idle.contains("modprobe can-raw"), "{idle}");
        let silent = Kernel { config: None, ..modular() }.why_no_can();
        assert!(silent.contains("there is no /proc/modules"), "{silent}");
    }
}
