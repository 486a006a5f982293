//! The state of one node.

use crate::dictionary::Unit;
use crate::dictionary::names::{self, Role};
use crate::dictionary::{Access, Condition, DataType, DeviceDescription, KnownDevice};
use crate::message::PdoNumber;
use crate::network::configured::Pending;
use crate::network::guarding::Guarding;
use crate::network::layout::Layout;
use crate::network::layouts::Layouts;
use crate::network::recognition::{self, Recognition};
use crate::network::scaling;
use crate::object;
use crate::wire::error_control::State;
use crate::wire::mpdo::Addressing;
use crate::wire::nmt::Command;
use crate::wire::pdo::MappingEntry;
use crate::wire::srdo;
use crate::{Multiplexer, NodeId};
use canvass_traces::Timestamp;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::OnceLock;

/// A node of a bus, as far as the trace and its description tell.
#[derive(Clone, Default)]
pub struct Node {
    /// The NMT state of the node, and the source of that knowledge.
    pub state: Option<(State, Cause)>,
    /// Distinguishes the node's answers to node guarding from heartbeats.
    pub(super) guarding: Guarding,
    /// Prior knowledge of the node: the user gave its description, or its model was recognised.
    pub device: Option<Arc<KnownDevice>>,
    /// The recognised model, if the description comes from recognition.
    pub recognition: Option<Recognition>,
    /// The identifying objects that the node has shown.
    pub(super) identity: recognition::Shown,
    /// What the node shows of its model besides its identity; kept while the model is unknown or ambiguous.
    pub(super) traits: recognition::Traits,
    /// The settings of the node after its next start.
    pub(super) pending: Pending,
    /// Time of the node's last start, and whether an empty EMCY announced it, as before CiA 301 V4.
    pub(super) started: Option<(Timestamp, bool)>,
    /// Time of the oldest error that no EMCY has taken back.
    pub(super) error_since: Option<Timestamp>,
    /// The parameters that the trace has shown, of the communication and of device profiles: each as a number, and how
    /// the trace has shown it.
    parameters: BTreeMap<Multiplexer, (u32, Shown)>,
    /// The parameters after the node's next reset.
    stored: BTreeMap<Multiplexer, (u32, Shown)>,
    layouts: Layouts,
    srdo_layouts: BTreeMap<u8, Option<Layout>>,
    /// The number of the node's device profile, cached because every shown object needs it.
    profile: OnceLock<Option<u16>>,
    /// The multiplexed PDOs; computed with their layouts.
    multiplexed: BTreeMap<PdoNumber, Addressing>,
}

/// How the trace has shown a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shown {
    /// By a download.
    Written,
    /// By an upload.
    Read,
}

/// The source of the knowledge of a node's state.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Cause {
    /// An NMT command that the node should have obeyed.
    Command,
    /// The boot-up message of the node.
    BootUp,
    /// The heartbeat or guarding answer of the node.
    ErrorControl,
}

impl Cause {
    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Command => "command",
            Self::BootUp => "boot-up",
            Self::ErrorControl => "error-control",
        }
    }
}

impl Node {
    /// The value of a parameter, from the trace or else from the description.
    pub fn parameter(&self, id: NodeId, object: Multiplexer) -> Option<u32> {
        self.parameters.get(&object).map(|shown| shown.0).or_else(|| self.described(id, object))
    }

    /// The value of a parameter if it is certain: shown by the trace, or described for a read-only object. Other
    /// described defaults may have been changed before the trace began.
    pub fn certain(&self, id: NodeId, object: Multiplexer) -> Option<u32> {
        let fixed = || {
            let entry = self.description()?.dictionary.entry(object).ok()?;
            let value = u32::try_from(entry.start_value(id)?.to_raw()?).ok()?;
            matches!(entry.access, Access::Const | Access::Ro).then_some(value)
        };
        self.parameters.get(&object).map(|shown| shown.0).or_else(fixed)
    }

    /// The number of the node's device profile (the low word of 1000h), if the trace or the description tells it.
    pub fn profile(&self, id: NodeId) -> Option<u16> {
        let device_type = || self.parameter(id, Multiplexer::new(object::DEVICE_TYPE, 0));
        *self.profile.get_or_init(|| device_type().map(|device_type| device_type as u16))
    }

