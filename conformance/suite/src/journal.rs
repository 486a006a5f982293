//! The journal of a run: each change with the value before it, on the disk before the change is made, so that a device
//! can be put back even if the tester is killed or its machine loses power.
//!
//! ```text
//! canvass journal 1
//! bus can0
//! node 10
//! device motor.eds
//! operational yes
//! value 1017:00 E803      the dictionary before the first case
//! zero-point 6003:00 6004:00 8192 100 0 7 -   objects of preset and position, range; position, spread, offset, raw
//! begun
//! stored 1017:00 D007     the value after a start
//! stored-zero-point 6003:00 6004:00 8192 93 0 0 -
//! value 2041:00 41010000  an object that the dictionary does not hold, before a case wrote it
//! case 301/store/all      a case begins that may store values or change the node-ID or bit rate
//! stores                  before the device was told to write its non-volatile memory
//! settled                 the case has put back all its changes
//! ```
//!
//! A last line without line end is incomplete: its change was not made.

use crate::zero_point::ZeroPoint;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::hex;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

const FIRST_LINE: &str = "canvass journal 1";

/// The journal of a run in progress.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Objects whose earlier value is in the journal.
    known: BTreeSet<Multiplexer>,
    /// Whether a case has begun that may leave more behind than values; `stores`: whether this case has told the device
    /// to store.
    open: bool,
    stores: bool,
}

/// The facts about the run at the begin of its journal.
pub struct Head<'a> {
    /// The bus, as the user addressed it.
    pub bus: &'a str,
    /// The node-ID of the device.
    pub node: NodeId,
    /// The model or file that describes the device; empty if there is none.
    pub device: &'a str,
    /// Whether the device is operational.
    pub operational: bool,
    /// The values before the first change.
    pub dictionary: &'a [(Multiplexer, Vec<u8>)],
    /// The zero point before the first change.
    pub zero_point: Option<&'a ZeroPoint>,
}

impl Journal {
    /// Creates the journal, before the first change. Does not replace a file.
    ///
    /// # Errors
    /// If the file exists or can't be written.
    pub fn create(path: &Path, head: &Head<'_>) -> io::Result<Self> {
        let one_line = |text: &str| text.replace(['\n', '\r'], " ");
        let (bus, device) = (one_line(head.bus), one_line(head.device));
        let mut text = format!("{FIRST_LINE}\nbus {bus}\nnode {}\ndevice {device}\n", head.node);
        // Writing to a string can't fail.
        let _ = writeln!(text, "operational {}", if head.operational { "yes" } else { "no" });
        head.dictionary.iter().for_each(|(multiplexer, value)| value_line(&mut text, "value", *multiplexer, value));
        head.zero_point.iter().for_each(|zero_point| text.push_str(&format!("zero-point {zero_point}\n")));
        text.push_str("begun\n");
        let file = begin(path, text.as_bytes())?;
        let known = head.dictionary.iter().map(|(multiplexer, _)| *multiplexer).collect();
        Ok(Self { path: path.to_owned(), file, known, open: false, stores: false })
    }

    /// Records an object that is about to be written, with its earlier value.
    pub(crate) fn value(&mut self, multiplexer: Multiplexer, value: &[u8]) -> io::Result<()> {
        if !self.known.insert(multiplexer) {
            return Ok(());
        }
        let mut line = String::new();
        value_line(&mut line, "value", multiplexer, value);
        self.append(&line)
    }

    /// Records the values that a start loads, before any case has run.
    pub(crate) fn memory<'a>(
        &mut self,
        stored: impl IntoIterator<Item = (Multiplexer, &'a [u8])>,
        zero_point: Option<&ZeroPoint>,
    ) -> io::Result<()> {
        let mut lines = String::new();
        stored.into_iter().for_each(|(multiplexer, value)| value_line(&mut lines, "stored", multiplexer, value));
        zero_point.iter().for_each(|zero_point| lines.push_str(&format!("stored-zero-point {zero_point}\n")));
        self.append(&lines)
    }

    /// Records the begin of a case that may store values or change the node-ID or bit rate.
    pub(crate) fn begin(&mut self, case: &str) -> io::Result<()> {
        self.open = true;
        self.append(&format!("case {case}\n"))
    }

