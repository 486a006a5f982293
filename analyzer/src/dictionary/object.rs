//! Objects and their entries in a device description.

use std::fmt;

use super::data_type::DataType;
use super::place::SectionId;
use super::value::Value;
use crate::identity::{Index, Multiplexer, NodeId, SubIndex};

/// The object code (CiA 301 and 306, `ObjectType`). It can hold any number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ObjectCode(pub u8);

impl ObjectCode {
    /// An object without data.
    pub const NULL: Self = Self(0);
    /// A large amount of data.
    pub const DOMAIN: Self = Self(2);
    /// The definition of a type.
    pub(crate) const DEFTYPE: Self = Self(5);
    /// The definition of a record type.
    pub(crate) const DEFSTRUCT: Self = Self(6);
    /// A single value.
    pub const VAR: Self = Self(7);
    /// Entries of the same type.
    pub const ARRAY: Self = Self(8);
    /// Entries of any types.
    pub const RECORD: Self = Self(9);

    /// The name of the object code in CiA 301; `None` if the code is unknown.
    pub const fn name(self) -> Option<&'static str> {
        Some(match self {
            Self::NULL => "NULL",
            Self::DOMAIN => "DOMAIN",
            Self::DEFTYPE => "DEFTYPE",
            Self::DEFSTRUCT => "DEFSTRUCT",
            Self::VAR => "VAR",
            Self::ARRAY => "ARRAY",
            Self::RECORD => "RECORD",
            _ => return None,
        })
    }

    /// Whether the object's value is at sub-index 0 itself, not after a count of entries.
    pub const fn is_single(self) -> bool {
        !matches!(self, Self::ARRAY | Self::RECORD | Self::DEFSTRUCT)
    }
}

/// `VAR`, or `object code 3`.
impl fmt::Display for ObjectCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => write!(f, "object code {}", self.0),
        }
    }
}

/// The access type of an entry (CiA 306, `AccessType`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// Read only, and never changes.
    Const,
    /// Read only.
    Ro,
    /// Write only.
    Wo,
    /// Read and write.
    Rw,
    /// Read and write; in a PDO only as an output of the device (TPDO).
    Rwr,
    /// Read and write; in a PDO only as an input of the device (RPDO).
    Rww,
}

impl Access {
    /// All access types.
    pub const ALL: [Self; 6] = [Self::Const, Self::Ro, Self::Wo, Self::Rw, Self::Rwr, Self::Rww];

    /// The name in CiA 306.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Const => "const",
            Self::Ro => "ro",
            Self::Wo => "wo",
            Self::Rw => "rw",
            Self::Rwr => "rwr",
            Self::Rww => "rww",
        }
    }

    /// The access type of that name, ignoring case.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|access| name.eq_ignore_ascii_case(access.name()))
    }

    /// Whether an SDO may read the entry.
    pub const fn is_readable(self) -> bool {
        !matches!(self, Self::Wo)
    }

    /// Whether an SDO may write the entry.
    pub const fn is_writable(self) -> bool {
        !matches!(self, Self::Const | Self::Ro)
    }

    /// Whether a TPDO may carry the entry.
    pub const fn allows_tpdo(self) -> bool {
        !matches!(self, Self::Wo | Self::Rww)
    }

    /// Whether an RPDO may carry the entry.
    pub const fn allows_rpdo(self) -> bool {
        matches!(self, Self::Wo | Self::Rw | Self::Rww)
    }
}

impl fmt::Display for Access {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A default value or limit: fixed, or a formula with the node-ID.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// The same for every node-ID.
    Fixed(Value),
    /// `$NODEID+offset`.
    NodeIdPlus(u32),
}

impl Setting {
    /// The value for a device of that node-ID, in the data type of its entry.
    pub fn resolve(&self, data_type: DataType, node: NodeId) -> Value {
        match self {
            Self::Fixed(value) => value.clone(),
            Self::NodeIdPlus(offset) => {
                let sum = u64::from(offset.wrapping_add(u32::from(node.raw())));
                Value::from_raw(data_type, sum).unwrap_or(Value::Unsigned(sum))
            }
        }
    }

    /// The value, unless it needs a node-ID.
    pub const fn fixed(&self) -> Option<&Value> {
        match self {
            Self::Fixed(value) => Some(value),
            Self::NodeIdPlus(_) => None,
        }
    }
}