    /// The data type of an object in the description; the signed type, if a parameter of the device makes the object
    /// signed.
    pub fn data_type(&self, id: NodeId, object: Multiplexer) -> Option<DataType> {
        let device = self.device.as_deref()?;
        let described = device.description.dictionary.entry(object).ok()?.data_type;
        let condition = device.manual.annotations.get(object).and_then(|annotation| annotation.signed_if);
        let is_signed = condition.is_some_and(|state| self.is_in(id, state));
        Some(if is_signed { described.signed() } else { described })
    }

    /// Whether the device is in a state, as far as the trace or the description tells.
    pub fn is_in(&self, id: NodeId, state: Condition) -> bool {
        self.parameter(id, state.at) == Some(state.value)
    }

    /// Whether the meaning of other objects' values depends on this object, by the device's manual.
    pub(super) fn is_condition(&self, object: Multiplexer) -> bool {
        self.device.as_deref().is_some_and(|device| device.manual.annotations.is_condition(object))
    }

    /// Notes a parameter shown by the trace; returns whether it changes the layout of process data.
    pub fn learn(&mut self, object: Multiplexer, value: u32, shown: Shown) -> bool {
        let written = matches!(self.parameters.get(&object), Some((_, Shown::Written)));
        if shown == Shown::Read && !written {
            // The value was not written since the start, so the node started with it, and a reset restores it.
            self.stored.insert(object, (value, shown));
        }
        let shown = if written { Shown::Written } else { shown };
        let before = self.parameters.insert(object, (value, shown)).map(|before| before.0);
        let is_mapping =
            PdoNumber::of_mapping_index(object.index.0).is_some() || matches!(object.index.0, 0x1381..=0x13C0);
        let is_of_layout = is_mapping || scaling::is_scaling_parameter(object) || self.is_condition(object);
        let lays_out = is_of_layout && before != Some(value);
        if lays_out {
            self.forget_layouts();
        }
        lays_out
    }

    /// Handles a store by the sub-index `sub` of 1010h: a reset keeps the stored values.
    pub fn store(&mut self, sub: u8) {
        let is_stored = |index: u16| match sub {
            1 => true,
            2 => matches!(index, 0x1000..=0x1FFF),
            3 => matches!(index, 0x6000..=0x9FFF),
            _ => false,
        };
        let shown = self.parameters.iter().filter(|(object, _)| is_stored(object.index.0));
        self.stored.extend(shown.map(|(&object, &value)| (object, value)));
    }

    /// Handles the restoring of defaults, which take effect at the next reset.
    pub(crate) fn restore_defaults(&mut self) {
        // Device type, identity and constants of the construction belong to the device: restoring defaults does not
        // change them.
        self.stored.retain(|object, _| {
            matches!(object.index.0, object::DEVICE_TYPE | object::IDENTITY)
                || names::has_role(object.index, Role::Constant)
        });
    }

    /// Handles a start: the node has its stored values, as far as the trace has shown them.
    pub fn restart(&mut self) {
        self.parameters = self.stored.clone();
        self.forget_layouts();
        self.guarding = Guarding::default();
        self.error_since = None;
    }

    /// Memory of a parameter: it is kept with its current and its stored value.
    pub(super) const PARAMETER: usize = 2 * 2 * size_of::<(Multiplexer, (u32, Shown))>();

    /// Whether the trace has shown the parameter since the node started.
    pub(super) fn has_shown(&self, object: Multiplexer) -> bool {
        self.parameters.contains_key(&object)
    }

    /// The parameters shown by the trace.
    pub fn parameters(&self) -> impl Iterator<Item = (Multiplexer, u32)> {
        self.parameters.iter().map(|(&object, &(value, _))| (object, value))
    }

    /// The description of the node, if there is one.
    pub fn description(&self) -> Option<&DeviceDescription> {
        Some(&self.device.as_deref()?.description)
    }

    /// Whether the model of the node is unknown, or recognised as one of several.
    pub(super) fn is_ambiguous(&self) -> bool {
        match &self.recognition {
            Some(recognition) => !recognition.or.is_empty(),
            None => self.device.is_none(),
        }
    }

    /// Sets or replaces the prior knowledge of the node.
    pub fn describe(&mut self, device: Arc<KnownDevice>) {
        self.device = Some(device);
        self.forget_layouts();
    }

