//! The start of a network: what happens until its nodes are operational.

use super::dialogue::Talk;
use super::{Base, Known, Network, NodeSpec};
use crate::plan::{MS, Planned, SECOND};
use crate::sort::{FLYING_MASTERS, Sort};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::ErrorControl;
use canvass_analyzer::wire::nmt::{CAN_ID, Command, Nmt};

/// When a node begins to work.
#[derive(Clone, Copy, Debug)]
pub struct Started {
    /// Its first heartbeat is after this time.
    pub booted: u64,
    /// Its first PDO is after this time.
    pub operational: u64,
}

impl Network {
    /// Starts all nodes.
    pub(super) fn start(&mut self) -> Vec<Started> {
        match self.base {
            Base::Running => self.run_on(),
            Base::SelfStarting => self.start_by_themselves(),
            _ => self.start_by_master(),
        }
    }

    /// All nodes were started before the capture began.
    fn run_on(&mut self) -> Vec<Started> {
        self.plan.running = self.nodes.iter().map(|node| node.id).collect();
        if self.known == Known::Configured {
            self.read_all(3 * SECOND);
        }
        self.nodes.iter().map(|_| Started { booted: 0, operational: 0 }).collect()
    }

    fn start_by_themselves(&mut self) -> Vec<Started> {
        self.plan.self_starting = self.nodes.iter().map(|node| node.id).collect();
        let nodes = self.nodes.clone();
        let boot = |node: &NodeSpec| {
            let at = node.boot + self.draw.below(300) * MS;
            self.boot_up(node.id, at, None);
            Started { booted: at, operational: at + 5 * MS }
        };
        let started = nodes.iter().map(boot).collect();
        if self.known == Known::Configured {
            self.read_all(4 * SECOND);
        }
        started
    }

    fn start_by_master(&mut self) -> Vec<Started> {
        self.plan.waiting = self.nodes.iter().map(|node| node.id).collect();
        let mut at = 100 * MS;
        if self.base == Base::Commissioned {
            at = self.set_layer(at);
        }
        if self.base == Base::Redundant {
            at = self.negotiate(at);
        }
        let reset = self.command(Command::RESET_NODE, 0, at + 50 * MS);
        let nodes = self.nodes.clone();
        let boots: Vec<u64> = nodes
            .iter()
            .map(|node| {
                let boot = at + 50 * MS + self.draw.about(node.boot, 50);
                self.boot_up(node.id, boot, Some(reset));
                boot
            })
            .collect();
        let mut now = boots.iter().max().copied().unwrap_or(at) + 100 * MS;
        for node in &nodes {
            now = self.configure_node(node, now) + 5 * MS;
        }
        let at_once = self.draw.chance(50);
        if at_once {
            self.command(Command::START, 0, now);
        }
        let start = |(node, booted): (&NodeSpec, u64)| {
            if !at_once {
                now += 10 * MS;
                self.command(Command::START, node.id, now);
            }
            Started { booted, operational: now + 2 * MS }
        };
        nodes.iter().zip(boots).map(start).collect()
    }

    /// Sends an NMT command.
    pub(super) fn command(&mut self, command: Command, node: u8, at: u64) -> usize {
        let sort = Sort::nmt(command).unwrap_or(Sort::ALL_OF_A_NODE);
        self.plan.add(Planned::new(at, Nmt { command, node }.to_frame(CAN_ID), sort, node))
    }

    /// Sends a boot-up message.
    pub(super) fn boot_up(&mut self, node: u8, at: u64, cause: Option<usize>) -> usize {
        let frame = ErrorControl::BOOT_UP.to_frame(0x700 + u16::from(node));
        let planned = Planned::new(at, frame, Sort::error_control(ErrorControl::BOOT_UP), node).by_node();
        self.plan.add(Planned { cause, ..planned })
    }

    /// Two masters agree which of them is the active one; the other one has the lower priority.
    fn negotiate(&mut self, mut at: u64) -> u64 {
        let [active, negotiation, asks_active, detected, detection, force] = FLYING_MASTERS;
        for message in [detection, detected, asks_active, force, negotiation, active] {
            at += self.draw.between(20, 100) * MS;
            self.plan.add(Planned::new(at, message.to_frame(), Sort::flying_master(message), 0));
        }
        at
    }

    /// The master reads who a node is, and configures it if the capture is to show its parameters.
    pub(super) fn configure_node(&mut self, node: &NodeSpec, at: u64) -> u64 {
        let (is_configured, sync, counts) = (self.known == Known::Configured, self.sync, self.counts);
        let mut talk = Talk::new(&mut self.plan, &mut self.draw, node, at);
        talk.read(Multiplexer::new(0x1000, 0), &[0; 4]);
        talk.read(Multiplexer::new(0x1018, 1), &0x123_u32.to_le_bytes());
        if is_configured {
            for (object, value, _) in parameters(node, sync, counts) {
                talk.write(object, &value);
            }
        }
        talk.at
    }

    /// A tool reads the parameters of all nodes.
    fn read_all(&mut self, mut at: u64) {
        for node in &self.nodes.clone() {
            let mut talk = Talk::new(&mut self.plan, &mut self.draw, node, at);
            let parameters = parameters(node, self.sync, self.counts);
            for (object, value, _) in parameters.into_iter().filter(|(.., is_step)| !is_step) {
                talk.read(object, &value);
            }
            at = talk.at + 10 * MS;
        }
    }
}

/// A parameter: the object, its value, and whether it is only a step towards another value.
type Parameter = (Multiplexer, Vec<u8>, bool);

/// The parameters of communication of a node.
fn parameters(node: &NodeSpec, sync: u64, counts: bool) -> Vec<Parameter> {
    let mut all = Vec::new();
    let mut put = |index, sub, value: &[u8], is_step| all.push((Multiplexer::new(index, sub), value.to_vec(), is_step));
    if node.heartbeat != 0 {
        put(0x1017, 0, &((node.heartbeat / MS) as u16).to_le_bytes(), false);
    }
    if sync != 0 {
        put(0x1006, 0, &((sync / 1000) as u32).to_le_bytes(), false);
        put(0x1019, 0, &[if counts { 240 } else { 0 }], false);
    }
    for pdo in &node.pdos {
        let can_id = u32::from(pdo.can_id(node.id));
        let entries = if pdo.is_multiplexed { Vec::new() } else { pdo.entries() };
        let count = if pdo.is_multiplexed { 0xFE } else { pdo.length };
        put(pdo.communication(), 1, &(can_id | 0x8000_0000).to_le_bytes(), true);
        put(pdo.communication(), 2, &[pdo.trigger.transmission_type()], false);
        if pdo.is_transmitted {
            put(pdo.communication(), 5, &pdo.event_timer().to_le_bytes(), false);
        }
        put(pdo.mapping(), 0, &[0], true);
        for (sub, entry) in (1..).zip(entries) {
            put(pdo.mapping(), sub, &entry.to_le_bytes(), false);
        }
        put(pdo.mapping(), 0, &[count], false);
        put(pdo.communication(), 1, &can_id.to_le_bytes(), false);
    }
    all
}
