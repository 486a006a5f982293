//! The communication parameters of TPDOs, as shown by the trace itself.
//!
//! A description gives only the defaults. Most machines set these parameters before a capture begins, so nothing is
//! concluded from defaults.

use crate::dictionary::names::ENCODER_PROFILE;
use crate::message::Service;
use crate::network::{Bus, Decoded, Event};
use crate::object;
use crate::object::encoder;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_traces::Duration;

/// Number of TPDOs of a node that are judged; further ones are rare.
pub const TPDOS: usize = 8;

/// Synchronous window length, in microseconds; 0 is no window.
const SYNC_WINDOW: u16 = object::SYNCHRONOUS_WINDOW_LENGTH;

/// Event timer of the first TPDO, and the cyclic timer of encoders, in milliseconds.
const EVENT_TIMER: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 5);
const CYCLIC_TIMER: Multiplexer = Multiplexer::new(encoder::CYCLIC_TIMER, 0);

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
    /// Whether the cyclic timer of an encoder (6200h) was shown later than the event timer of its first TPDO.
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
                Some(CYCLIC_TIMER) => self.cyclic[node] = true,
                Some(EVENT_TIMER) => self.cyclic[node] = false,
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
            // Encoders have a timer of their own for their first TPDO. Where both exist they are the same timer, so
            // the later value holds.
            let is_cyclic = index == object::TPDO_COMMUNICATION_PARAMETER && row.transmission_type == Some(254);
            if is_cyclic && (cyclic || row.event_timer.is_none()) && known.profile(node) == Some(ENCODER_PROFILE) {
                row.event_timer = time(known.certain(node, CYCLIC_TIMER), millis);
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

/// Whether a transfer has shown a source of the parameters: the parameters themselves, the cyclic timer or the
/// profile of encoders, or the model of the node.
fn is_shown(decoded: &Decoded, bus: &Bus) -> bool {
    let object = decoded.object.is_some_and(|object| {
        matches!(object.index.0, object::DEVICE_TYPE | SYNC_WINDOW | 0x1800..=0x19FF | encoder::CYCLIC_TIMER)
    });
    object || bus.events().iter().any(|event| matches!(event, Event::Recognised(_)))
}
