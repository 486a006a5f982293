//! A simulated network: a master that configures, starts and polls its nodes, and the frames of each node.

use super::random::Random;
use crate::traffic::{Traffic, hex};

/// The end of the traffic, in milliseconds.
pub const END: u64 = 60_000;
/// Time at which the nodes are started, in milliseconds.
const START: u64 = 3_000;

/// The status of a node from a moment on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    Off,
    PreOperational,
    Operational,
    Stopped,
}

/// A simulated node.
pub struct Node {
    pub id: u8,
    /// The heartbeat period, in milliseconds.
    pub period: u64,
    /// The consumed heartbeat: node-ID of the producer, and consumer time in milliseconds.
    pub consumes: Option<(u8, u64)>,
    /// Whether the node sends its TPDO with each SYNC; otherwise it sends the TPDO every `cycle` milliseconds.
    pub synchronous: bool,
    pub cycle: u64,
    pub length: usize,
    /// The changes of status, each with its time in milliseconds.
    pub history: Vec<(u64, Status)>,
    /// The response time of the SDO server, in microseconds.
    pub answer: u64,
    phase: u64,
    /// The interval at which the master polls the node by SDO, in milliseconds.
    pub polled: u64,
}

impl Node {
    pub fn status(&self, ms: u64) -> Status {
        self.history.iter().rev().find(|row| row.0 <= ms).map_or(Status::Off, |row| row.1)
    }

    /// Adds a change of status at `ms`; later changes stay.
    pub fn becomes(&mut self, ms: u64, status: Status) {
        let at = self.history.iter().position(|row| row.0 > ms).unwrap_or(self.history.len());
        self.history.insert(at, (ms, status));
    }

    /// Sets the status from `ms` on, and drops all later changes.
    pub fn stays(&mut self, ms: u64, status: Status) {
        self.history.retain(|row| row.0 <= ms);
        self.history.push((ms, status));
    }

    fn beats(&self) -> impl Iterator<Item = u64> {
        (0..).map(|n| 500 + self.phase + n * self.period).take_while(|ms| *ms < END)
    }

    /// Times at which the master polls the node.
    fn asked(&self) -> impl Iterator<Item = u64> {
        (START + 500 + self.phase..END - 3_000).step_by(self.polled as usize)
    }

    /// Whether the master may send another SDO request at `ms`: a client has one request at a time.
    pub fn is_free(&self, ms: u64) -> bool {
        self.asked().all(|asked| asked.abs_diff(ms) > 150)
    }

    /// Time of the node's last heartbeat before `ms`.
    pub fn last_beat(&self, ms: u64) -> u64 {
        self.beats().take_while(|beat| *beat < ms).last().unwrap_or(0)
    }
}

/// The whole network.
pub struct Network {
    pub nodes: Vec<Node>,
    /// The SYNC period, in milliseconds.
    pub sync: u64,
    /// Time of the last SYNC, in milliseconds.
    pub sync_ends: u64,
    /// Further frames, such as those of a fault.
    pub extra: Traffic,
    /// A change of a heartbeat period: node, time of the change, new period, in milliseconds.
    pub slower: Option<(u8, u64, u64)>,
    /// A change of the length of a node's TPDOs: node, time of the change in milliseconds.
    pub shorter: Option<(u8, u64)>,
    /// A client with a short timeout: the node that it polls, the begin in milliseconds, and the timeout in
    /// microseconds.
    pub impatient: Option<(u8, u64, u64)>,
    jitter: Random,
}

impl Network {
    pub fn new(random: &mut Random) -> Self {
        let count = random.between(3, 21);
        let sync = random.one_of(&[10, 20, 50]);
        let mut nodes: Vec<Node> = Vec::new();
        for n in 0..count {
            let id = (2 + n * 6 + random.between(0, 5)) as u8;
            let period = random.one_of(&[100, 200, 500, 1_000]);
            let answer = random.between(500, 12_000);
            nodes.push(Node {
                id,
                period,
                consumes: None,
                synchronous: random.chance(50),
                cycle: random.one_of(&[50, 100, 200]),
                length: random.between(2, 9) as usize,
                history: vec![(100 + n * 5, Status::PreOperational), (START, Status::Operational)],
                answer,
                phase: random.between(0, period),
                polled: random.between(700, 3_000),
            });
        }
        for at in 1..nodes.len() {
            if random.chance(60) {
                let producer = &nodes[at - 1];
                nodes[at].consumes = Some((producer.id, producer.period * 5 / 2));
            }
        }
        let jitter = Random::new(random.between(0, u64::MAX / 2));
        let extra = Traffic::default();
        Self { nodes, sync, sync_ends: END, extra, slower: None, shorter: None, impatient: None, jitter }
    }

