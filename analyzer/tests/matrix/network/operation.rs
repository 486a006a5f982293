//! The operation of a network: cyclic traffic, transfers, commands, and events.

use super::dialogue::{Talk, Transfer};
use super::start::Started;
use super::{Base, Events, LENGTH, MASTER, Network, NodeSpec, PdoSpec};
use crate::plan::{MS, Planned, SECOND};
use crate::sort::{Sort, Trigger};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::error_control::{CAN_ID_BASE, ErrorControl, State};
use canvass_analyzer::wire::mpdo::{Addressing, Mpdo};
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sync::{self, Sync};
use canvass_analyzer::wire::time::{self, TimeOfDay};
use canvass_traces::{CanId, ErrorClass, Frame};

/// The spans in which a client works with the nodes; between them the master commands their states.
const SPANS: [(u64, u64); 4] = [(8_000, 13_500), (16_500, 17_500), (22_000, 22_800), (27_000, 37_000)];

/// The frame with this CAN-ID and data; an empty one if there is too much data.
fn frame(can_id: u16, data: &[u8]) -> Frame {
    let id = CanId::standard_masked(can_id.into());
    Frame::new(id, data).unwrap_or_else(|| Frame::full(id, [0; 8]))
}

impl Network {
    /// Operates the network to the end of the capture.
    pub(super) fn operate(&mut self, started: &[Started], events: Events) {
        let syncs = self.synchronize(started);
        let nodes = self.nodes.clone();
        for (node, started) in nodes.iter().zip(started) {
            self.heartbeats(node, started.booted);
            for pdo in &node.pdos {
                self.pdo(node, pdo, started.operational, &syncs);
            }
        }
        match self.base {
            Base::Polled => nodes.iter().zip(started).for_each(|(node, started)| self.guard(node, started.booted)),
            Base::Redundant => self.safety(&nodes, started),
            _ => {}
        }
        if matches!(self.base, Base::Redundant | Base::Commissioned) {
            self.tell_time();
        }
        self.work(&nodes, events);
        if matches!(self.base, Base::MasterDriven | Base::Redundant | Base::Commissioned) {
            self.command_states(&nodes);
        }
        if events == Events::Some {
            self.trouble(&nodes);
        }
    }

    /// The times of a regular message, with its drift and deviation.
    fn regular(&mut self, from: u64, period: u64, deviation: u64) -> Vec<u64> {
        let drift = self.draw.below(100) * (period / 1_000_000);
        let first = from + self.draw.below(period);
        let times = (0..).map(|count| first + count * (period + drift)).take_while(|at| *at < LENGTH);
        times.map(|at| at + self.draw.below(deviation.max(1))).collect()
    }

    /// SYNC, with the place of each.
    fn synchronize(&mut self, started: &[Started]) -> Vec<(u64, usize)> {
        if self.sync == 0 {
            return Vec::new();
        }
        let from = match self.base {
            Base::Running => 0,
            Base::SelfStarting => started.first().map_or(0, |started| started.operational),
            _ => started.iter().map(|started| started.operational).min().unwrap_or(0).saturating_sub(60 * MS),
        };
        // Without master the first node sends SYNC.
        let sender = if self.base == Base::SelfStarting { self.nodes.first().map(|node| node.id) } else { None };
        let deviation = self.draw.between(20, 300) * 1000;
        let times = self.regular(from, self.sync, deviation);
        let counts = self.counts;
        let send = |(number, at): (usize, u64)| {
            let counter = counts.then_some((number % 240) as u8 + 1);
            let planned = Planned::new(at, Sync { counter }.to_frame(sync::CAN_ID), Sort::sync(), 0).every(self.sync);
            (at, self.plan.add(Planned { sender, ..planned }))
        };
        times.into_iter().enumerate().map(send).collect()
    }

    fn heartbeats(&mut self, node: &NodeSpec, from: u64) {
        if node.heartbeat == 0 {
            return;
        }
        // The state is set when the plan is played.
        let message = ErrorControl::heartbeat(State::PRE_OPERATIONAL);
        let (sort, frame) = (Sort::error_control(message), message.to_frame(CAN_ID_BASE + u16::from(node.id)));
        for at in self.regular(from + MS, node.heartbeat, node.heartbeat / 1000 * node.jitter) {
            self.plan.add(Planned::new(at, frame, sort, node.id).every(node.heartbeat).by_node());
        }
    }

