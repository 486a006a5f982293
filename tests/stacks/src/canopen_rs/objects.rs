//! The object dictionary of the device with `canopen-rs`.

use canopen_rs::datatypes::ByteString;
use canopen_rs::standard::StandardObjects;
use canopen_rs::{Address, Entry, LssAddress, NodeId, ObjectDictionary, Value};

/// Capacity of the object dictionary in objects.
pub const CAPACITY: usize = 128;

/// The identity 1018h, which is also the LSS address.
pub const IDENTITY: LssAddress = LssAddress {
    vendor_id: 0x00C0_FFEE,
    product_code: 0x0000_CA06,
    revision_number: 0x0006_0001,
    serial_number: 0x0000_1234,
};

/// Number of entries of 1003h.
const ERROR_HISTORY: u8 = 4;

/// The object dictionary as delivered, for this node-ID.
pub fn dictionary(node: NodeId) -> ObjectDictionary<CAPACITY> {
    let mut objects = ObjectDictionary::new();
    let standard =
        StandardObjects::new(0, IDENTITY).with_error_history(ERROR_HISTORY).with_device_name("canopen-rs as a device");
    let mut fits = standard.insert_into(&mut objects).is_ok();
    let id = u32::from(node.raw());
    let rows = [
        (0x1005, 0, Entry::constant(Value::Unsigned32(0x80))),
        (0x1009, 0, Entry::constant(text("rev1"))),
        (0x100A, 0, Entry::constant(text("0.6.1"))),
        // The device answers guarding; the crate has no life guarding.
        (0x100C, 0, Entry::ro(Value::Unsigned16(0))),
        (0x100D, 0, Entry::ro(Value::Unsigned8(0))),
        (0x1014, 0, Entry::constant(Value::Unsigned32(0x80 + id))),
        (0x1200, 0, Entry::constant(Value::Unsigned8(2))),
        (0x1200, 1, Entry::constant(Value::Unsigned32(0x600 + id))),
        (0x1200, 2, Entry::constant(Value::Unsigned32(0x580 + id))),
        (0x2000, 0, Entry::constant(Value::Unsigned8(5))),
        (0x2000, 1, Entry::rw(Value::Unsigned8(0))),
        (0x2000, 2, Entry::rw(Value::Unsigned16(0))),
        (0x2000, 3, Entry::rw(Value::Unsigned32(0))),
        (0x2000, 4, Entry::rw(Value::Unsigned64(0))),
        (0x2000, 5, Entry { value: Value::Unsigned32(0), access: canopen_rs::AccessType::Wo }),
        (0x2001, 0, Entry::rw(text("canvass"))),
        (0x2002, 0, Entry::rw(text(""))),
        (0x2100, 0, Entry::constant(Value::Unsigned8(2))),
        (0x2100, 1, Entry::rw(Value::Unsigned32(0))),
        (0x2100, 2, Entry::rw(Value::Unsigned32(0))),
        (0x2200, 0, Entry::constant(Value::Unsigned8(3))),
        (0x2200, 1, Entry::rw(Value::Unsigned32(0))),
        (0x2200, 2, Entry::rw(Value::Unsigned16(0))),
        (0x2200, 3, Entry::rw(Value::Unsigned8(0))),
    ];
    for (index, sub, entry) in rows {
        fits &= objects.insert(Address::new(index, sub), entry).is_ok();
    }
    for (n, transmission_type, received) in [(0, 254, 0x2200_0120), (1, 1, 0x2200_0210)] {
        let base = 0x100 * u32::from(n) + id;
        fits &= pdo(&mut objects, (0x1400 + n, 0x1600 + n), 0x200 + base, transmission_type, received);
        let (tpdo, sent) = (0x4000_0180 + base, 0x2100_0120 + 0x100 * u32::from(n));
        fits &= pdo(&mut objects, (0x1800 + n, 0x1A00 + n), tpdo, transmission_type, sent);
    }
    debug_assert!(fits, "the dictionary has room for {CAPACITY} objects");
    objects
}

fn text(text: &str) -> Value {
    Value::VisibleString(ByteString::from_str(text).unwrap_or_default())
}

fn pdo(
    objects: &mut ObjectDictionary<CAPACITY>,
    (communication, mapping): (u16, u16),
    cob_id: u32,
    transmission_type: u8,
    first: u32,
) -> bool {
    let mut fits = true;
    let mut insert = |index, sub, entry| fits &= objects.insert(Address::new(index, sub), entry).is_ok();
    insert(communication, 0, Entry::constant(Value::Unsigned8(2)));
    insert(communication, 1, Entry::rw(Value::Unsigned32(cob_id)));
    insert(communication, 2, Entry::rw(Value::Unsigned8(transmission_type)));
    insert(mapping, 0, Entry::rw(Value::Unsigned8(1)));
    for sub in 1..=8 {
        insert(mapping, sub, Entry::rw(Value::Unsigned32(if sub == 1 { first } else { 0 })));
    }
    fits
}

/// Copies the objects that a reset of the communication does not change.
pub fn keep_application(objects: &mut ObjectDictionary<CAPACITY>, kept: &ObjectDictionary<CAPACITY>) {
    for (index, last) in [(0x2000, 5), (0x2001, 0), (0x2002, 0), (0x2100, 2), (0x2200, 3)] {
        for sub in 0..=last {
            if let Some(entry) = kept.entry(Address::new(index, sub)) {
                // The dictionary has room, as the objects are the same.
                let _ = objects.insert(Address::new(index, sub), *entry);
            }
        }
    }
}

/// The numbers, from 0, of the valid TPDOs: a node counts only these.
pub fn valid_tpdos(objects: &ObjectDictionary<CAPACITY>) -> Vec<usize> {
    const INVALID: u32 = 1 << 31;
    let is_valid = |number: &u16| {
        let cob_id = objects.read(Address::new(0x1800 + number, 1));
        matches!(cob_id, Ok(Value::Unsigned32(cob_id)) if cob_id & INVALID == 0) && is_complete(objects, *number)
    };
    (0..2).filter(is_valid).map(usize::from).collect()
}

/// Whether all mapped objects of a PDO exist and fit into eight bytes.
fn is_complete(objects: &ObjectDictionary<CAPACITY>, number: u16) -> bool {
    let Ok(Value::Unsigned8(count)) = objects.read(Address::new(0x1A00 + number, 0)) else { return false };
    let bits = (1..=count).map(|sub| match objects.read(Address::new(0x1A00 + number, sub)) {
        Ok(Value::Unsigned32(mapping)) => Some(mapping & 0xFF),
        _ => None,
    });
    bits.sum::<Option<u32>>().is_some_and(|bits| bits <= 64)
}

/// Whether this TPDO, numbered from 0, is event-driven.
pub fn is_event_driven(objects: &ObjectDictionary<CAPACITY>, number: usize) -> bool {
    let sub = u16::try_from(number).map(|number| Address::new(0x1800 + number, 2));
    matches!(sub.map(|sub| objects.read(sub)), Ok(Ok(Value::Unsigned8(254..=255))))
}
