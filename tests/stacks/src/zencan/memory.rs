//! The state of the application around `zencan-node`: its non-volatile memory, and the values of its statics at
//! power-on.

use super::node::{NODE_STATE, OD_TABLE};
use std::convert::Infallible;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use zencan_node::common::messages::CanMessage;
use zencan_node::object_dict::{ODEntry, find_object};
use zencan_node::priority_queue::PriorityQueue;
use zencan_node::{Callbacks, NodeMbox, SDO_BUFFER_SIZE, restore_stored_comm_objects, restore_stored_objects};

/// The non-volatile memory.
pub struct Memory {
    /// The stored node-ID; 255: none.
    node: AtomicU8,
    objects: Mutex<Vec<u8>>,
}

impl Memory {
    /// A memory that holds only a node-ID.
    pub fn new(node: u8) -> Self {
        Self { node: AtomicU8::new(node), objects: Mutex::default() }
    }

    /// The node-ID at the start.
    pub fn node_id(&self) -> zencan_node::common::NodeId {
        let raw = self.node.load(Ordering::Relaxed);
        zencan_node::common::NodeId::new(raw).unwrap_or(zencan_node::common::NodeId::Unconfigured)
    }

    fn objects(&self) -> MutexGuard<'_, Vec<u8>> {
        self.objects.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The callbacks of the node: each closure shares the ownership of the memory.
pub fn callbacks(memory: &Arc<Memory>) -> Callbacks<'static> {
    const fn is_shareable<T: Send + Sync>() {}
    const { is_shareable::<Memory>() };
    let (node, objects, app, comms) = (memory.clone(), memory.clone(), memory.clone(), memory.clone());
    let store_node = move |id: zencan_node::common::NodeId| node.node.store(id.into(), Ordering::Relaxed);
    let store_objects = move |reader: &mut dyn zencan_node::embedded_io::Read<Error = Infallible>, size: usize| {
        let mut bytes = vec![0; size];
        let Ok(read) = reader.read(&mut bytes);
        bytes.truncate(read);
        *objects.objects() = bytes;
    };
    let reset_app = move |table: &'static [ODEntry<'static>]| {
        set_defaults(0..=0xFFFF);
        restore_stored_objects(table, &app.objects());
    };
    let reset_comms = move |table: &'static [ODEntry<'static>]| {
        set_defaults(0x1000..=0x1FFF);
        restore_stored_comm_objects(table, &comms.objects());
    };
    Callbacks {
        store_node_config: Some(Box::leak(Box::new(store_node))),
        store_objects: Some(Box::leak(Box::new(store_objects))),
        reset_app: Some(Box::leak(Box::new(reset_app))),
        reset_comms: Some(Box::leak(Box::new(reset_comms))),
        ..Callbacks::default()
    }
}

/// PDO parameters, which the node resets itself.
const PDO_PARAMETERS: std::ops::RangeInclusive<u16> = 0x1400..=0x1BFF;

/// A writable object's value when the process began.
struct StartValue {
    index: u16,
    sub: u8,
    value: Vec<u8>,
}

/// The default values: the values of the statics before the first write.
fn defaults() -> &'static [StartValue] {
    static DEFAULTS: OnceLock<Vec<StartValue>> = OnceLock::new();
    DEFAULTS.get_or_init(|| {
        let subs = OD_TABLE.iter().filter(|entry| !PDO_PARAMETERS.contains(&entry.index) && entry.index != 0x1010);
        let subs = subs.flat_map(|entry| (0..=entry.data.max_sub_number()).map(move |sub| (entry, sub)));
        let writable =
            subs.filter(|(entry, sub)| entry.data.access_type(*sub).is_ok_and(|access| access.is_writable()));
        let default = |(entry, sub): (&ODEntry<'static>, u8)| {
            let mut value = vec![0; entry.data.read_size(sub).ok()?];
            // A value that SDO can't read is zero.
            let _ = entry.data.read(sub, 0, &mut value);
            Some(StartValue { index: entry.index, sub, value })
        };
        writable.filter_map(default).collect()
    })
}

/// Resets objects to their defaults, which the node leaves to the application. Its documentation says: "The application
/// should also do whatever is appropriate to reset its state".
fn set_defaults(range: std::ops::RangeInclusive<u16>) {
    for default in defaults().iter().filter(|default| range.contains(&default.index)) {
        if let Some(object) = find_object(&OD_TABLE, default.index) {
            // The object accepts its own default.
            let _ = object.write(default.sub, &default.value);
        }
    }
}

/// Brings the statics into their state after the start of a processor.
pub fn as_after_power_on() {
    set_defaults(0..=0xFFFF);
    for entry in &OD_TABLE {
        entry.data.clear_events();
    }
    for pdo in NODE_STATE.rpdos().iter().chain(NODE_STATE.tpdos()) {
        pdo.buffered_value.store(None);
        // A PDO of type 1 begins its count of SYNCs anew; the node then sets the real type.
        pdo.set_valid(true);
        pdo.set_transmission_type(1);
        pdo.sync_update();
        for parameter in &pdo.mapping_params {
            parameter.store(None);
        }
    }
}

/// A new mailbox like the one that `zencan-build` generates, which would keep old messages.
pub fn mailbox() -> &'static NodeMbox {
    let queue: &'static PriorityQueue<4, CanMessage> = Box::leak(Box::new(PriorityQueue::new()));
    let buffer = Box::leak(Box::new([0; SDO_BUFFER_SIZE]));
    Box::leak(Box::new(NodeMbox::new(NODE_STATE.rpdos(), NODE_STATE.tpdos(), queue, buffer)))
}

/// The objects that can be mapped. The objects that TPDOs send as delivered come first.
const MAPPABLE: [(u16, u8); 5] = [(0x2100, 1), (0x2100, 2), (0x2200, 1), (0x2200, 2), (0x2200, 3)];

/// Values of [`MAPPABLE`].
pub type Parts = [u32; MAPPABLE.len()];

/// The values that TPDOs can carry.
pub fn tpdo_values() -> Parts {
    MAPPABLE.map(|(index, sub)| {
        let mut bytes = [0; 4];
        // A shorter value leaves zeros.
        let _ = find_object(&OD_TABLE, index).map(|object| object.read(sub, 0, &mut bytes));
        u32::from_le_bytes(bytes)
    })
}

/// Sets the event flags of the values that have changed.
pub fn set_event_flags(now: &Parts, before: &Parts) {
    for ((index, sub), _) in MAPPABLE.iter().zip(now.iter().zip(before)).filter(|(_, (now, before))| now != before) {
        if let Some(object) = find_object(&OD_TABLE, *index) {
            // All these objects have event flags.
            let _ = object.set_event_flag(*sub);
        }
    }
}

/// Exclusive use of the statics. Other threads wait until the value is dropped.
pub struct Occupied(());

static IN_USE: Mutex<bool> = Mutex::new(false);
static FREED: Condvar = Condvar::new();

impl Occupied {
    /// Waits until no other thread uses the statics.
    pub fn wait() -> Self {
        let mut in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        while *in_use {
            in_use = FREED.wait(in_use).unwrap_or_else(PoisonError::into_inner);
        }
        *in_use = true;
        Self(())
    }
}

impl Drop for Occupied {
    fn drop(&mut self) {
        *IN_USE.lock().unwrap_or_else(PoisonError::into_inner) = false;
        FREED.notify_one();
    }
}