    fn pdo(&mut self, node: &NodeSpec, pdo: &PdoSpec, from: u64, syncs: &[(u64, usize)]) {
        match pdo.trigger {
            Trigger::Cyclic(count) => self.cyclic(node, pdo, from, syncs.iter().step_by(count.into())),
            Trigger::Acyclic => {
                let at_events: Vec<_> =
                    syncs.iter().filter(|_| self.draw.below(pdo.period / self.sync.max(1)) == 0).collect();
                self.cyclic(node, pdo, from, at_events.into_iter());
            }
            Trigger::Timer => {
                let deviation = pdo.period / 1000 * node.jitter;
                for at in self.regular(from, pdo.period, deviation) {
                    let planned = self.process_data(node, pdo, at).every(pdo.period);
                    self.plan.add(planned);
                }
            }
            Trigger::Event => self.on_events(node, pdo, from),
            Trigger::Remote | Trigger::RemoteSync => self.on_request(node, pdo, from),
        }
    }

    /// A PDO because of SYNC.
    fn cyclic<'a>(&mut self, node: &NodeSpec, pdo: &PdoSpec, from: u64, syncs: impl Iterator<Item = &'a (u64, usize)>) {
        let wait = self.draw.between(200_000, 2 * MS);
        let period = match pdo.trigger {
            Trigger::Cyclic(count) => self.sync * u64::from(count),
            _ => 0,
        };
        for (sync, cause) in syncs.filter(|(sync, _)| *sync >= from) {
            let at = sync + self.draw.about(wait, 100);
            let planned = self.process_data(node, pdo, at).every(period).because_of(*cause);
            self.plan.add(planned);
        }
    }

    fn on_events(&mut self, node: &NodeSpec, pdo: &PdoSpec, from: u64) {
        let mut at = from + self.draw.below(pdo.period);
        while at < LENGTH {
            let planned = self.process_data(node, pdo, at);
            self.plan.add(planned);
            at += pdo.period / 5 + self.draw.below(pdo.period * 8 / 5);
        }
    }

    fn on_request(&mut self, node: &NodeSpec, pdo: &PdoSpec, from: u64) {
        let can_id = CanId::standard_masked(pdo.can_id(node.id).into());
        let Some(request) = Frame::remote(can_id, pdo.length) else { return };
        for at in self.regular(from, pdo.period, 2 * MS) {
            let cause = self.plan.add(Planned::new(at, request, Sort::PDO_REQUEST, node.id).every(pdo.period));
            let planned = self.process_data(node, pdo, at + MS).every(pdo.period).because_of(cause);
            self.plan.add(planned);
        }
    }

    /// A frame of a PDO.
    fn process_data(&mut self, node: &NodeSpec, pdo: &PdoSpec, at: u64) -> Planned {
        let can_id = pdo.can_id(node.id);
        let value = self.draw.number().to_le_bytes();
        if pdo.is_multiplexed {
            let object = Multiplexer::new(0x2103, value[0] % 4 + 1);
            let [_, a, b, ..] = value;
            let mpdo = Mpdo { addressing: Addressing::Source, node: node.id, object, data: [a, b, 0, 0] };
            return Planned::new(at, mpdo.to_frame(can_id), Sort::MPDO, node.id).by_node();
        }
        let data = match pdo.trigger {
            Trigger::Event | Trigger::Acyclic => value,
            // What moves all the time may as well be sent by events; a timer and SYNC also send what has not changed.
            Trigger::Timer | Trigger::Cyclic(_) if pdo.moves => {
                (at / (16 * pdo.period.max(self.sync)) * 0x0101_0101_0101).to_le_bytes()
            }
            _ if pdo.moves => value,
            _ => [pdo.number, 2, 3, 4, 5, 6, 7, 8],
        };
        let frame = frame(can_id, &data[..pdo.length.into()]);
        match pdo.is_transmitted {
            true => Planned::new(at, frame, Sort::tpdo(pdo.trigger), node.id).by_node(),
            false => Planned::new(at, frame, Sort::rpdo(pdo.trigger), node.id),
        }
    }

    /// Node guarding by the master.
    fn guard(&mut self, node: &NodeSpec, from: u64) {
        let period = self.draw.of(&[200, 500, 1000]) * MS;
        let can_id = CAN_ID_BASE + u16::from(node.id);
        let Some(request) = Frame::remote(CanId::standard_masked(can_id.into()), 1) else { return };
        for (count, at) in self.regular(from + 100 * MS, period, 3 * MS).into_iter().enumerate() {
            let cause = self.plan.add(Planned::new(at, request, Sort::GUARDING_REQUEST, node.id).every(period));
            let answer = ErrorControl { toggle: count % 2 == 1, state: State::PRE_OPERATIONAL }.to_frame(can_id);
            let at = at + self.draw.about(node.response, 200);
            let planned = Planned::new(at, answer, Sort::guarding(), node.id).every(period).by_node();
            self.plan.add(planned.because_of(cause));
        }
    }

    /// Safety-relevant data of the first nodes, and the heartbeat of the active master.
    fn safety(&mut self, nodes: &[NodeSpec], started: &[Started]) {
        let message = ErrorControl::heartbeat(State::OPERATIONAL);
        let (sort, alive) = (Sort::error_control(message), message.to_frame(CAN_ID_BASE + u16::from(MASTER)));
        self.plan.masters.push(MASTER);
        for at in self.regular(SECOND, 500 * MS, MS) {
            self.plan.add(Planned::new(at, alive, sort, MASTER).every(500 * MS).by_node());
        }
        for (node, started) in nodes.iter().zip(started).filter(|(node, _)| node.id <= 64).take(2) {
            let can_id = 0x0FF + 2 * u16::from(node.id);
            let period = self.draw.of(&[50, 100]) * MS;
            for at in self.regular(started.operational, period, MS) {
                let data = self.draw.number().to_le_bytes();
                let inverted = data.map(|byte| !byte);
                let planned = Planned::new(at, frame(can_id, &data[..2]), Sort::SRDO, node.id).every(period).by_node();
                self.plan.add(planned.clone());
                let frame = frame(can_id + 1, &inverted[..2]);
                self.plan.add(Planned { at: at + 600_000, frame, ..planned });
            }
        }
    }

    fn tell_time(&mut self) {
        for at in self.regular(2 * SECOND, SECOND, 2 * MS) {
            let now = TimeOfDay { raw_milliseconds: 36_000_000 + (at / MS) as u32, days: 14_500 };
            self.plan.add(Planned::new(at, now.to_frame(time::CAN_ID), Sort::time(), 0).every(SECOND));
        }
    }

    /// A client reads and writes objects of all nodes.
    fn work(&mut self, nodes: &[NodeSpec], events: Events) {
        let spacing = self.draw.between(180, 400) * MS;
        let mut turns = nodes.iter().cycle();
        let mut transfers = Transfer::HEALTHY.into_iter().cycle();
        // Events come later than this.
        let end = if events == Events::Some { 27_900 } else { u64::MAX };
        for (from, until) in SPANS {
            let mut at = from * MS;
            while at < until.min(end) * MS {
                let (Some(node), Some(transfer)) = (turns.next(), transfers.next()) else { return };
                let mut talk = Talk::new(&mut self.plan, &mut self.draw, node, at);
                talk.transfer(transfer);
                at = talk.at + spacing;
            }
            // Another node does the next kind.
            turns.next();
        }
    }

    /// The master stops, resets and starts single nodes.
    fn command_states(&mut self, nodes: &[NodeSpec]) {
        let node = |draw: &mut crate::draw::Draw| draw.below(nodes.len() as u64) as usize;
        let preparing = nodes[node(&mut self.draw)].id;
        self.command(Command::ENTER_PRE_OPERATIONAL, preparing, 14 * SECOND);
        self.command(Command::START, preparing, 15 * SECOND + 500 * MS);
        let reset = nodes[node(&mut self.draw)].clone();
        let cause = self.command(Command::RESET_COMMUNICATION, reset.id, 18 * SECOND);
        let booted = 18 * SECOND + self.draw.about(reset.boot, 50);
        self.boot_up(reset.id, booted, Some(cause));
        let configured = self.configure_node(&reset, booted + 100 * MS);
        self.command(Command::START, reset.id, configured + 20 * MS);
        let stopped = nodes[node(&mut self.draw)].id;
        self.command(Command::STOP, stopped, 23 * SECOND);
        self.command(Command::START, stopped, 25 * SECOND);
    }

    /// What a diagnosis has to tell even without an incident.
    fn trouble(&mut self, nodes: &[NodeSpec]) {
        for (count, node) in (0..).zip(nodes.iter().take(3)) {
            let at = (28 + 2 * count) * SECOND;
            let register = ErrorRegister(ErrorRegister::GENERIC.0 | ErrorRegister::TEMPERATURE.0);
            let raised = Emcy::new(EmcyCode(0x4210), register, [0; 5]);
            let ended = Emcy::new(EmcyCode::NO_ERROR, ErrorRegister(0), [0; 5]);
            for (at, emcy) in [(at, raised), (at + 900 * MS, ended)] {
                let frame = emcy.to_frame(emcy::CAN_ID_BASE + u16::from(node.id));
                self.plan.add(Planned::new(at, frame, Sort::emcy(), node.id).by_node());
            }
            for (transfer, after) in [(Transfer::Refused, 300), (Transfer::GivenUp, 400)] {
                let mut talk = Talk::new(&mut self.plan, &mut self.draw, node, at + after * MS);
                talk.transfer(transfer);
            }
        }
        for at in [28_500, 31_200, 34_700] {
            let error = Frame::error(ErrorClass(0x008 | 0x080), &[0, 0, 0x04, 0x0A, 0, 0, 0, 0]);
            let error = error.unwrap_or_else(|| Frame::full(CanId::standard_masked(0), [0; 8]));
            self.plan.add(Planned::new(at * MS, error, Sort::ERROR_FRAME, 0));
        }
        self.plan.add(Planned::new(36 * SECOND, frame(0x001, &[]), Sort::GLOBAL_FAIL_SAFE, 0));
    }
}
