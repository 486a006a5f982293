//! Millions of valid and invalid frames for a simulated device in every state. The device must not panic, must not be
//! busy for ever, and must work again after it was switched off and on.
//!
//! Unlike a campaign, a storm judges nothing else, so that it sends millions of frames in seconds.

use super::generate::Dice;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::sdo::{Request, Response};
use canvass_analyzer::wire::{Wire, emcy, error_control, lss, nmt, sdo, sync, time};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::Machine;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_device::{Fault, Faults};
use canvass_traces::{CanId, Duration, Flags, Frame, Timestamp};
use proptest::test_runner::{RngAlgorithm, TestRng};

/// The figures of a storm.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Storm {
    /// Number of frames that the device received.
    pub frames: u64,
    /// Number of frames that the device sent.
    pub sent: u64,
    /// Number of frames received in each state: without node-ID, in initialisation, in pre-operational, in operational,
    /// in stopped.
    pub by_state: [u64; 5],
    /// Number of times that the device was switched on.
    pub starts: u64,
    /// The time that passed for the device.
    pub time: Duration,
}

/// A device that failed.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Broken {
    /// The device does not answer a request for its device type after it was switched off and on.
    #[error(
        "{model}: expected an answer to the device type after {frames} frames and power-on, found none (seed {seed})"
    )]
    Silent {
        /// The model.
        model: String,
        /// Number of frames until then.
        frames: u64,
        /// The seed of the storm.
        seed: u64,
    },
    /// The device requests a wake-up again and again.
    #[error(
        "{model}: expected that time goes on after {frames} frames, found {WAKES} wake-ups in {pause} (seed {seed})"
    )]
    Restless {
        /// The model.
        model: String,
        /// Number of frames until then.
        frames: u64,
        /// Number of wake-ups.
        wakes: u64,
        /// The pause in which they came.
        pause: Duration,
        /// The seed of the storm.
        seed: u64,
    },
}

/// Number of frames that a device receives before it is switched off and on.
const EPISODE: u64 = 2_000;
/// Maximum number of wake-ups in a pause of any length.
const WAKES: u64 = 1_000;
/// Number of further wake-ups for each millisecond of a pause. The device may have many timers, but none is finer than
/// a millisecond.
const WAKES_PER_MILLISECOND: u64 = 100;
/// A time longer than any device takes to start and to write its memory.
const START: Duration = Duration::from_secs(10);
const USUAL_NODE: u8 = 63;
const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);

/// Sends `frames` random frames to a device of this model. The same seed gives the same storm.
///
/// One device in eight has a random combination of faults. Such a device may fall silent.
///
/// # Errors
/// [`Broken`] if the device fails.
pub fn storm(model: &Model, frames: u64, seed: u64) -> Result<Storm, Broken> {
    let mut bytes = [0; 16];
    // This algorithm does not accept a seed of zeros only.
    bytes[..8].copy_from_slice(&(seed | 1 << 63).to_le_bytes());
    let mut rng = TestRng::from_seed(RngAlgorithm::XorShift, &bytes);
    let addresses = model.description().dictionary.entries().map(|(at, _)| at).collect();
    let mut attack = Attack { model, addresses, dice: Dice::new(&mut rng), done: Storm::default(), seed, last: None };
    while attack.done.frames < frames {
        attack.episode(EPISODE.min(frames - attack.done.frames))?;
    }
    Ok(attack.done)
}

struct Attack<'a> {
    model: &'a Model,
    addresses: Vec<Multiplexer>,
    dice: Dice<'a>,
    done: Storm,
    seed: u64,
    /// The previous frame, which may be sent again with one byte changed.
    last: Option<Frame>,
}

/// A device and its current time.
struct Attacked {
    device: Device,
    now: Timestamp,
}

