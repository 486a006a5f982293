//! ZIP archives in the form that bundles have: each file uncompressed, with no bytes between, before or after the
//! files.
//!
//! The names and contents of the files determine every byte of such an archive. So a changed byte always shows: the
//! archive then differs from the output of [`write`]. (APPNOTE.TXT 6.3.10, sections 4.3.7, 4.3.12 and 4.3.16.)

use anyhow::{Context, Result, anyhow, bail};
use flate2::Crc;

const LOCAL: u32 = 0x0403_4B50;
const CENTRAL: u32 = 0x0201_4B50;
const END: u32 = 0x0605_4B50;
const END_LENGTH: usize = 22;
/// Version 2.0 of the format, which every program reads.
const VERSION: u16 = 20;
/// 1 January 1980, the first date of the format: the archive must not depend on the time of packing.
const DATE: u16 = 0x0021;

/// A file in an archive.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Entry {
    /// The file's name, of letters, digits, `.`, `-` and `_`; archives have no folders.
    pub name: String,
    /// The bytes of the file.
    pub content: Vec<u8>,
}

/// Makes an archive of the files.
///
/// # Errors
/// If a file or the archive is longer than 4 GiB, or there are more than 65535 files: the format has no room for more.
pub fn write(entries: &[Entry]) -> Result<Vec<u8>> {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    for entry in entries {
        let offset = u32::try_from(archive.len()).context("a bundle holds at most 4 GiB")?;
        let shared = shared_fields(entry)?;
        archive.extend(LOCAL.to_le_bytes());
        archive.extend(&shared);
        archive.extend(entry.name.as_bytes());
        archive.extend(&entry.content);
        directory.extend(CENTRAL.to_le_bytes());
        directory.extend(VERSION.to_le_bytes());
        directory.extend(&shared);
        // The last fields: disk number, attributes and comment, all 0.
        directory.extend([0; 2 + 2 + 2 + 4]);
        directory.extend(offset.to_le_bytes());
        directory.extend(entry.name.as_bytes());
    }
    let count = u16::try_from(entries.len()).context("a bundle holds at most 65535 files")?;
    let begin = u32::try_from(archive.len()).context("a bundle holds at most 4 GiB")?;
    let length = u32::try_from(directory.len()).context("a bundle holds at most 4 GiB")?;
    archive.extend(directory);
    archive.extend(END.to_le_bytes());
    archive.extend([0; 4]);
    archive.extend([count.to_le_bytes(), count.to_le_bytes()].concat());
    archive.extend(length.to_le_bytes());
    archive.extend(begin.to_le_bytes());
    archive.extend([0; 2]);
    Ok(archive)
}

/// The fields that a file's header and its row in the directory share: version, flags, method, time, date, CRC,
/// lengths.
fn shared_fields(entry: &Entry) -> Result<Vec<u8>> {
    let length = u32::try_from(entry.content.len()).with_context(|| format!("{} is longer than 4 GiB", entry.name))?;
    let name = u16::try_from(entry.name.len()).context("a name is too long")?;
    let mut crc = Crc::new();
    crc.update(&entry.content);
    let mut fields = Vec::new();
    for field in [VERSION, 0, 0, 0, DATE] {
        fields.extend(field.to_le_bytes());
    }
    for field in [crc.sum(), length, length] {
        fields.extend(field.to_le_bytes());
    }
    fields.extend(name.to_le_bytes());
    fields.extend([0; 2]);
    Ok(fields)
}

