//! Plays a plan: what happens to each frame, what its receivers make of it, and when the bus carries it.

use super::plan::{MS, Plan, Planned};
use super::sort::Sort;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_analyzer::wire::nmt::Nmt;
use canvass_traces::{ChannelId, Frame, INTERMISSION, Record, Timestamp, bit_length};
use std::collections::HashMap;

/// The time of the first record: captures of real machines have a date.
pub const EPOCH: u64 = 1_700_000_000_000_000_000;
/// Nanoseconds of a bit at 500 kbit/s.
const BIT: u64 = 2_000;
/// A client that has waited for this long for a response takes the response for lost.
pub const SDO_TIMEOUT: u64 = 500 * MS;

/// What happens to one frame of a plan.
#[derive(Clone, Debug, Default)]
pub struct Fate {
    /// The frame is never sent.
    pub lost: bool,
    /// The frame is sent this much later; negative: earlier.
    pub shift: i64,
    /// Another frame is sent instead.
    pub instead: Option<Frame>,
    /// The frame and another one have changed their places: its receivers get both.
    pub is_swapped: bool,
    /// Frames that are sent as well, at these distances from the frame's own time.
    pub also: Vec<(i64, Frame)>,
}

impl Fate {
    /// Whether nothing happens to the frame.
    pub const fn is_nothing(&self) -> bool {
        !self.lost && self.shift == 0 && self.instead.is_none() && self.also.is_empty()
    }

    /// Whether the frame's receivers get no message of its sort.
    fn is_missed(&self, planned: &Planned) -> bool {
        let is_other = |frame: &Frame| frame.id() != planned.frame.id() || frame.kind() != planned.frame.kind();
        // The first message of a transfer may come at any time.
        let is_too_late = is_sdo(&planned.sort) && planned.cause.is_some() && self.shift > SDO_TIMEOUT as i64;
        self.lost || is_too_late || !self.is_swapped && self.instead.as_ref().is_some_and(is_other)
    }
}

fn is_sdo(sort: &Sort) -> bool {
    sort.group.starts_with("sdo")
}

/// What became of a frame.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    /// It is sent, and its receivers act on it.
    Sent,
    /// Its receivers get nothing.
    Missed,
    /// It has no cause any more.
    Void,
}

/// A frame on its way.
struct Sending {
    at: u64,
    frame: Frame,
    /// The planned frame, if the receivers' states depend on it.
    of: Option<usize>,
    is_sent: bool,
    is_changed: bool,
}

/// The places of frames that an incident touches: its own, and those that follow from it.
pub fn touched(plan: &Plan, fates: &HashMap<usize, Fate>) -> Vec<usize> {
    let mut is_touched = vec![false; plan.frames.len()];
    for (place, planned) in plan.frames.iter().enumerate() {
        let own = fates.get(&place).is_some_and(|fate| !fate.is_nothing());
        is_touched[place] = own || planned.cause.is_some_and(|cause| is_touched[cause]);
    }
    (0..plan.frames.len()).filter(|place| is_touched[*place]).collect()
}

/// The records of a plan in which these frames have a fate.
pub fn play(plan: &Plan, fates: &HashMap<usize, Fate>) -> Vec<Record> {
    let mut sendings = sendings(plan, fates);
    sendings.sort_by_key(|sending| (sending.at, sending.frame.id().raw()));
    let mut nodes = Nodes::new(plan);
    let (mut free, mut records) = (0, Vec::new());
    for sending in sendings {
        for frame in nodes.react(plan, &sending).into_iter().flatten() {
            // A frame waits until the bus is free, and is stamped at its end.
            let end = sending.at.max(free) + bit_time(&frame);
            free = end;
            records.push(Record::new(Timestamp(EPOCH + end / 1000 * 1000), ChannelId(0), frame));
        }
    }
    records
}

fn bit_time(frame: &Frame) -> u64 {
    bit_length(frame).map_or(0, |bits| u64::from(bits + INTERMISSION) * BIT)
}

fn sendings(plan: &Plan, fates: &HashMap<usize, Fate>) -> Vec<Sending> {
    let none = Fate::default();
    let mut done: Vec<(Outcome, i64)> = Vec::with_capacity(plan.frames.len());
    let mut sendings = Vec::with_capacity(plan.frames.len());
    for (place, planned) in plan.frames.iter().enumerate() {
        let fate = fates.get(&place).unwrap_or(&none);
        let (of_cause, late) = planned.cause.map_or((Outcome::Sent, 0), |cause| done[cause]);
        if of_cause != Outcome::Sent {
            done.push((Outcome::Void, 0));
            continue;
        }
        let shift = late + fate.shift;
        let outcome = if fate.is_missed(planned) { Outcome::Missed } else { Outcome::Sent };
        done.push((outcome, shift));
        put(planned, place, fate, (outcome, late), &mut sendings);
    }
    sendings
}

