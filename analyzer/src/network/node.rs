//! What is known of one node.

use crate::dictionary::Unit;
use crate::dictionary::names::{self, Role};
use crate::dictionary::{Access, DeviceDescription, KnownDevice};
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
    /// Its NMT state and how that is known.
    pub state: Option<(State, Cause)>,
    /// What tells its answers to node guarding from heartbeats.
    pub(super) guarding: Guarding,
    /// What is known of it beforehand, where the user gave its description or its identity was recognised.
    pub device: Option<Arc<KnownDevice>>,
    /// As what it was recognised, where the description comes from that.
    pub recognition: Option<Recognition>,
    /// What it has shown of the objects that tell models apart.
    pub(super) identity: recognition::Shown,
    /// What it will use after its next start.
    pub(super) pending: Pending,
    /// When it last started, and whether an EMCY without bytes said so, as before CiA 301 V4.
    pub(super) started: Option<(Timestamp, bool)>,
    /// When the oldest error was reported that no EMCY has taken back.
    pub(super) error_since: Option<Timestamp>,
    /// The communication parameters that the trace has shown, as numbers, and whether it was a download.
    parameters: BTreeMap<Multiplexer, (u32, Shown)>,
    /// Those that the device will have after its next reset.
    stored: BTreeMap<Multiplexer, (u32, Shown)>,
    layouts: Layouts,
    srdo_layouts: BTreeMap<u8, Option<Layout>>,
    /// The number of its device profile, once it was asked for: every object that is shown asks.
    profile: OnceLock<Option<u16>>,
    /// The PDOs that are multiplexed; worked out with their layouts.
    multiplexed: BTreeMap<PdoNumber, Addressing>,
}

/// How the trace has shown a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shown {
    /// It was written.
    Written,
    /// It was read.
    Read,
}

