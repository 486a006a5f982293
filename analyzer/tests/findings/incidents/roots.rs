//! The first faults, and their consequences in a network of devices that follow CiA 301.

use super::network::{END, Network, Status};
use super::random::Random;

/// The first fault.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Root {
    PowerLoss,
    PowerLossForGood,
    BrownOut,
    CutOff,
    WrongHeartbeatTime,
    SyncLost,
    DuplicateNodeId,
    Overload,
    EmcyStorm,
    WrongLength,
    ImpatientMaster,
    DeviceError,
    IgnoredReset,
}

/// The finding that the first story must name.
pub struct Expected {
    pub rules: &'static [&'static str],
    pub node: Option<u8>,
}

impl Root {
    pub const ALL: [Self; 13] = [
        Self::PowerLoss,
        Self::PowerLossForGood,
        Self::BrownOut,
        Self::CutOff,
        Self::WrongHeartbeatTime,
        Self::SyncLost,
        Self::DuplicateNodeId,
        Self::Overload,
        Self::EmcyStorm,
        Self::WrongLength,
        Self::ImpatientMaster,
        Self::DeviceError,
        Self::IgnoredReset,
    ];

    pub const fn words(self) -> &'static str {
        match self {
            Self::PowerLoss => "a node loses its supply and comes back",
            Self::PowerLossForGood => "a node loses its supply for good, and does not react to resets",
            Self::BrownOut => "a node restarts by itself",
            Self::CutOff => "a node goes bus-off and comes back",
            Self::WrongHeartbeatTime => "a heartbeat time that is longer than its consumer waits",
            Self::SyncLost => "SYNC ends",
            Self::DuplicateNodeId => "a second device with the same node-ID",
            Self::Overload => "a bus that is full",
            Self::EmcyStorm => "an EMCY storm",
            Self::WrongLength => "a PDO of the wrong length",
            Self::ImpatientMaster => "a master whose time-out is too short",
            Self::DeviceError => "a device that reports an error and leaves operational",
            Self::IgnoredReset => "a node that does not obey a reset",
        }
    }

    /// Adds the fault to the network; returns the finding that must be named.
    pub fn break_it(self, network: &mut Network, random: &mut Random) -> Expected {
        let at = random.between(20_000, 40_000);
        let ids: Vec<u8> = network.nodes.iter().map(|node| node.id).collect();
        let id = random.one_of(&ids);
        let named = |rules| Expected { rules, node: Some(id) };
        match self {
            Self::PowerLoss => {
                let away = random.between(5_000, 15_000);
                lose(network, random, id, at, Some(away), true);
                named(&["nodes/lost"])
            }
            Self::PowerLossForGood => {
                lose(network, random, id, at, None, true);
                named(&["nodes/lost"])
            }
            Self::CutOff => {
                let away = random.between(4_000, 9_000);
                lose(network, random, id, at, Some(away), false);
                network.extra.at(at + away - 1, &format!("{:03X}#4081110000000000", 0x80 + u16::from(id)));
                named(&["nodes/lost"])
            }
            Self::BrownOut => {
                restart(network, id, at, random.between(20, 90));
                named(&["nodes/boot-up-without-command"])
            }
            Self::WrongHeartbeatTime => wrong_heartbeat_time(network, random, at),
            Self::SyncLost => {
                network.sync_ends = at;
                network.nodes[0].synchronous = true;
                Expected { rules: &["pdo/sync-missing"], node: None }
            }
            Self::DuplicateNodeId => {
                second_device(network, id, at);
                named(&["bus/duplicate-node-id"])
            }
            Self::Overload => {
                for us in (at * 1_000..(at + 6_000) * 1_000).step_by(255) {
                    network.extra.micros(us, "101#A5A5A5A5A5A5A5A5");
                }
                Expected { rules: &["bus/load"], node: None }
            }
            Self::EmcyStorm => {
                let emcy = format!("{:03X}#1050210102030405", 0x80 + u16::from(id));
                network.extra.every(at, at + 4_000, random.between(5, 30), |_| emcy.clone());
                named(&["emcy/storm"])
            }
            Self::WrongLength => {
                network.shorter = Some((id, at));
                let other = random.one_of(&ids);
                if other != id {
                    network.extra.at(at + 300, &format!("{:03X}#1082110000000000", 0x80 + u16::from(other)));
                }
                named(&["pdo/length"])
            }
            Self::ImpatientMaster => {
                network.node(id).answer = random.between(20_000, 60_000);
                network.impatient = Some((id, at, random.between(300, 10_000)));
                named(&["sdo/impatient-client"])
            }
            Self::DeviceError => {
                let code = random.one_of(&["1050", "0042", "2033", "00FF"]);
                network.extra.at(at, &format!("{:03X}#{code}3F0000000000", 0x80 + u16::from(id)));
                network.node(id).stays(at, Status::PreOperational);
                named(&["emcy/raised"])
            }
            Self::IgnoredReset => {
                network.extra.at(at, &format!("000#81{id:02X}"));
                named(&["nodes/command-not-obeyed"])
            }
        }
    }
}

