//! The kinds of networks and their nodes.

use crate::draw::Draw;
use crate::plan::MS;
use crate::sort::Trigger;

/// The kind of a network.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Base {
    /// A master resets, reads, starts and commands its nodes; SYNC and cyclic PDOs.
    MasterDriven,
    /// Nodes start by themselves; one of them sends SYNC, others use event timers.
    SelfStarting,
    /// A master starts the nodes; PDOs on events.
    EventDriven,
    /// A master asks: node guarding, SDO, remote frames.
    Polled,
    /// The capture begins while all is in operation.
    Running,
    /// LSS or LMT before the nodes start.
    Commissioned,
    /// Two masters that negotiate, safety-relevant data, TIME.
    Redundant,
}

/// What the diagnosis can know of the nodes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Known {
    /// Device descriptions are given.
    Described,
    /// The parameters are written or read by SDO in the capture.
    Configured,
    /// Nothing but the traffic.
    Nothing,
}

/// A PDO of a node.
#[derive(Clone, Copy, Debug)]
pub struct PdoSpec {
    /// Whether the node sends it.
    pub is_transmitted: bool,
    /// The number from 1 to 4.
    pub number: u8,
    /// When it is sent.
    pub trigger: Trigger,
    /// The event timer, or the mean distance of events, in nanoseconds.
    pub period: u64,
    /// Number of bytes.
    pub length: u8,
    /// Whether the data changes.
    pub moves: bool,
    /// Whether it is a multiplexed PDO.
    pub is_multiplexed: bool,
}

/// A node.
#[derive(Clone, Debug)]
pub struct NodeSpec {
    /// The node-ID.
    pub id: u8,
    /// The heartbeat time in nanoseconds; 0 without heartbeat.
    pub heartbeat: u64,
    /// The PDOs.
    pub pdos: Vec<PdoSpec>,
    /// Time until an SDO response, in nanoseconds.
    pub response: u64,
    /// Time from a reset to the boot-up message, in nanoseconds.
    pub boot: u64,
    /// Deviation of heartbeat and timer, in thousandths.
    pub jitter: u64,
}

impl Base {
    /// All kinds, with their names in ids.
    pub const ALL: [(Self, &'static str); 7] = [
        (Self::MasterDriven, "master-driven"),
        (Self::SelfStarting, "self-starting"),
        (Self::EventDriven, "event-driven"),
        (Self::Polled, "polled"),
        (Self::Running, "running"),
        (Self::Commissioned, "commissioned"),
        (Self::Redundant, "redundant"),
    ];

    /// Whether a master starts the nodes in the capture.
    pub const fn has_master(self) -> bool {
        !matches!(self, Self::SelfStarting | Self::Running)
    }

    fn triggers(self) -> &'static [Trigger] {
        match self {
            Self::MasterDriven | Self::Commissioned => {
                &[Trigger::Cyclic(1), Trigger::Cyclic(4), Trigger::Acyclic, Trigger::Timer]
            }
            Self::SelfStarting => &[Trigger::Timer, Trigger::Timer, Trigger::Cyclic(1), Trigger::Event],
            Self::EventDriven => &[Trigger::Event, Trigger::Event, Trigger::Timer],
            Self::Polled => &[Trigger::Remote, Trigger::Event],
            Self::Running => &[Trigger::Cyclic(1), Trigger::Timer, Trigger::Event, Trigger::Cyclic(4)],
            Self::Redundant => &[Trigger::Cyclic(1), Trigger::RemoteSync, Trigger::Timer],
        }
    }

    fn heartbeat(self, is_with: bool, nodes: u64, draw: &mut Draw) -> u64 {
        if self == Self::Polled || !is_with {
            return 0;
        }
        draw.of(&[100, 200, 500, 1000]).max(nodes * 20) * MS
    }
}

impl Known {
    /// All, with their names in ids.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Described, "described"), (Self::Configured, "configured"), (Self::Nothing, "unknown")];
}

/// The nodes of a network.
pub fn nodes(base: Base, draw: &mut Draw) -> Vec<NodeSpec> {
    let count = draw.of(&[1, 2, 3, 3, 4, 5, 6, 8, 12, 20, 40]);
    let count = if base == Base::Polled { count.min(8) } else { count };
    let with_heartbeats = draw.chance(75);
    // Node-IDs with gaps, none of them the master's.
    let mut ids: Vec<u8> = (1..=100).collect();
    draw.shuffle(&mut ids);
    ids.truncate(count as usize);
    ids.sort_unstable();
    ids.into_iter().map(|id| node(base, id, count, with_heartbeats, draw)).collect()
}

fn node(base: Base, id: u8, count: u64, with_heartbeats: bool, draw: &mut Draw) -> NodeSpec {
    let most = if count > 8 { 1 } else { 3 };
    let mut pdos: Vec<PdoSpec> =
        (1..=draw.between(1, most) as u8).map(|number| pdo(base, true, number, count, draw)).collect();
    if base.has_master() && base != Base::Polled && draw.chance(70) {
        pdos.push(pdo(base, false, 1, count, draw));
    }
    NodeSpec {
        id,
        heartbeat: base.heartbeat(with_heartbeats, count, draw),
        pdos,
        response: draw.between(300_000, 8 * MS),
        boot: draw.between(200, 1_200) * MS,
        jitter: draw.between(1, 20),
    }
}

fn pdo(base: Base, is_transmitted: bool, number: u8, nodes: u64, draw: &mut Draw) -> PdoSpec {
    let trigger = draw.of(base.triggers());
    let is_remote = matches!(trigger, Trigger::Remote | Trigger::RemoteSync);
    let trigger = if !is_transmitted && is_remote { Trigger::Event } else { trigger };
    let period = match trigger {
        Trigger::Event => draw.between(300, 2_000),
        Trigger::Acyclic => draw.between(200, 800),
        Trigger::Remote | Trigger::RemoteSync => draw.of(&[250, 500]),
        _ => draw.of(&[20, 50, 100, 200]),
    };
    PdoSpec {
        is_transmitted,
        number,
        trigger,
        period: period.max(nodes * 5) * MS,
        length: draw.between(1, 8) as u8,
        moves: draw.chance(60),
        // An event PDO may carry one object of many, each with its own address.
        is_multiplexed: trigger == Trigger::Event && is_transmitted && number == 3,
    }
}

impl PdoSpec {
    /// The CAN-ID, as the predefined connection set has it.
    pub fn can_id(&self, node: u8) -> u16 {
        let base = if self.is_transmitted { 0x080 } else { 0x100 };
        base + 0x100 * u16::from(self.number) + u16::from(node)
    }

    /// The index of the communication parameters.
    pub const fn communication(&self) -> u16 {
        (if self.is_transmitted { 0x1800 } else { 0x1400 }) + self.number as u16 - 1
    }

    /// The index of the mapping parameters.
    pub const fn mapping(&self) -> u16 {
        self.communication() + 0x200
    }

    /// The event timer in milliseconds; 0 without.
    pub const fn event_timer(&self) -> u16 {
        match self.trigger {
            Trigger::Timer => (self.period / MS) as u16,
            _ => 0,
        }
    }

    /// The entries of the mapping: one byte each.
    pub fn entries(&self) -> Vec<u32> {
        let index = (if self.is_transmitted { 0x2100 } else { 0x2200 }) + u32::from(self.number);
        (1..=u32::from(self.length)).map(|sub| index << 16 | sub << 8 | 8).collect()
    }
}