/// How a node's state is known.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Cause {
    /// An NMT command that the node should have obeyed.
    Command,
    /// Its boot-up message.
    BootUp,
    /// Its heartbeat or guarding answer.
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
    /// What the trace has shown, or else the description says, as the value of a communication parameter.
    pub fn parameter(&self, id: NodeId, object: Multiplexer) -> Option<u32> {
        let described = || {
            let entry = self.description()?.dictionary.entry(object).ok()?;
            u32::try_from(entry.start_value(id)?.to_raw()?).ok()
        };
        self.parameters.get(&object).map(|shown| shown.0).or_else(described)
    }

    /// The value of a parameter as far as it is certain: the trace has shown it, or the description has it for an object
    /// that no one can write. Other defaults may have been changed before the trace began.
    pub fn certain(&self, id: NodeId, object: Multiplexer) -> Option<u32> {
        let fixed = || {
            let entry = self.description()?.dictionary.entry(object).ok()?;
            let value = u32::try_from(entry.start_value(id)?.to_raw()?).ok()?;
            matches!(entry.access, Access::Const | Access::Ro).then_some(value)
        };
        self.parameters.get(&object).map(|shown| shown.0).or_else(fixed)
    }

    /// The number of its device profile (the low word of 1000h), where the trace or the description tells.
    pub fn profile(&self, id: NodeId) -> Option<u16> {
        let device_type = || self.parameter(id, Multiplexer::new(object::DEVICE_TYPE, 0));
        *self.profile.get_or_init(|| device_type().map(|device_type| device_type as u16))
    }

    /// Notes a communication parameter that the trace has shown, and says whether that changes how process data are laid out.
    pub fn learn(&mut self, object: Multiplexer, value: u32, shown: Shown) -> bool {
        let written = matches!(self.parameters.get(&object), Some((_, Shown::Written)));
        if shown == Shown::Read && !written {
            // Not written since the start: it was there before, so a reset will bring it back.
            self.stored.insert(object, (value, shown));
        }
        let shown = if written { Shown::Written } else { shown };
        let before = self.parameters.insert(object, (value, shown)).map(|before| before.0);
        let is_mapping =
            PdoNumber::of_mapping_index(object.index.0).is_some() || matches!(object.index.0, 0x1381..=0x13C0);
        let lays_out = (is_mapping || scaling::is_scaling_parameter(object)) && before != Some(value);
        if lays_out {
            self.forget_layouts();
        }
        lays_out
    }

    /// Parameters were stored by that sub-index of 1010h: a reset does not change them any more.
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

    /// The defaults were restored; they take effect at the next reset.
    pub fn restore_defaults(&mut self) {
        // Device type, identity and what the device is built like are its own: no default changes them.
        self.stored.retain(|object, _| {
            matches!(object.index.0, object::DEVICE_TYPE | object::IDENTITY)
                || names::has_role(object.index, Role::Constant)
        });
    }

    /// The node started anew: with what is stored, as far as the trace has shown that.
    pub fn restart(&mut self) {
        self.parameters = self.stored.clone();
        self.forget_layouts();
        self.guarding = Guarding::default();
        self.error_since = None;
    }

    /// What a parameter takes in memory: it stands among those of now and among the stored ones.
    pub(super) const PARAMETER: usize = 2 * 2 * size_of::<(Multiplexer, (u32, Shown))>();

    /// Whether the trace has shown that parameter since the node has started.
    pub(super) fn has_shown(&self, object: Multiplexer) -> bool {
        self.parameters.contains_key(&object)
    }

    /// The communication parameters that the trace has shown.
    pub fn parameters(&self) -> impl Iterator<Item = (Multiplexer, u32)> {
        self.parameters.iter().map(|(&object, &(value, _))| (object, value))
    }

    /// What its file says, where there is one.
    pub fn description(&self) -> Option<&DeviceDescription> {
        Some(&self.device.as_deref()?.description)
    }

    /// Sets or replaces what is known of it beforehand.
    pub fn describe(&mut self, device: Arc<KnownDevice>) {
        self.device = Some(device);
        self.forget_layouts();
    }

    /// How a PDO is laid out at this moment; `None` where its mapping is not known.
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

    /// The layout, where it has been worked out already.
    pub fn known_layout(&self, pdo: PdoNumber) -> Option<&Layout> {
        self.layouts.get(pdo)
    }

    /// How the data of an SRDO are laid out; `None` where its mapping is not known.
    pub fn srdo_layout(&mut self, id: NodeId, number: u8) -> Option<&Layout> {
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

    /// The same, where it has been worked out already.
    pub fn known_srdo_layout(&self, number: u8) -> Option<&Layout> {
        self.srdo_layouts.get(&number).and_then(Option::as_ref)
    }

    /// The addressing of a multiplexed PDO, where its layout has been asked for already; `None` for other PDOs.
    pub fn addressing(&self, pdo: PdoNumber) -> Option<Addressing> {
        self.multiplexed.get(&pdo).copied()
    }

    fn forget_layouts(&mut self) {
        self.layouts.clear();
        self.srdo_layouts.clear();
        self.multiplexed.clear();
        self.profile.take();
    }

    /// What the values of an object are in the unit that the configuration of the device decides, where that is
    /// known: degrees or millimetres of a position, the unit of a speed.
    pub fn scale(&self, id: NodeId, object: Multiplexer) -> Option<Unit> {
        scaling::scale(self, id, object)
    }

    /// The entries of a PDO's mapping, if all of them are known and the mapping is switched on.
    pub fn mapping(&self, id: NodeId, pdo: PdoNumber) -> Option<Vec<MappingEntry>> {
        let index = pdo.mapping_index();
        let count = self.parameter(id, Multiplexer::new(index, 0))?;
        // FEh and FFh make it a multiplexed PDO, which carries its own addresses.
        let count = u8::try_from(count).ok().filter(|&count| (1..=64).contains(&count))?;
        (1..=count).map(|sub| self.parameter(id, Multiplexer::new(index, sub)).map(MappingEntry)).collect()
    }

    /// What an NMT command makes of the node's state; `None` if the command is reserved.
    pub fn obey(&mut self, command: Command) -> Option<State> {
        let state = match command {
            Command::START => State::OPERATIONAL,
            Command::STOP => State::STOPPED,
            Command::ENTER_PRE_OPERATIONAL => State::PRE_OPERATIONAL,
            Command::RESET_NODE | Command::RESET_COMMUNICATION => State::BOOT_UP,
            _ => return None,
        };
        self.state = Some((state, Cause::Command));
        Some(state)
    }
}