    /// Records that the device is about to be told to write its non-volatile memory.
    ///
    /// # Errors
    /// If the file can't be written.
    pub fn store(&mut self) -> io::Result<()> {
        if std::mem::replace(&mut self.stores, true) { Ok(()) } else { self.append("stores\n") }
    }

    /// Records that the case has ended and has put back its changes.
    pub(crate) fn settle(&mut self) -> io::Result<()> {
        self.stores = false;
        if std::mem::take(&mut self.open) { self.append("settled\n") } else { Ok(()) }
    }

    /// Removes the journal: the device is as before the run, or its changes are wanted.
    ///
    /// # Errors
    /// If the file can't be removed.
    pub fn remove(self) -> io::Result<()> {
        fs::remove_file(&self.path)
    }

    /// The path of the journal file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn append(&mut self, lines: &str) -> io::Result<()> {
        self.file.write_all(lines.as_bytes())?;
        self.file.sync_data()
    }
}

/// Creates a file with these bytes. Whenever the run is killed, the file has all the bytes or does not exist. Does not
/// replace a file.
fn begin(path: &Path, bytes: &[u8]) -> io::Result<File> {
    let mut name = path.as_os_str().to_owned();
    name.push(".canvass-new");
    let new = PathBuf::from(name);
    let mut file = File::create(&new)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    let linked = fs::hard_link(&new, path);
    fs::remove_file(&new)?;
    match linked {
        Ok(()) => Ok(file),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        // Not every file system supports hard links.
        Err(_) => {
            let mut file = File::options().write(true).create_new(true).open(path)?;
            file.write_all(bytes)?;
            file.sync_all()?;
            Ok(file)
        }
    }
}

fn value_line(text: &mut String, word: &str, multiplexer: Multiplexer, value: &[u8]) {
    let _ = writeln!(text, "{word} {:04X}:{:02X} {}", multiplexer.index.0, multiplexer.sub.0, hex::compact(value));
}

/// An interrupted run, read from its journal.
#[derive(Clone, Debug)]
pub struct Interrupted {
    /// The bus, as the user addressed it.
    pub bus: String,
    /// The node-ID of the device.
    pub node: NodeId,
    /// The model or file that the user gave for the device; empty if there was none.
    pub device: String,
    /// Whether the device was operational before the run.
    pub operational: bool,
    /// The values before the run.
    pub values: Vec<(Multiplexer, Vec<u8>)>,
    /// The values that a start loaded before the first case; empty if the run ended before they were read.
    pub(crate) memory: Vec<(Multiplexer, Vec<u8>)>,
    /// The zero points in use and after a start, before the first case.
    pub(crate) zero_point: Option<ZeroPoint>,
    pub(crate) stored_zero_point: Option<ZeroPoint>,
    /// The earlier values of objects that the dictionary does not hold.
    pub(crate) more: Vec<(Multiplexer, Vec<u8>)>,
    /// The id of the case that was under way, if it may have left more than values.
    pub(crate) case: Option<String>,
    /// Whether the device was told to write its non-volatile memory, and so other values may be stored.
    pub(crate) stored: bool,
    /// Whether a case has begun. Before that nothing is changed.
    pub begun: bool,
}

/// The reason why a file is no journal.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {line} of the journal: expected {expected}, found \"{found}\"")]
pub struct BadJournal {
    /// The line, counted from 1.
    pub line: usize,
    /// The correct content of the line.
    pub expected: &'static str,
    /// The actual content of the line.
    pub found: String,
}

impl Interrupted {
    /// Reads a journal.
    ///
    /// # Errors
    /// [`BadJournal`] if the text is no journal.
    pub fn read(text: &str) -> Result<Self, BadJournal> {
        let mut read = Self {
            bus: String::new(),
            node: NodeId::MAX,
            device: String::new(),
            operational: false,
            values: Vec::new(),
            memory: Vec::new(),
            zero_point: None,
            stored_zero_point: None,
            more: Vec::new(),
            case: None,
            stored: false,
            begun: false,
        };
        // A text after the last line end was not written completely.
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        let mut lines = whole.lines().enumerate();
        let bad = |line: usize, expected, found: &str| BadJournal { line, expected, found: found.to_owned() };
        match lines.next() {
            Some((_, FIRST_LINE)) => {}
            first => return Err(bad(1, "the first line of a journal", first.map_or("", |(_, line)| line))),
        }
        for (at, line) in lines {
            read.take(line).map_err(|expected| bad(at + 1, expected, line))?;
        }
        Ok(read)
    }