/// Reads the files that the archive's directory lists. [`changed`] then tells whether the archive is as [`write`] makes
/// it.
///
/// # Errors
/// If the bytes are no archive, or the archive was cut.
pub fn read(archive: &[u8]) -> Result<Vec<Entry>> {
    let end = archive.len().checked_sub(END_LENGTH).context("the file is too short for an archive")?;
    if number(archive, end)? != END {
        bail!("the end of the archive is missing or was changed: the file was cut, or is no bundle");
    }
    let mut at = number(archive, end + 16)? as usize;
    let mut entries: Vec<Entry> = Vec::new();
    while at < end {
        if number(archive, at)? != CENTRAL {
            bail!("the archive's directory was changed");
        }
        let (length, offset) = (number(archive, at + 20)? as usize, number(archive, at + 42)? as usize);
        let name_length = (number(archive, at + 28)? & 0xFFFF) as usize;
        let name = bytes(archive, at + 46, name_length)?;
        let name = std::str::from_utf8(name).ok().filter(|name| is_name(name));
        let name = name.context("the archive's directory was changed: expected names of files, found another text")?;
        if entries.iter().any(|known| known.name == name) {
            bail!("the archive's directory was changed: it lists {name} twice");
        }
        let content = bytes(archive, offset + 30 + name_length, length);
        let content = content.with_context(|| format!("{name} was changed: its place or length is wrong"))?;
        entries.push(Entry { name: name.to_owned(), content: content.to_vec() });
        at += 46 + name_length;
    }
    Ok(entries)
}

/// Whether a name stays in the folder into which the archive is unpacked.
fn is_name(name: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    !name.is_empty() && name.len() <= 100 && !name.starts_with('.') && name.chars().all(is_plain)
}

fn bytes(archive: &[u8], at: usize, length: usize) -> Result<&[u8]> {
    let end = at.checked_add(length);
    end.and_then(|end| archive.get(at..end)).ok_or_else(|| anyhow!("the archive was cut, or its directory was changed"))
}

fn number(archive: &[u8], at: usize) -> Result<u32> {
    let found = bytes(archive, at, 4)?.first_chunk();
    found.map(|bytes| u32::from_le_bytes(*bytes)).context("the archive was cut")
}

/// Name of the first file that differs from the output of [`write`], or `directory`; `None` if all is unchanged.
///
/// # Errors
/// As [`write`].
pub fn changed(archive: &[u8], entries: &[Entry]) -> Result<Option<String>> {
    let written = write(entries)?;
    let differs = || archive.iter().zip(&written).position(|(found, expected)| found != expected);
    let at = if archive == written { None } else { Some(differs().unwrap_or(archive.len().min(written.len()))) };
    let Some(at) = at else { return Ok(None) };
    let mut end = 0;
    let holds = |entry: &&Entry| {
        end += 30 + entry.name.len() + entry.content.len();
        at < end
    };
    let entry = entries.iter().find(holds);
    Ok(Some(entry.map_or_else(|| "directory".to_owned(), |entry| entry.name.clone())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries() -> Vec<Entry> {
        let entry = |name: &str, content: &[u8]| Entry { name: name.to_owned(), content: content.to_vec() };
        vec![entry("a.txt", b"abc"), entry("empty", b""), entry("b-2.bin", &[0, 1, 2, 255])]
    }

    #[test]
    fn what_is_packed_is_unpacked() {
        let archive = write(&entries()).unwrap();
        assert_eq!(read(&archive).unwrap(), entries());
        assert_eq!(changed(&archive, &entries()).unwrap(), None);
    }

    /// Any change of any byte is detected: reading fails, reading gives other files, or `changed` names the place.
    #[test]
    fn each_changed_byte_shows() {
        let archive = write(&entries()).unwrap();
        for at in 0..archive.len() {
            for bit in 0..8 {
                let mut other = archive.clone();
                other[at] ^= 1 << bit;
                let Ok(found) = read(&other) else { continue };
                let differs = found != entries() || changed(&other, &found).unwrap().is_some();
                assert!(differs, "byte {at}, bit {bit}");
            }
        }
        for cut in 0..archive.len() {
            assert!(read(&archive[..cut]).is_err(), "{cut}");
        }
        let longer = [&archive[..], &[0]].concat();
        assert!(read(&longer).is_err());
    }

    #[test]
    fn nothing_leaves_its_folder() {
        for name in ["../x", "/etc/passwd", "a/b", "", ".hidden", "a\\b", "c:x"] {
            let archive = write(&[Entry { name: name.to_owned(), content: Vec::new() }]).unwrap();
            assert!(read(&archive).is_err(), "{name}");
        }
    }
}
