//! The names that CiA 301, 302, 304 and the device profiles give to objects, sub-indexes and bits, with the types,
//! access and units that they fix.
//!
//! Look-ups are binary searches in static tables and allocate nothing.

mod bits;
mod cia301;
mod cia302;
mod clauses;
mod error_codes;
mod meaning;
mod profile;
mod units;

pub use bits::bit_name;
pub(crate) use bits::{bit_names, same_bits};
pub(crate) use error_codes::find as find_error;
pub use error_codes::{ErrorCodes, ErrorName, error_name, error_names};
pub use meaning::{Meaning, meaning};
pub use profile::{
    Configured, Profile, Registered, Role, acting, has_role, is_profile, known_profile, possible, profiles, with_role,
};
pub use units::{Unit, unit};

use profile::logical_device;
use std::fmt;

use super::data_type::DataType;
use super::object::{Access, ObjectCode};
use crate::identity::{Index, Multiplexer, SubIndex};

/// An object that a standard defines, or a range of objects of the same kind (such as the TPDO communication
/// parameters).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StandardObject {
    /// The index, or the first index of the range.
    pub first: u16,
    /// The last index of the range; `first` for one object.
    pub last: u16,
    /// The standard that defines the object, such as `CiA 301`.
    pub standard: &'static str,
    /// The name of the object in the standard.
    pub name: &'static str,
    /// The object code.
    pub code: ObjectCode,
    /// The entries, by rising sub-index.
    pub entries: &'static [StandardEntry],
}

/// A sub-index that a standard defines, or a range of sub-indexes of the same kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StandardEntry {
    /// The sub-index, or the first sub-index of the range.
    pub first: u8,
    /// The last sub-index of the range; `first` for one entry.
    pub last: u8,
    /// The name of the entry in the standard; empty for a VAR, whose object has the name.
    pub name: &'static str,
    /// The data type, if the standard fixes one.
    pub data_type: Option<DataType>,
    /// The access type, if the standard fixes one. `ro` includes `const`.
    pub access: Option<Access>,
}

/// The names of an address in a standard. Displays as `TPDO communication parameter 1, COB-ID used by TPDO`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectName {
    /// The object.
    pub object: &'static StandardObject,
    /// The entry, if the standard defines that sub-index.
    pub entry: Option<&'static StandardEntry>,
    /// The address; for an object of a further logical device, the address of the object of the first logical device
    /// that has the same meaning.
    address: Multiplexer,
    /// The profile's word for a logical device, and the number of the logical device from 2; `None` for the first
    /// logical device.
    device: Option<(&'static str, u16)>,
}

impl ObjectName {
    /// The number among several objects of the same kind, from 1; `None` if there is only one.
    pub const fn number(&self) -> Option<u16> {
        if self.object.first == self.object.last { None } else { Some(self.address.index.0 - self.object.first + 1) }
    }

    /// The number among several entries of the same kind, from 1; `None` if there is only one.
    pub(crate) fn entry_number(&self) -> Option<u8> {
        let entry = self.entry.filter(|entry| entry.first != entry.last)?;
        Some(self.address.sub.0 - entry.first + 1)
    }
}

impl fmt::Display for ObjectName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.object.name)?;
        if let Some(number) = self.number() {
            write!(f, " {number}")?;
        }
        if let Some(entry) = self.entry.filter(|entry| !entry.name.is_empty()) {
            write!(f, ", {}", entry.name)?;
            if let Some(number) = self.entry_number() {
                write!(f, " {number}")?;
            }
        }
        match self.device {
            Some((word, number)) => write!(f, " ({word} {number})"),
            None => Ok(()),
        }
    }
}

/// The names of an address. `profile` is the device profile number of the device (the low word of 1000h); without it
/// only the communication area has names.
pub fn object_name(address: Multiplexer, profile: Option<u16>) -> Option<ObjectName> {
    let device = profile.and_then(|number| logical_device(address.index, number));
    let address = device.map_or(address, |device| Multiplexer { index: device.object, ..address });
    let object = in_table(table(address.index, profile), address.index)?;
    let device = device.filter(|device| device.number > 1);
    let device = device.map(|device| (device.profile.logical_device(), device.number));
    Some(ObjectName { object, entry: entry(object, address.sub), address, device })
}

/// The object of a standard with this index.
pub(crate) fn standard_object(index: Index, profile: Option<u16>) -> Option<&'static StandardObject> {
    let index = of_first_device(index, profile);
    in_table(table(index, profile), index)
}

/// All objects of the standard that covers the index; empty if no standard does.
pub(crate) fn in_area(index: Index, profile: Option<u16>) -> &'static [StandardObject] {
    table(of_first_device(index, profile), profile)
}

/// The index of the object of the first logical device that has the same meaning.
fn of_first_device(index: Index, profile: Option<u16>) -> Index {
    profile.and_then(|number| logical_device(index, number)).map_or(index, |device| device.object)
}

/// All objects of the standard that covers an index of the first logical device.
fn table(index: Index, profile: Option<u16>) -> &'static [StandardObject] {
    match (index.0, profile) {
        (0x1000..=0x1EFF, _) => cia301::OBJECTS,
        (0x1F00..=0x1FFF, _) => cia302::OBJECTS,
        (0x6000..=0x67FF, Some(number)) => profile::objects(number),
        _ => &[],
    }
}