    fn take(&mut self, line: &str) -> Result<(), &'static str> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "bus" => rest.clone_into(&mut self.bus),
            "node" => self.node = rest.parse().ok().and_then(NodeId::new).ok_or("a node-ID of 1 to 127")?,
            "device" => rest.clone_into(&mut self.device),
            "operational" => self.operational = rest == "yes",
            "value" if self.begun => self.more.push(value(rest)?),
            "value" => self.values.push(value(rest)?),
            "zero-point" => self.zero_point = Some(rest.parse()?),
            "begun" => self.begun = true,
            "stored" => self.memory.push(value(rest)?),
            "stored-zero-point" => self.stored_zero_point = Some(rest.parse()?),
            "case" => self.case = Some(rest.to_owned()),
            "stores" => self.stored = true,
            "settled" => (self.case, self.stored) = (None, false),
            _ => {
                return Err(
                    "bus, node, device, operational, value, zero-point, begun, stored, stored-zero-point, case, stores \
                            or settled",
                );
            }
        }
        Ok(())
    }
}

/// `1017:00 E803`
fn value(text: &str) -> Result<(Multiplexer, Vec<u8>), &'static str> {
    let expected = "an object and its bytes, such as 1017:00 E803";
    let (object, digits) = text.split_once(' ').ok_or(expected)?;
    let (index, sub) = object.split_once(':').ok_or(expected)?;
    let index = u16::from_str_radix(index, 16).map_err(|_| expected)?;
    let sub = u8::from_str_radix(sub, 16).map_err(|_| expected)?;
    Ok((Multiplexer::new(index, sub), hex::parse(digits).ok_or(expected)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;

    fn head(dictionary: &[(Multiplexer, Vec<u8>)]) -> Head<'_> {
        let node = NodeId::new(10).unwrap();
        Head { bus: "can0", node, device: "my device.eds", operational: true, dictionary, zero_point: None }
    }

    #[test]
    fn what_was_written_is_read_up_to_any_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let (heartbeat, other) = (Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), Multiplexer::new(0x2041, 3));
        let dictionary = [(heartbeat, vec![0xE8, 3])];
        let zero_point: ZeroPoint = "6003:00 6004:00 8192 100 0 7 -".parse().unwrap();
        let before = Head { zero_point: Some(&zero_point), ..head(&dictionary) };
        let mut journal = Journal::create(&path, &before).unwrap();
        let stored_zero_point: ZeroPoint = "6003:00 6004:00 8192 93 0 0 -".parse().unwrap();
        journal.memory([(heartbeat, &[0xD0, 7][..])], Some(&stored_zero_point)).unwrap();
        journal.value(heartbeat, &[9, 9]).unwrap();
        journal.value(other, &[]).unwrap();
        let case = "301/store/all";
        journal.begin(case).unwrap();
        journal.store().unwrap();
        journal.store().unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let read = Interrupted::read(&text).unwrap();
        assert_eq!((&*read.bus, read.node.raw(), &*read.device, read.operational), ("can0", 10, "my device.eds", true));
        assert_eq!((read.values, read.more), (dictionary.to_vec(), vec![(other, vec![])]));
        assert_eq!(read.memory, [(heartbeat, vec![0xD0, 7])]);
        assert_eq!((read.zero_point, read.stored_zero_point), (Some(zero_point), Some(stored_zero_point)));
        assert_eq!((read.case.as_deref(), read.stored, read.begun), (Some(case), true, true));
        journal.settle().unwrap();
        let settled = Interrupted::read(&fs::read_to_string(&path).unwrap()).unwrap();
        assert_eq!((settled.case.is_none(), settled.stored), (true, false));
        for cut in FIRST_LINE.len() + 1..text.len() {
            assert!(Interrupted::read(&text[..cut]).is_ok(), "cut at {cut}");
        }
        // An earlier run was killed before its journal had its final name.
        fs::write(folder.path().join("journal.canvass-new"), "canvass").unwrap();
        assert!(Journal::create(&path, &head(&[])).is_err(), "an earlier run's is kept");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
        journal.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn other_files_are_none() {
        for text in ["", "something\n", "canvass journal 1\nvalue 1017:00 E8031\n", "canvass journal 1\nnode 300\n"] {
            assert!(Interrupted::read(text).is_err(), "{text}");
        }
    }
}
