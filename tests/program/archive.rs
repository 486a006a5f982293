//! ZIP archives of stored files, written and read independently of the program's own code.

use sha2::{Digest, Sha256};

/// The SHA-256 of the content in hexadecimal.
pub fn sha256(content: &[u8]) -> String {
    Sha256::digest(content).iter().map(|byte| format!("{byte:02x}")).collect()
}

fn little(bytes: &[u8]) -> usize {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte))
}

/// The files by their local headers, one after the other.
pub fn files(archive: &[u8]) -> Vec<(String, Vec<u8>)> {
    let (mut rest, mut files) = (archive, Vec::new());
    while rest.starts_with(b"PK\x03\x04") {
        let (name_length, length) = (little(&rest[26..28]), little(&rest[18..22]));
        let (name, content) = rest[30..].split_at(name_length);
        files.push((String::from_utf8(name.to_vec()).unwrap(), content[..length].to_vec()));
        rest = &content[length..];
    }
    files
}

/// An archive of these files.
pub fn pack(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let mut crc = flate2::Crc::new();
        crc.update(content);
        let length = (content.len() as u32).to_le_bytes();
        let mut shared = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        shared.extend([crc.sum().to_le_bytes(), length, length].concat());
        shared.extend([name.len() as u8, 0, 0, 0]);
        directory.extend([b"PK\x01\x02\x14\x00", &shared[..], &[0; 10]].concat());
        directory.extend((archive.len() as u32).to_le_bytes());
        directory.extend(name.as_bytes());
        archive.extend([b"PK\x03\x04", &shared[..], name.as_bytes(), content].concat());
    }
    let (count, begin) = (files.len() as u8, (archive.len() as u32).to_le_bytes());
    let length = (directory.len() as u32).to_le_bytes();
    archive.extend(directory);
    archive.extend([b"PK\x05\x06", &[0, 0, 0, 0, count, 0, count, 0][..], &length, &begin, &[0, 0]].concat());
    archive
}