    pub fn node(&mut self, id: u8) -> &mut Node {
        self.nodes.iter_mut().find(|node| node.id == id).unwrap()
    }

    /// The consumers of a node's heartbeat, each with its consumer time.
    pub fn consumers(&self, producer: u8) -> Vec<(u8, u64)> {
        let waits = |node: &Node| node.consumes.filter(|row| row.0 == producer).map(|row| (node.id, row.1));
        self.nodes.iter().filter_map(waits).collect()
    }

    /// All frames on the bus.
    pub fn traffic(&mut self) -> Traffic {
        let mut traffic = self.extra.clone();
        self.configuration(&mut traffic);
        traffic.at(START, "000#0100");
        traffic.every(50, END, 500, |_| "701#05".to_owned());
        for ms in (START + 30..self.sync_ends).step_by(self.sync as usize) {
            traffic.at(ms, "080#");
        }
        for at in 0..self.nodes.len() {
            self.of_node(at, &mut traffic);
        }
        traffic
    }

    /// The configuration by the master: each node needs its own time for it.
    fn configuration(&self, traffic: &mut Traffic) {
        for (n, node) in self.nodes.iter().enumerate() {
            traffic.at(100 + n as u64 * 5, &format!("{:03X}#00", 0x700 + u16::from(node.id)));
            let at = 600 + n as u64 * 100;
            let mut writes = vec![format!("2B171000{}0000", &hex(node.period)[..4])];
            if let Some((producer, time)) = node.consumes {
                writes.push(format!("23161001{}{producer:02X}00", &hex(time)[..4]));
            }
            writes.push(format!("2F001802{}000000", if node.synchronous { "01" } else { "FE" }));
            if !node.synchronous {
                writes.push(format!("2B001805{}0000", &hex(node.cycle)[..4]));
            }
            writes.push("2F001A0000000000".to_owned());
            writes.push(format!("23001A01{:02X}000120", node.length * 8));
            writes.push("2F001A0001000000".to_owned());
            for (k, write) in writes.iter().enumerate() {
                traffic.sdo(at + k as u64 * 10, node.id, write, &format!("60{}00000000", &write[2..8]));
            }
        }
    }

    fn of_node(&mut self, at: usize, traffic: &mut Traffic) {
        let node = &self.nodes[at];
        let id = u16::from(node.id);
        let mut beats: Vec<u64> = node.beats().collect();
        if let Some((_, from, period)) = self.slower.filter(|row| row.0 == node.id) {
            let last = beats.iter().copied().rfind(|ms| *ms <= from).unwrap_or(0);
            beats.retain(|ms| *ms <= from);
            beats.extend((1..).map(|n| last + n * period).take_while(|ms| *ms < END));
        }
        for ms in beats {
            let state = match node.status(ms) {
                Status::Off => continue,
                Status::PreOperational => "7F",
                Status::Operational => "05",
                Status::Stopped => "04",
            };
            let late = self.jitter.between(0, 1_500);
            traffic.micros(ms * 1_000 + late, &format!("{:03X}#{state}", 0x700 + id));
        }
        let (first, step) = if node.synchronous { (START + 30, self.sync) } else { (START + 17, node.cycle) };
        for ms in (first..END).step_by(step as usize) {
            let due = !node.synchronous || ms < self.sync_ends;
            if !due || node.status(ms) != Status::Operational {
                continue;
            }
            let is_shorter = self.shorter.is_some_and(|row| row.0 == node.id && row.1 <= ms);
            let length = node.length - usize::from(is_shorter);
            let late = self.jitter.between(100, 600);
            traffic.micros(ms * 1_000 + late, &format!("{:03X}#{}", 0x180 + id, "A5".repeat(length)));
        }
        self.polls(at, traffic);
    }

    /// The polls of a node by the master.
    fn polls(&self, at: usize, traffic: &mut Traffic) {
        let node = &self.nodes[at];
        let (client, server) = (0x600 + u16::from(node.id), 0x580 + u16::from(node.id));
        for ms in node.asked() {
            // A master does not poll nodes that it has lost.
            if matches!(node.status(ms), Status::Off | Status::Stopped) || node.status(ms + 20) == Status::Off {
                continue;
            }
            let us = ms * 1_000;
            traffic.micros(us, &format!("{client:03X}#4000100000000000"));
            if let Some((.., wait)) = self.impatient.filter(|row| row.0 == node.id && row.1 <= ms) {
                traffic.micros(us + wait, &format!("{client:03X}#8000100000000405"));
            }
            traffic.micros(us + node.answer, &format!("{server:03X}#4300100092010200"));
        }
    }
}