/// `5`, or `$NODEID+180h`.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(value) => fmt::Display::fmt(value, f),
            Self::NodeIdPlus(offset) => write!(f, "$NODEID+{offset:X}h"),
        }
    }
}

/// One sub-index of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The sub-index.
    pub sub: SubIndex,
    /// `ParameterName`. Text of a file; may contain any characters.
    pub name: String,
    /// `DataType`.
    pub data_type: DataType,
    /// `AccessType`.
    pub access: Access,
    /// `PDOMapping`.
    pub pdo_mappable: bool,
    /// `DefaultValue`.
    pub default: Option<Setting>,
    /// `LowLimit`.
    pub low_limit: Option<Setting>,
    /// `HighLimit`.
    pub high_limit: Option<Setting>,
    /// `ParameterValue` of a DCF or XDC: the configured value.
    pub configured: Option<Setting>,
    /// `Denotation` of a DCF: the entry's meaning in the application.
    pub denotation: Option<String>,
    /// `ObjFlags`.
    pub flags: ObjectFlags,
    /// The line of the file at which the entry begins; 0 if no line describes it (`CompactSubObj`).
    pub line: u32,
    /// The section or element that describes the entry.
    pub section: Option<SectionId>,
}

impl Entry {
    /// An entry without limits, default and flags.
    pub fn new(sub: u8, name: impl Into<String>, data_type: DataType, access: Access) -> Self {
        Self {
            sub: SubIndex(sub),
            name: name.into(),
            data_type,
            access,
            pdo_mappable: false,
            default: None,
            low_limit: None,
            high_limit: None,
            configured: None,
            denotation: None,
            flags: ObjectFlags::default(),
            line: 0,
            section: None,
        }
    }

    /// The value after a start with nothing stored: the configured value, else the default.
    pub fn start_value(&self, node: NodeId) -> Option<Value> {
        self.configured.as_ref().or(self.default.as_ref()).map(|setting| setting.resolve(self.data_type, node))
    }
}

/// `ObjFlags` (CiA 306).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ObjectFlags(pub u32);

impl ObjectFlags {
    /// Bit 0: a configuration tool must not write the object when it downloads everything.
    pub const fn refuses_write_on_download(self) -> bool {
        self.0 & 1 != 0
    }

    /// Bit 1: a tool must not read the object when it reads everything.
    pub const fn refuses_read_on_scan(self) -> bool {
        self.0 & 2 != 0
    }
}

/// An object: an index with its entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The index.
    pub index: Index,
    /// `ParameterName`. Text of a file; may contain any characters.
    pub name: String,
    /// `ObjectType`.
    pub code: ObjectCode,
    /// The line of the file at which the object begins; 0 if no line describes it (`CompactPDO`).
    pub line: u32,
    /// The section or element that describes the object.
    pub section: Option<SectionId>,
    entries: Vec<Entry>,
}

impl Object {
    /// An object without entries.
    pub fn new(index: u16, name: impl Into<String>, code: ObjectCode) -> Self {
        Self { index: Index(index), name: name.into(), code, line: 0, section: None, entries: Vec::new() }
    }

    /// Reserves memory: an entry takes some hundred bytes, so growing step by step would copy much.
    pub(super) fn expect_entries(&mut self, count: usize) {
        self.entries.reserve_exact(count);
    }

    /// The entries, by rising sub-index. A VAR has one, with sub-index 0.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The entry of that sub-index.
    pub fn entry(&self, sub: SubIndex) -> Option<&Entry> {
        // Most objects have no gaps, so the index of an entry is its sub-index.
        match self.entries.get(usize::from(sub.0)) {
            Some(entry) if entry.sub == sub => Some(entry),
            _ => self.entries.get(self.position(sub).ok()?),
        }
    }

    /// The entry of that sub-index, to change.
    pub fn entry_mut(&mut self, sub: SubIndex) -> Option<&mut Entry> {
        let position = self.position(sub).ok()?;
        self.entries.get_mut(position)
    }

    /// Adds an entry; returns the entry with the same sub-index that it replaces.
    pub fn insert(&mut self, entry: Entry) -> Option<Entry> {
        match self.position(entry.sub) {
            Ok(position) => self.entries.get_mut(position).map(|old| std::mem::replace(old, entry)),
            Err(position) => {
                self.entries.insert(position, entry);
                None
            }
        }
    }