impl Attack<'_> {
    fn episode(&mut self, frames: u64) -> Result<(), Broken> {
        let faults = self.faults();
        // One device in eight has no node-ID, another device in eight has faults.
        let node = if self.done.starts % 8 == 5 { None } else { self.model.default_node().or(NodeId::new(USUAL_NODE)) };
        let motion = Motion::constant(self.dice.number() as i64 >> 20, self.dice.number() as i64 >> 40);
        let device = Device::with_motion(self.model, node, faults, self.dice.number(), &motion);
        let mut attacked = Attacked { device, now: Timestamp::ZERO };
        self.done.starts += 1;
        // The device enters a random state, which the frames may change.
        let pause = if self.dice.one_in(5) { Duration::from_millis(1) } else { Duration::from_secs(1) };
        self.pass(&mut attacked, pause)?;
        for command in self.dice.one_of([&[][..], &[1], &[1], &[2], &[1, 2], &[0x80]]) {
            self.give(&mut attacked, &short(nmt::CAN_ID, &[*command, 0]));
        }
        for _ in 0..frames {
            let frame = self.frame(&attacked);
            self.last = Some(frame);
            self.give(&mut attacked, &frame);
            let pause = self.pause(&frame);
            self.pass(&mut attacked, pause)?;
        }
        attacked.device.power_cycle(attacked.now);
        self.pass(&mut attacked, START)?;
        let alive = self.answers(&mut attacked)?;
        self.done.time = self.done.time + attacked.now.since(Timestamp::ZERO);
        if alive || faults != Faults::NONE {
            return Ok(());
        }
        Err(Broken::Silent { model: self.model.id().to_owned(), frames: self.done.frames, seed: self.seed })
    }

    fn faults(&mut self) -> Faults {
        if self.done.starts % 8 != 7 {
            return Faults::NONE;
        }
        let count = 1 + self.dice.below(5);
        (0..count).filter_map(|_| self.dice.pick(Fault::ALL).copied()).collect()
    }

    fn pause(&mut self, frame: &Frame) -> Duration {
        let is_reset = frame.id().raw() == u32::from(nmt::CAN_ID) && frame.data().first().is_some_and(|&c| c > 0x80);
        match self.dice.below(256) {
            // A shorter pause would leave the device in initialisation for nearly all frames.
            _ if is_reset && !self.dice.one_in(8) => Duration::from_millis(500),
            0 => Duration::from_millis(self.dice.below(6_000) as u64),
            1..8 => Duration::from_millis(self.dice.below(50) as u64),
            8..128 => Duration::from_micros(self.dice.below(2_000) as u64),
            _ => Duration::from_micros(47),
        }
    }

    fn give(&mut self, attacked: &mut Attacked, frame: &Frame) {
        let state = match (attacked.device.node(), attacked.device.state()) {
            (None, _) => 0,
            (_, State::BOOT_UP) => 1,
            (_, State::PRE_OPERATIONAL) => 2,
            (_, State::OPERATIONAL) => 3,
            _ => 4,
        };
        if let Some(count) = self.done.by_state.get_mut(state) {
            *count += 1;
        }
        self.done.frames += 1;
        attacked.device.handle(attacked.now, frame);
        self.drain(attacked);
    }

    fn drain(&mut self, attacked: &mut Attacked) -> Option<Frame> {
        let mut last = None;
        while let Some(frame) = attacked.device.poll_transmit(attacked.now) {
            self.done.sent += u64::from(!attacked.device.withdraws(&frame));
            last = Some(frame);
        }
        last
    }

    /// Lets time pass. Returns the last frame that the device sends meanwhile.
    fn pass(&mut self, attacked: &mut Attacked, pause: Duration) -> Result<Option<Frame>, Broken> {
        let until = attacked.now + pause;
        let mut last = None;
        let most = WAKES + WAKES_PER_MILLISECOND * (pause.nanos() / 1_000_000);
        let mut wakes = 0;
        while let Some(due) = attacked.device.poll_timeout().filter(|due| *due <= until) {
            // As on a bus, time goes on whatever the device requests.
            attacked.now = due.max(attacked.now + Duration(1));
            attacked.device.handle_timeout(attacked.now);
            last = self.drain(attacked).or(last);
            wakes += 1;
            if wakes > most {
                let (model, frames, seed) = (self.model.id().to_owned(), self.done.frames, self.seed);
                return Err(Broken::Restless { model, frames, wakes, pause, seed });
            }
        }
        attacked.now = attacked.now.max(until);
        Ok(last)
    }

    /// Whether the device answers a request for its device type, in the state in which it has started.
    fn answers(&mut self, attacked: &mut Attacked) -> Result<bool, Broken> {
        let Some(node) = attacked.device.node() else { return Ok(true) };
        let node = u16::from(node.raw());
        attacked.device.handle(attacked.now, &Request::upload(DEVICE_TYPE).to_frame(sdo::REQUEST_BASE + node));
        let until = attacked.now + Duration::from_millis(50);
        while let Some(due) = attacked.device.poll_timeout().filter(|due| *due <= until) {
            attacked.now = due.max(attacked.now + Duration(1));
            attacked.device.handle_timeout(attacked.now);
            while let Some(frame) = attacked.device.poll_transmit(attacked.now) {
                let response = Response::read(frame.data()).ok().and_then(|response| response.multiplexer());
                if frame.cob_id() == Some(sdo::RESPONSE_BASE + node) && response == Some(DEVICE_TYPE) {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    fn frame(&mut self, attacked: &Attacked) -> Frame {
        let node = attacked.device.node().map_or(USUAL_NODE, NodeId::raw);
        match self.dice.below(32) {
            0..16 => self.sdo(node),
            16 | 17 => self.nmt(node),
            18..21 => self.layer_setting(),
            21 | 22 => {
                let len = self.dice.one_of([0, 0, 1, 1, 2, 8]);
                self.bytes(sync::CAN_ID, len)
            }
            23 => self.bytes(time::CAN_ID, 6),
            24 | 25 => {
                let base = self.dice.one_of([0x180, 0x200, 0x280, 0x300, 0x380, 0x400, 0x480, 0x500]);
                let len = self.dice.below(9);
                self.bytes(base + u16::from(node), len)
            }
            26 => {
                let peer = error_control::CAN_ID_BASE + u16::from(self.dice.byte() & 0x7F);
                let state = self.dice.one_of([0, 4, 5, 0x7F, 0x85, 0xFF]);
                short(peer, &[state])
            }
            27 => remote(self.dice.one_of([0x700, 0x180, 0x280, 0x600, 0x080]) + u16::from(node)),
            28 => {
                let peer = self.addressed(node);
                self.bytes(emcy::CAN_ID_BASE + u16::from(peer), 8)
            }
            29 | 30 => self.distorted(),
            _ => self.anything(),
        }
    }

    fn sdo(&mut self, node: u8) -> Frame {
        let id = self.dice.one_of([0x600, 0x600, 0x600, 0x600, 0x600, 0x640, 0x680]) + u16::from(node);
        let command = match self.dice.below(4) {
            0 => self.dice.byte(),
            1 => self.dice.one_of([0x40, 0x40, 0x40, 0x60, 0x70, 0x21, 0x20, 0x80]),
            2 => self.dice.one_of([0x23, 0x27, 0x2B, 0x2F, 0x22, 0x00, 0x10, 0x01, 0x11, 0x0D]),
            _ => self.dice.one_of([0xA0, 0xA4, 0xA1, 0xA2, 0xA3, 0xC0, 0xC2, 0xC6, 0xC1, 0xD5, 0x81, 0x02, 0x83]),
        };
        let known = self.dice.pick(&self.addresses).copied().unwrap_or(DEVICE_TYPE);
        let [low, high, sub] = known.to_bytes();
        let (low, sub) = match self.dice.below(16) {
            0 => (self.dice.byte(), sub),
            1 => (low, self.dice.byte()),
            _ => (low, sub),
        };
        let value = match self.dice.below(8) {
            0 => *b"save",
            1 => *b"load",
            2 => [0; 4],
            3 => [0xFF; 4],
            4 => [self.dice.byte(), 0, 0, 0],
            5 => ((0x180 + u32::from(node)) | u32::from(self.dice.byte()) << 24).to_le_bytes(),
            6 => self.dice.pick(&self.addresses).copied().map_or([0; 4], |at| {
                let bits = [8, 16, 32, 64, 1].get(usize::from(low & 3)).copied().unwrap_or(8);
                [bits, at.sub.0, at.to_bytes()[0], at.to_bytes()[1]]
            }),
            _ => (self.dice.number() as u32).to_le_bytes(),
        };
        let bytes = [command, low, high, sub, value[0], value[1], value[2], value[3]];
        let len = if self.dice.one_in(32) { self.dice.below(9) } else { 8 };
        short(id, bytes.get(..len).unwrap_or(&bytes))
    }

    fn nmt(&mut self, node: u8) -> Frame {
        let command = self.dice.one_of([1, 1, 1, 1, 2, 2, 0x80, 0x80, 0x81, 0x82, 0, 0x7F]);
        let bytes = [command, self.addressed(node), self.dice.byte()];
        let len = if self.dice.one_in(8) { self.dice.below(4) } else { 2 };
        short(nmt::CAN_ID, bytes.get(..len).unwrap_or(&bytes))
    }

    /// A random frame of LSS or LMT.
    fn layer_setting(&mut self) -> Frame {
        let known = [
            0x04, 0x04, 0x11, 0x13, 0x15, 0x17, 0x40, 0x41, 0x42, 0x43, 0x46, 0x47, 0x48, 0x49, 0x4A, 0x4B, 0x4C, 0x51,
            0x5A, 0x5B, 0x5C, 0x5D, 0x5E, 0x01, 0x02, 0x03, 0x05, 0x06, 0x07, 0x08, 0x24, 0x25, 0x26,
        ];
        let command = if self.dice.one_in(8) { self.dice.byte() } else { self.dice.one_of(known) };
        let own = self.dice.below(4) as u8 + 1;
        let identity = self.model.description().dictionary.entry(Multiplexer::new(object::IDENTITY, own)).ok();
        let identity = identity.and_then(|entry| entry.default.as_ref()?.fixed()?.to_raw());
        let mut bytes = self.dice.number().to_le_bytes();
        bytes[0] = command;
        match identity {
            Some(number) if self.dice.flip() => bytes[1..5].copy_from_slice(&(number as u32).to_le_bytes()),
            _ if self.dice.flip() => bytes[1..5].copy_from_slice(&[self.dice.byte() & 0x7F, 0, 0, 0]),
            _ => {}
        }
        if self.dice.flip() {
            bytes[5] = self.dice.one_of([0, 1, 31, 32, 0x80]);
            bytes[6] &= 3;
            bytes[7] &= 3;
        }
        let len = if self.dice.one_in(16) { self.dice.below(9) } else { 8 };
        short(lss::MASTER_CAN_ID, bytes.get(..len).unwrap_or(&bytes))
    }

    /// The frame before with one byte changed, or cut short.
    fn distorted(&mut self) -> Frame {
        let Some(last) = self.last else { return self.anything() };
        let mut bytes = last.bytes();
        let at = self.dice.below(8);
        if let Some(byte) = bytes.get_mut(at) {
            *byte ^= 1 << self.dice.below(8);
        }
        let len = if self.dice.one_in(4) { self.dice.below(9) } else { last.len().min(8) };
        Frame::new(last.id(), bytes.get(..len).unwrap_or(&bytes)).unwrap_or(last)
    }

    /// A frame of any kind, with any identifier in either format.
    fn anything(&mut self) -> Frame {
        let raw = self.dice.number() as u32;
        let id = if self.dice.one_in(4) { CanId::extended_masked(raw) } else { CanId::standard_masked(raw) };
        let bytes = self.dice.number().to_le_bytes();
        let len = self.dice.below(9);
        let data = bytes.get(..len).unwrap_or(&bytes);
        let other = match self.dice.below(8) {
            0 => Frame::remote(id, len as u8),
            1 => Frame::error(canvass_traces::ErrorClass(raw & 0x1FF), data),
            2 => Frame::fd(id, Flags::BRS, data),
            _ => Frame::new(id, data),
        };
        other.unwrap_or(Frame::full(id, bytes))
    }

    fn bytes(&mut self, id: u16, len: usize) -> Frame {
        let bytes = self.dice.number().to_le_bytes();
        short(id, bytes.get(..len).unwrap_or(&bytes))
    }

    /// The device's node-ID, all nodes, or another node-ID.
    fn addressed(&mut self, node: u8) -> u8 {
        match self.dice.below(8) {
            0 => 0,
            1 => self.dice.byte() & 0x7F,
            _ => node,
        }
    }
}

fn short(id: u16, bytes: &[u8]) -> Frame {
    let id = CanId::standard_masked(u32::from(id));
    Frame::new(id, bytes).unwrap_or(Frame::full(id, [0; 8]))
}

fn remote(id: u16) -> Frame {
    let id = CanId::standard_masked(u32::from(id));
    Frame::remote(id, 1).unwrap_or(Frame::full(id, [0; 8]))
}
