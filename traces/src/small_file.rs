//! Files that canvass reads into memory as a whole: descriptions, waivers, results, journals. A limit stops the reading
//! of `/dev/zero`, or of a capture named by mistake.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Limit for files that a person or a configuration tool writes, in bytes: 16 MiB.
pub const OF_HAND: u64 = 16 << 20;
/// Limit for files that a program writes, such as a result with its frames, in bytes: 128 MiB.
pub const OF_PROGRAM: u64 = 128 << 20;
/// Limit for a bundle, which holds all frames of a run, in bytes: 1 GiB.
pub const OF_BUNDLE: u64 = 1 << 30;

/// Reads a whole file.
///
/// # Errors
/// The system's error; [`io::ErrorKind::FileTooLarge`] for a file of more than `most` bytes.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let reason = format!("the file is larger than {} MiB", most >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(bytes)
}

/// Reads a whole text file.
///
/// # Errors
/// See [`read`]; [`io::ErrorKind::InvalidData`] for text that is not UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(read(path, most)?).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_is_read_than_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert_eq!(read(&path, 4).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        std::fs::write(&path, [0xFF]).unwrap();
        assert_eq!(read_text(&path, 5).unwrap_err().kind(), io::ErrorKind::InvalidData);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_without_end() {
        let error = read(Path::new("/dev/zero"), 1 << 20).unwrap_err();
        assert_eq!(error.to_string(), "the file is larger than 1 MiB");
    }
}
