//! The input files of a result, with their hashes.

use canvass_device::MotionSpec;
use canvass_device::address::{BusAddress, DeviceName, SimulatedDevice};
use canvass_device::models::Model;
use canvass_reports::provenance::FileUsed;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

/// The file with its hash. Pipes and standard input have no hash, as they can't be read twice; nor has an unreadable
/// file, which is reported when it is opened.
pub fn used(role: &'static str, path: &Path) -> FileUsed {
    let is_file = std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file());
    let content = is_file.then(|| File::open(path).and_then(hash).ok()).flatten();
    FileUsed { role, path: path.display().to_string(), content }
}

/// Hashes large files in a thread while the command reads them.
pub struct Hashes {
    thread: Option<JoinHandle<Vec<FileUsed>>>,
    role: &'static str,
    paths: Vec<PathBuf>,
}

impl Hashes {
    /// Starts hashing.
    pub fn begin(role: &'static str, paths: &[PathBuf]) -> Self {
        let (paths, own) = (paths.to_vec(), paths.to_vec());
        let hash = move || own.iter().map(|path| used(role, path)).collect();
        let thread = std::thread::Builder::new().name("hash".to_owned()).spawn(hash).ok();
        Self { thread, role, paths }
    }

    /// Waits for the hashes.
    pub fn finish(self) -> Vec<FileUsed> {
        let hashed = self.thread.and_then(|thread| thread.join().ok());
        hashed.unwrap_or_else(|| self.paths.iter().map(|path| used(self.role, path)).collect())
    }
}

/// The length of the data, and its SHA-256 in hexadecimal.
pub fn hash(mut file: impl Read) -> io::Result<(u64, String)> {
    let (mut hasher, mut length) = (Sha256::new(), 0);
    let mut buffer = vec![0; 64 * 1024];
    loop {
        let read = file.read(&mut buffer)?;
        if read == 0 {
            break;
        }
        hasher.update(buffer.get(..read).unwrap_or_default());
        length += read as u64;
    }
    Ok((length, hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()))
}

/// The file that describes a device; `None` for a built-in model.
pub fn of_device(device: &str) -> Option<&str> {
    let device = crate::devices::named(device);
    Model::by_id(device).is_none().then_some(device)
}

/// The files that the address of a simulated bus names.
pub fn of_bus(address: &str) -> Vec<(&'static str, String)> {
    let Ok(BusAddress::Simulated(devices)) = address.parse() else { return Vec::new() };
    let of_device = |device: SimulatedDevice| {
        let description = match device.device {
            DeviceName::File(path) => Some(("description", path)),
            DeviceName::Model(_) => None,
        };
        let motion = match device.motion {
            Some(MotionSpec::File(path)) => Some(("motion", path)),
            _ => None,
        };
        [description, motion]
    };
    devices.into_iter().flat_map(of_device).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From FIPS 180-2, appendix B.1.
    #[test]
    fn the_hash_is_sha_256() {
        let (length, sha256) = hash(&b"abc"[..]).unwrap();
        assert_eq!(length, 3);
        assert_eq!(sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn what_is_not_a_file_has_no_hash() {
        assert_eq!(used("capture", Path::new("-")).content, None);
        assert_eq!(used("capture", Path::new("/dev/null")).content, None);
        assert_eq!(of_device("63=kuebler-sendix-58x8"), None);
        assert_eq!(of_device("5=motor.eds"), Some("motor.eds"));
    }
}