/// A node is away. Its consumers send an EMCY and leave operational; the master resets and starts the node.
fn lose(network: &mut Network, random: &mut Random, id: u8, at: u64, away: Option<u64>, restarts: bool) {
    let last = network.node(id).last_beat(at);
    for (consumer, time) in network.consumers(id) {
        let noticed = last + time;
        if away.is_none_or(|away| noticed < at + away) {
            let node = network.node(consumer);
            if node.status(noticed) == Status::Operational {
                node.stays(noticed, Status::PreOperational);
                network.extra.at(noticed, &format!("{:03X}#3081110000000000", 0x80 + u16::from(consumer)));
            }
        }
    }
    let period = network.node(id).period;
    if random.chance(70) {
        let resets = random.between(1, 4);
        for n in 0..resets {
            let reset = at + 2 * period + 100 + n * 1_000;
            if away.is_none_or(|away| reset + 1_500 < at + away) {
                network.extra.at(reset, &format!("000#81{id:02X}"));
            }
        }
    }
    let node = network.node(id);
    node.stays(at, Status::Off);
    let Some(back) = away.map(|away| at + away) else { return };
    if !restarts {
        node.becomes(back, Status::Operational);
        return;
    }
    node.becomes(back, Status::PreOperational);
    node.becomes(back + 900, Status::Operational);
    network.extra.at(back, &format!("{:03X}#00", 0x700 + u16::from(id))).at(back + 900, &format!("000#01{id:02X}"));
}

/// A node restarts by itself, and the master starts it.
fn restart(network: &mut Network, id: u8, at: u64, took: u64) {
    let node = network.node(id);
    node.stays(at, Status::Off);
    node.becomes(at + took, Status::PreOperational);
    node.becomes(at + took + 400, Status::Operational);
    network.extra.at(at + took, &format!("{:03X}#00", 0x700 + u16::from(id)));
    network.extra.at(at + took + 400, &format!("000#01{id:02X}"));
}

/// A producer's heartbeat time is set to more than its consumer's time.
fn wrong_heartbeat_time(network: &mut Network, random: &mut Random, at: u64) -> Expected {
    let place = random.between(1, network.nodes.len() as u64) as usize;
    let (producer, period) = (network.nodes[place - 1].id, network.nodes[place - 1].period);
    network.nodes[place].consumes = Some((producer, period * 5 / 2));
    let consumer = network.nodes[place].id;
    let slower = period * 4;
    let value: String = (slower as u16).to_le_bytes().iter().map(|byte| format!("{byte:02X}")).collect();
    network.extra.sdo(at, producer, &format!("2B171000{value}0000"), "6017100000000000");
    let last = network.node(producer).last_beat(at);
    network.slower = Some((producer, at, slower));
    for (waiting, time) in network.consumers(producer) {
        let noticed = last + time;
        network.node(waiting).stays(noticed, Status::PreOperational);
        network.extra.at(noticed, &format!("{:03X}#3081110000000000", 0x80 + u16::from(waiting)));
    }
    Expected { rules: &["nodes/consumer-time"], node: Some(consumer) }
}

/// A second device of the same type is switched on, with its own serial number and its own heartbeat.
fn second_device(network: &mut Network, id: u8, at: u64) {
    let (heartbeat, period) = (0x700 + u16::from(id), network.node(id).period);
    network.extra.at(at, &format!("{heartbeat:03X}#00"));
    let beat = network.node(id).last_beat(at) + period * 2 / 7;
    network.extra.every(beat + period, END, period, |_| format!("{heartbeat:03X}#7F"));
    let (client, server) = (0x600 + u16::from(id), 0x580 + u16::from(id));
    for n in 0..3 {
        let ms = at + 3_001 + n * 1_707;
        network.extra.at(ms, &format!("{client:03X}#4018100400000000"));
        network.extra.at(ms + 3, &format!("{server:03X}#4318100401000000"));
        network.extra.micros(ms * 1_000 + 3_700, &format!("{server:03X}#4318100402000000"));
    }
}

/// Normal operation by a master: it stops, starts and resets healthy nodes, and finds out which objects they have.
pub fn operate(network: &mut Network, random: &mut Random) {
    let ids: Vec<u8> = network.nodes.iter().map(|node| node.id).collect();
    for n in 0..random.between(0, 4) {
        let at = 8_000 + n * 12_000 + random.between(0, 4_000);
        let id = random.one_of(&ids);
        // A node whose heartbeat is consumed is not stopped or reset.
        if !network.consumers(id).is_empty() {
            continue;
        }
        match random.between(0, 3) {
            0 => {
                network.extra.at(at, &format!("000#02{id:02X}")).at(at + 2_000, &format!("000#01{id:02X}"));
                let node = network.node(id);
                node.becomes(at, Status::Stopped);
                node.becomes(at + 2_000, Status::Operational);
            }
            1 => {
                network.extra.at(at, &format!("000#81{id:02X}"));
                restart(network, id, at, random.between(150, 2_500));
                let node = network.node(id);
                node.stays(node.history.last().map_or(0, |last| last.0), Status::Operational);
            }
            _ => {
                let (client, server) = (0x600 + u16::from(id), 0x580 + u16::from(id));
                let Some(ms) = (at..at + 2_000).find(|ms| network.node(id).is_free(*ms)) else { continue };
                network.extra.at(ms, &format!("{client:03X}#4000500000000000"));
                network.extra.at(ms + 30, &format!("{server:03X}#8000500000000206"));
            }
        }
    }
}