    fn position(&self, sub: SubIndex) -> Result<usize, usize> {
        self.entries.binary_search_by_key(&sub, |entry| entry.sub)
    }
}

/// Why the object dictionary has no entry at an address; the reasons have different SDO abort codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// No object has that index (abort 0602 0000h).
    Object,
    /// The object has no such sub-index (abort 0609 0011h).
    SubIndex,
}

/// All objects of a device. A look-up is a binary search in one sorted table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectDictionary {
    objects: Vec<Object>,
}

impl ObjectDictionary {
    /// The objects, by rising index.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The object of that index.
    pub fn object(&self, index: Index) -> Option<&Object> {
        self.objects.get(self.position(index).ok()?)
    }

    /// The object of that index, to change.
    pub fn object_mut(&mut self, index: Index) -> Option<&mut Object> {
        let position = self.position(index).ok()?;
        self.objects.get_mut(position)
    }

    /// The entry at that address.
    pub fn entry(&self, address: Multiplexer) -> Result<&Entry, Missing> {
        self.object(address.index).ok_or(Missing::Object)?.entry(address.sub).ok_or(Missing::SubIndex)
    }

    /// All entries with their addresses, in rising order.
    pub fn entries(&self) -> impl Iterator<Item = (Multiplexer, &Entry)> {
        self.objects.iter().flat_map(|object| {
            object.entries.iter().map(|entry| (Multiplexer { index: object.index, sub: entry.sub }, entry))
        })
    }

    /// Adds an object; returns the object with the same index that it replaces.
    pub fn insert(&mut self, object: Object) -> Option<Object> {
        match self.position(object.index) {
            Ok(position) => self.objects.get_mut(position).map(|old| std::mem::replace(old, object)),
            Err(position) => {
                self.objects.insert(position, object);
                None
            }
        }
    }

    fn position(&self, index: Index) -> Result<usize, usize> {
        self.objects.binary_search_by_key(&index, |object| object.index)
    }
}

impl FromIterator<Object> for ObjectDictionary {
    /// If two objects have the same index, the last one stays.
    fn from_iter<T: IntoIterator<Item = Object>>(objects: T) -> Self {
        let mut dictionary = Self::default();
        for object in objects {
            dictionary.insert(object);
        }
        dictionary
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tpdo_1() -> Object {
        let mut object = Object::new(0x1800, "TPDO 1", ObjectCode::RECORD);
        // Sub-index 4 is reserved: the gap must not shift the entries after it.
        for sub in [5, 0, 2, 1, 3] {
            object.insert(Entry::new(sub, format!("sub {sub}"), DataType::UNSIGNED8, Access::Rw));
        }
        object
    }

    #[test]
    fn entries_are_found_over_gaps() {
        let dictionary = ObjectDictionary::from_iter([tpdo_1()]);
        let name = |sub| dictionary.entry(Multiplexer::new(0x1800, sub)).map(|entry| entry.name.as_str());
        assert_eq!((name(0), name(3), name(5)), (Ok("sub 0"), Ok("sub 3"), Ok("sub 5")));
        assert_eq!((name(4), name(6)), (Err(Missing::SubIndex), Err(Missing::SubIndex)));
        assert_eq!(dictionary.entry(Multiplexer::new(0x1801, 0)), Err(Missing::Object));
        assert_eq!(dictionary.entries().count(), 5);
    }

    #[test]
    fn formulas_are_resolved_with_the_node_id() {
        let node = NodeId::new(63).unwrap();
        assert_eq!(Setting::NodeIdPlus(0x180).resolve(DataType::UNSIGNED32, node), Value::Unsigned(0x1BF));
        assert_eq!(Setting::NodeIdPlus(0x180).to_string(), "$NODEID+180h");
    }

    #[test]
    fn access_types() {
        assert_eq!(Access::from_name("RO"), Some(Access::Ro));
        assert!(!Access::Const.is_writable() && !Access::Wo.is_readable());
        assert!(Access::Rwr.allows_tpdo() && !Access::Rwr.allows_rpdo());
        assert!(Access::Rww.allows_rpdo() && !Access::Rww.allows_tpdo());
    }
}