/// Puts a frame with its fate among the sendings.
fn put(planned: &Planned, place: usize, fate: &Fate, (outcome, late): (Outcome, i64), sendings: &mut Vec<Sending>) {
    let own = planned.at.saturating_add_signed(late);
    let at = own.saturating_add_signed(fate.shift);
    let frame = fate.instead.unwrap_or(planned.frame);
    let sent = Sending { at, frame, of: Some(place), is_sent: !fate.lost, is_changed: fate.instead.is_some() };
    sendings.push(sent);
    let extra = |at, frame| Sending { at, frame, of: None, is_sent: true, is_changed: true };
    sendings.extend(fate.also.iter().map(|(after, frame)| extra(own.saturating_add_signed(*after), *frame)));
    // A client that has not begun a transfer waits for nothing.
    let is_begun = planned.cause.is_some() || !fate.lost;
    if let (Outcome::Missed, true, Some((wait, frame))) = (outcome, is_begun, planned.on_silence) {
        sendings.push(extra(own + wait, frame));
    }
}

/// The states of the nodes, as the frames that they receive make them.
struct Nodes {
    states: HashMap<u8, State>,
    /// The nodes that restart, and since when.
    restarting: HashMap<u8, u64>,
}

/// A node that restarts without a planned boot-up message is back after this time.
const LONGEST_RESTART: u64 = 2_000 * MS;

impl Nodes {
    fn new(plan: &Plan) -> Self {
        let running = plan.running.iter().map(|node| (*node, State::OPERATIONAL));
        let states = running.chain(plan.waiting.iter().map(|node| (*node, State::PRE_OPERATIONAL))).collect();
        Self { states, restarting: HashMap::new() }
    }

    /// The frames that the sender really sends in its present state.
    fn react(&mut self, plan: &Plan, sending: &Sending) -> [Option<Frame>; 2] {
        let Some(planned) = sending.of.map(|place| &plan.frames[place]) else {
            self.command(sending);
            return [None, Some(sending.frame)];
        };
        let is_boot_up = planned.sort == Sort::error_control(ErrorControl::BOOT_UP);
        if is_boot_up {
            self.boot(plan, planned.node);
        }
        let woken = planned.sender.filter(|node| self.wakes(plan, *node, sending.at));
        let boot_up = woken.map(|node| ErrorControl::BOOT_UP.to_frame(0x700 + u16::from(node)));
        if !sending.is_sent || planned.sender.is_some_and(|node| self.restarting.contains_key(&node)) {
            return [boot_up, None];
        }
        self.command(sending);
        [boot_up, self.sent(planned, sending, is_boot_up)]
    }

    /// The frame as the state of its sender makes it.
    fn sent(&self, planned: &Planned, sending: &Sending, is_boot_up: bool) -> Option<Frame> {
        let state = planned.sender.and_then(|node| self.states.get(&node)).copied();
        let is_state = planned.sort.group == "error-control" && !is_boot_up && planned.sender.is_some();
        match state {
            Some(state) if is_state && !sending.is_changed => Some(in_state(&sending.frame, state)),
            Some(state) if is_process_data(&planned.sort) && state != State::OPERATIONAL => None,
            Some(State::STOPPED) if !is_state && !is_boot_up => None,
            _ => Some(sending.frame),
        }
    }

    fn boot(&mut self, plan: &Plan, node: u8) {
        self.restarting.remove(&node);
        if plan.masters.contains(&node) {
            return;
        }
        let starts = plan.self_starting.contains(&node);
        self.states.insert(node, if starts { State::OPERATIONAL } else { State::PRE_OPERATIONAL });
    }

    /// Ends the restart of a node that has no planned boot-up message.
    fn wakes(&mut self, plan: &Plan, node: u8, now: u64) -> bool {
        let is_back = self.restarting.get(&node).is_some_and(|since| now > since + LONGEST_RESTART);
        if is_back {
            self.boot(plan, node);
        }
        is_back
    }

    /// Obeys an NMT command, whoever sends it.
    fn command(&mut self, sending: &Sending) {
        let frame = &sending.frame;
        let Some(nmt) = frame.cob_id().filter(|id| *id == 0).and_then(|_| Nmt::read(frame.data()).ok()) else { return };
        // Slaves ignore an NMT message of another length.
        let Some(state) = nmt.command.state().filter(|_| frame.len() == 2) else { return };
        for (node, own) in &mut self.states {
            if nmt.node == 0 || nmt.node == *node {
                if nmt.command.is_reset() {
                    self.restarting.insert(*node, sending.at);
                } else {
                    *own = state;
                }
            }
        }
    }
}

fn is_process_data(sort: &Sort) -> bool {
    matches!(sort.group, "pdo" | "srdo")
}

/// An error control message with another state; its toggle bit stays.
fn in_state(frame: &Frame, state: State) -> Frame {
    match ErrorControl::read(frame.data()) {
        Ok(message) => ErrorControl { state, ..message }.to_frame(frame.id().as_standard().unwrap_or(0)),
        Err(_) => *frame,
    }
}