fn in_table(table: &'static [StandardObject], index: Index) -> Option<&'static StandardObject> {
    let position = table.partition_point(|object| object.last < index.0);
    table.get(position).filter(|object| object.first <= index.0)
}

/// Whether CiA 301 defines a COB-ID at the address: of SYNC, TIME, EMCY, an SDO channel or a PDO.
pub const fn is_cob_id(at: Multiplexer) -> bool {
    matches!(
        (at.index.0, at.sub.0),
        (0x1005 | 0x1012 | 0x1014, 0) | (0x1200..=0x12FF, 1 | 2) | (0x1400..=0x15FF | 0x1800..=0x19FF, 1)
    )
}

fn entry(object: &'static StandardObject, sub: SubIndex) -> Option<&'static StandardEntry> {
    let position = object.entries.partition_point(|entry| entry.last < sub.0);
    object.entries.get(position).filter(|entry| entry.first <= sub.0)
}

/// A row of a table, in a file whose `STANDARD` names the standard.
///
/// - `var!(0x1000, "Device type", UNSIGNED32, Ro)`
/// - `object!(0x1018, "Identity object", RECORD, [1, "Vendor-ID", UNSIGNED32, Ro; …])`: sub-index 0 is added.
/// - `object!(…, [all 0, …; 1, …])`: sub-index 0 is listed too. Indexes and sub-indexes may be ranges `a => b`.
macro_rules! object {
    ($first:literal $(=> $last:literal)?, $name:literal, $code:ident,
        [all $($sub:literal $(=> $sub_last:literal)?, $entry:literal, $data_type:ident, $access:ident);+]) => {
        $crate::dictionary::names::StandardObject {
            first: $first,
            last: $crate::dictionary::names::last!($first $(=> $last)?),
            standard: STANDARD,
            name: $name,
            code: $crate::dictionary::ObjectCode::$code,
            entries: &[$($crate::dictionary::names::StandardEntry {
                first: $sub,
                last: $crate::dictionary::names::last!($sub $(=> $sub_last)?),
                name: $entry,
                data_type: Some($crate::dictionary::DataType::$data_type),
                access: Some($crate::dictionary::Access::$access),
            }),+],
        }
    };
    ($first:literal $(=> $last:literal)?, $name:literal, $code:ident, [$($entries:tt)+]) => {
        $crate::dictionary::names::object!($first $(=> $last)?, $name, $code,
            [all 0, "Highest sub-index supported", UNSIGNED8, Ro; $($entries)+])
    };
}

macro_rules! var {
    ($first:literal $(=> $last:literal)?, $name:literal, $data_type:ident, $access:ident) => {
        $crate::dictionary::names::object!($first $(=> $last)?, $name, VAR, [all 0, "", $data_type, $access])
    };
}

macro_rules! last {
    ($first:literal) => {
        $first
    };
    ($first:literal => $last:literal) => {
        $last
    };
}

pub(crate) use {last, object, var};

#[cfg(test)]
mod tests {
    use super::*;

    fn name(index: u16, sub: u8) -> Option<String> {
        object_name(Multiplexer::new(index, sub), None).map(|name| name.to_string())
    }

    fn is_called(index: u16, sub: u8, expected: &str) {
        assert_eq!(name(index, sub).as_deref(), Some(expected), "{index:04X}h:{sub:02X}");
    }

    #[test]
    fn objects_have_the_names_of_the_standards() {
        is_called(0x1000, 0, "Device type");
        is_called(0x1018, 1, "Identity object, Vendor-ID");
        is_called(0x1003, 2, "Pre-defined error field, Standard error field 2");
        is_called(0x1800, 1, "TPDO communication parameter 1, COB-ID used by TPDO");
        is_called(0x19FF, 5, "TPDO communication parameter 512, Event timer");
        is_called(0x1A00, 3, "TPDO mapping parameter 1, Application object 3");
        is_called(0x1F51, 1, "Program control, Program number 1");
    }

    #[test]
    fn unknown_addresses_have_none() {
        assert_eq!((name(0x0FFF, 0), name(0x102B, 0), name(0x2100, 0), name(0x6000, 0)), (None, None, None, None));
        // A sub-index that the standard does not define still has the object's name.
        assert_eq!(name(0x1000, 5).as_deref(), Some("Device type"));
    }

    #[test]
    fn tables_are_sorted_and_complete() {
        is_sorted_and_complete(cia301::OBJECTS);
        is_sorted_and_complete(cia302::OBJECTS);
    }

    pub(super) fn is_sorted_and_complete(table: &[StandardObject]) {
        assert!(table.is_sorted_by(|a, b| a.last < b.first));
        for object in table {
            assert!(object.first <= object.last && !object.entries.is_empty(), "{}", object.name);
            assert!(object.entries.is_sorted_by(|a, b| a.last < b.first), "{}", object.name);
            let first = object.entries.first().map(|entry| entry.first);
            assert_eq!(first, Some(0), "{} has no sub-index 0", object.name);
            assert_eq!(object.code.is_single(), object.entries.len() == 1, "{}", object.name);
        }
    }

    #[test]
    fn types_are_those_of_the_standards() {
        let entry = |index| object_name(Multiplexer::new(index, 0), None).and_then(|name| name.entry).unwrap();
        assert_eq!(entry(0x1015).data_type, Some(DataType::UNSIGNED16));
        assert_eq!(entry(0x1014).access, Some(Access::Rw));
    }
}
