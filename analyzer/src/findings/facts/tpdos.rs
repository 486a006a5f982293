//! The communication parameters of TPDOs, as shown by the trace itself.
//!
//! A description gives only the defaults. Most machines set these parameters before a capture begins, so nothing is
//! concluded from defaults.

use crate::dictionary::names::{Role, has_role, known_profile, with_role};
use crate::message::Service;
use crate::network::{Bus, Decoded, Event};
use crate::object;
use crate::{Multiplexer, NodeId, PerNode, SubIndex};
use canvass_traces::Duration;

/// Number of TPDOs of a node that rules check; nodes with more are rare.
pub const TPDOS: usize = 8;

/// Synchronous window length, in microseconds; 0 means no window.
const SYNC_WINDOW: u16 = object::SYNCHRONOUS_WINDOW_LENGTH;

/// Event timer of the first TPDO, in milliseconds.
const EVENT_TIMER: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 5);

/// The known parameters of one TPDO.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Parameters {
    /// Sub-index 2.
    pub transmission_type: Option<u8>,
    /// Sub-index 3; `None` if it is 0 or unknown.
    pub inhibit: Option<Duration>,
    /// Sub-index 5; `None` if it is 0 or unknown.
    pub event_timer: Option<Duration>,
}

impl Parameters {
    const UNKNOWN: Self = Self { transmission_type: None, inhibit: None, event_timer: None };

    /// Whether any parameter is known.
    pub const fn is_known(&self) -> bool {
        self.transmission_type.is_some() || self.inhibit.is_some() || self.event_timer.is_some()
    }
}

/// The parameters of all TPDOs of a bus.
#[derive(Default)]
pub struct AllParameters {
    nodes: PerNode<[Parameters; TPDOS]>,
    /// 1007h of the nodes.
    windows: PerNode<Option<Duration>>,
    /// Whether the parameters have been read.
    known: PerNode<bool>,
    /// Whether the trace has shown the device profile's timer for TPDO 1 after the event timer of TPDO 1.
    cyclic: PerNode<bool>,
}

impl AllParameters {
    /// Handles a frame; returns the node whose parameters may have changed.
    #[inline]
    pub fn frame(&mut self, decoded: &Decoded, bus: &Bus) -> Option<NodeId> {
        let node = decoded.node?;
        // Described values of read-only objects are known from the first frame on.
        let is_new = !self.known[node];
        let may_change = match decoded.service {
            Service::BootUp => true,
            Service::Sdo => decoded.ends_transfer() && is_shown(decoded, bus),
            _ => false,
        };
        (is_new || may_change).then(|| {
            match decoded.object {
                Some(EVENT_TIMER) => self.cyclic[node] = false,
                Some(object) if is_timer_of_profile(object) => self.cyclic[node] = true,
                _ => {}
            }
            self.read(node, bus);
            node
        })
    }

    #[cold]
    fn read(&mut self, node: NodeId, bus: &Bus) {
        let rows = &mut self.nodes[node];
        *rows = Default::default();
        let window = &mut self.windows[node];
        *window = None;
        self.known[node] = true;
        let cyclic = self.cyclic[node];
        let Some(known) = bus.node(node) else { return };
        let micros = known.certain(node, Multiplexer::new(SYNC_WINDOW, 0)).filter(|&micros| micros > 0);
        *window = micros.map(|micros| Duration::from_micros(u64::from(micros)));
        for (row, index) in rows.iter_mut().zip(0x1800..) {
            let of = |sub| known.certain(node, Multiplexer::new(index, sub));
            let time = |value: Option<u32>, unit: Duration| {
                value.filter(|&value| value > 0).map(|value| unit.times(u64::from(value & 0xFFFF)))
            };
            let millis = Duration::from_millis(1);
            row.transmission_type = of(2).map(|value| value as u8);
            row.inhibit = time(of(3), Duration::from_micros(100));
            row.event_timer = time(of(5), millis);
            // Some profiles have a timer of their own for the first TPDO. Where both exist they are the same timer, so
            // the later value holds.
            let is_cyclic = index == object::TPDO_COMMUNICATION_PARAMETER && row.transmission_type == Some(254);
            if is_cyclic
                && (cyclic || row.event_timer.is_none())
                && let Some(timer) = timer_of_profile(node, bus)
            {
                row.event_timer = time(known.certain(node, timer), millis);
            }
        }
    }

    /// The window after SYNC for a node's synchronous PDOs (1007h); `None` if there is none, or it is unknown.
    pub fn sync_window(&self, node: NodeId) -> Option<Duration> {
        self.windows[node]
    }

    /// The parameters of a TPDO, by its number from 1; unknown beyond [`TPDOS`].
    pub fn of(&self, node: NodeId, number: u16) -> &Parameters {
        let row = usize::from(number).checked_sub(1);
        row.and_then(|row| self.nodes[node].get(row)).unwrap_or(&Parameters::UNKNOWN)
    }
}

/// The timer that the profile of a node has for the first TPDO.
fn timer_of_profile(node: NodeId, bus: &Bus) -> Option<Multiplexer> {
    let profile = known_profile(bus.node(node)?.profile(node)?)?;
    with_role(profile, Role::EventTimer).next().map(|index| Multiplexer { index, sub: SubIndex(0) })
}

/// Whether the object is any profile's timer for the first TPDO.
fn is_timer_of_profile(object: Multiplexer) -> bool {
    object.sub.0 == 0 && has_role(object.index, Role::EventTimer)
}

/// The number of the TPDO to whose parameters or mapping an object belongs. The device profile's timer belongs to
/// TPDO 1.
pub fn concerned(object: Multiplexer) -> Option<u16> {
    match object.index.0 {
        index @ 0x1800..=0x1BFF => Some((index & 0x1FF) + 1),
        _ => is_timer_of_profile(object).then_some(1),
    }
}

/// Whether a transfer has shown a source of the parameters: the parameters themselves, the timer or the number of the
/// device profile, or the model of the node.
fn is_shown(decoded: &Decoded, bus: &Bus) -> bool {
    let object = decoded.object.is_some_and(|object| {
        matches!(object.index.0, object::DEVICE_TYPE | SYNC_WINDOW | 0x1800..=0x19FF) || is_timer_of_profile(object)
    });
    object || bus.events().iter().any(|event| matches!(event, Event::Recognised(_)))
}