    /// The current layout of a PDO; `None` if its mapping is unknown.
    pub fn layout(&mut self, id: NodeId, pdo: PdoNumber) -> Option<&Layout> {
        if !self.layouts.is_worked_out(pdo) {
            let layout = self.mapping(id, pdo).map(|entries| Layout::new(&entries, id, self));
            self.layouts.insert(pdo, layout);
            let count = self.parameter(id, Multiplexer::new(pdo.mapping_index(), 0));
            if let Some(addressing) = count.and_then(Addressing::of_mapping_count) {
                self.multiplexed.insert(pdo, addressing);
            }
        }
        self.layouts.get(pdo)
    }

    /// The layout of a PDO, if it is already computed.
    pub fn known_layout(&self, pdo: PdoNumber) -> Option<&Layout> {
        self.layouts.get(pdo)
    }

    /// The layout of an SRDO's data; `None` if its mapping is unknown.
    pub(crate) fn srdo_layout(&mut self, id: NodeId, number: u8) -> Option<&Layout> {
        if !self.srdo_layouts.contains_key(&number) {
            let index = srdo::mapping_index(number);
            let of = |sub| self.parameter(id, Multiplexer::new(index, sub));
            // Entries come in pairs: an object, and its inverted twin.
            let count = of(0).and_then(|count| u8::try_from(count).ok()).filter(|&count| (2..=128).contains(&count));
            let entries: Option<Vec<_>> =
                count.and_then(|count| (1..=count).step_by(2).map(|sub| of(sub).map(MappingEntry)).collect());
            let layout = entries.map(|entries| Layout::new(&entries, id, self));
            self.srdo_layouts.insert(number, layout);
        }
        self.known_srdo_layout(number)
    }

    /// The SRDO's layout, if it is already computed.
    pub fn known_srdo_layout(&self, number: u8) -> Option<&Layout> {
        self.srdo_layouts.get(&number).and_then(Option::as_ref)
    }

    /// The addressing of a multiplexed PDO whose layout is computed; `None` for other PDOs.
    pub fn addressing(&self, pdo: PdoNumber) -> Option<Addressing> {
        self.multiplexed.get(&pdo).copied()
    }

    fn forget_layouts(&mut self) {
        self.layouts.clear();
        self.srdo_layouts.clear();
        self.multiplexed.clear();
        self.profile.take();
    }

    /// The unit of an object's values that the device's configuration determines, if known: degrees or millimetres of
    /// a position, the unit of a speed.
    pub fn scale(&self, id: NodeId, object: Multiplexer) -> Option<Unit> {
        scaling::scale(self, id, object)
    }

    /// The entries of a PDO's mapping, if all are known and the mapping is enabled.
    pub fn mapping(&self, id: NodeId, pdo: PdoNumber) -> Option<Vec<MappingEntry>> {
        let index = pdo.mapping_index();
        let count = self.parameter(id, Multiplexer::new(index, 0))?;
        // The counts FEh and FFh mark a multiplexed PDO, which carries its own addresses.
        let count = u8::try_from(count).ok().filter(|&count| (1..=64).contains(&count))?;
        let only_shown = self.contradicts_description(id, index);
        let entry = |sub| match (Multiplexer::new(index, sub), only_shown) {
            (object, false) => self.parameter(id, object).map(MappingEntry),
            (object, true) => self.parameters.get(&object).map(|shown| MappingEntry(shown.0)),
        };
        (1..=count).map(entry).collect()
    }

    /// Whether an entry of the object was read with another value than the description says: the other entries may
    /// differ from the description, too, until they are read.
    fn contradicts_description(&self, id: NodeId, index: u16) -> bool {
        let mut shown = self.parameters.range(Multiplexer::new(index, 0)..=Multiplexer::new(index, u8::MAX));
        shown.any(|(object, &(value, how))| {
            how == Shown::Read && self.described(id, *object).is_some_and(|described| described != value)
        })
    }

    /// The start value of a parameter in the description.
    fn described(&self, id: NodeId, object: Multiplexer) -> Option<u32> {
        let entry = self.description()?.dictionary.entry(object).ok()?;
        u32::try_from(entry.start_value(id)?.to_raw()?).ok()
    }

    /// The node's state after an NMT command; `None` if the command is reserved.
    pub fn obey(&mut self, command: Command) -> Option<State> {
        let state = command.state()?;
        self.state = Some((state, Cause::Command));
        Some(state)
    }
}
