//! Putting a device back writes no object that acts: tested on every model, with a change in each object that can be
//! written.

#![cfg(test)]

use super::super::{Bench, Options, Target, dictionary, interrupted, restore};
use crate::comparison::{Change, Nature};
use crate::journal::Interrupted;
use crate::touch::Touch;
use crate::zero_point::ZeroPoint;
use canvass_analyzer::wire::sdo::REQUEST_BASE;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, Machine, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Firmware};
use canvass_traces::{Duration, Frame, Record, Timestamp};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

/// The objects that act according to CiA 301, CiA 302 and CiA 406, except 1010h, for which there is a separate rule.
const BY_THE_STANDARD: [u16; 14] =
    [0x1003, 0x1011, 0x1013, 0x1023, 0x1024, 0x1025, 0x1F50, 0x1F51, 0x1F82, 0x1F83, 0x6003, 0x6009, 0x600E, 0x6010];

/// The objects that act according to manuals: each with the beginning of the ids of its models.
const BY_THE_MANUALS: [(&str, u16); 3] = [("reference-301", 0x2040), ("kuebler-sendix", 0x2105), ("kuebler-", 0x3010)];

const STORE: u16 = 0x1010;

fn acts(model: &str, index: u16) -> bool {
    let by_the_manual = BY_THE_MANUALS.iter().any(|(begins, acting)| model.starts_with(begins) && *acting == index);
    BY_THE_STANDARD.contains(&index) || by_the_manual
}

/// The node-ID of the model as delivered; a model without one gets the lowest.
fn node_of(model: &Model) -> NodeId {
    model.default_node().unwrap_or(NodeId::MIN)
}

/// Records the frames on the bus.
#[derive(Clone, Default)]
struct Listener(Arc<Mutex<Vec<Frame>>>);

impl Machine for Listener {
    fn handle(&mut self, _: Timestamp, frame: &Frame) {
        self.0.lock().unwrap().push(*frame);
    }

    fn poll_transmit(&mut self, _: Timestamp) -> Option<Frame> {
        None
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        None
    }

    fn handle_timeout(&mut self, _: Timestamp) {}
}

impl Listener {
    /// The objects with which downloads began, each with the first bytes of its value.
    fn written(&self, model: &Model) -> Vec<(u16, Vec<u8>)> {
        let request = REQUEST_BASE + u16::from(node_of(model).raw());
        let frames = self.0.lock().unwrap();
        let of_client = frames.iter().filter(|frame| frame.cob_id() == Some(request));
        let begins = of_client.filter_map(|frame| match frame.data() {
            [0x20..=0x3F | 0xC0 | 0xC2 | 0xC4 | 0xC6, low, high, _, value @ ..] => {
                Some((u16::from_le_bytes([*low, *high]), value.to_vec()))
            }
            _ => None,
        });
        begins.collect()
    }
}

/// Another value of the same length for each object that can be written.
fn other_values(bench: &mut Bench<'_>, model: &Model) -> Vec<(Multiplexer, Vec<u8>)> {
    let described = &model.device().description.dictionary;
    let mut values = dictionary::dump(bench);
    for (at, value) in &mut values {
        if described.entry(*at).is_ok_and(|entry| entry.access.is_writable()) {
            value.iter_mut().for_each(|byte| *byte ^= 1);
        }
    }
    values
}

fn changes(before: &[(Multiplexer, Vec<u8>)]) -> Vec<Change> {
    let change = |(at, value): &(Multiplexer, Vec<u8>)| Change {
        multiplexer: *at,
        name: None,
        data_type: None,
        nature: Nature::Setting,
        before: Some(value.clone()),
        after: None,
    };
    before.iter().map(change).collect()
}

/// An interrupted run that had changed and stored all writable objects and the zero point.
fn interrupted_run(values: &[(Multiplexer, Vec<u8>)], zero_point: Option<ZeroPoint>, model: &Model) -> Interrupted {
    Interrupted {
        bus: "can0".to_owned(),
        node: node_of(model),
        device: model.id().to_owned(),
        operational: true,
        values: values.to_vec(),
        memory: values.to_vec(),
        zero_point,
        stored_zero_point: zero_point,
        more: values.to_vec(),
        case: None,
        stored: true,
        begun: true,
    }
}

/// The objects that `put_back` writes, with their values, and the indexes that the printed commands write.
fn put_back(model: &Model, allow: &[Touch]) -> (Vec<(u16, Vec<u8>)>, Vec<u16>) {
    let node = node_of(model);
    let listener = Listener::default();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(Box::new(Device::new(model, Some(node), Firmware::default(), 0)));
    bus.attach(Box::new(listener.clone()));
    bus.receive(Timestamp::ZERO + Duration::from_secs(6)).unwrap();
    let (target, cancel) = (Target::of(model, node), AtomicBool::new(false));
    let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
    let mut annotate = |record: &Record| record.frame.to_string();
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    let before = other_values(&mut bench, model);
    let zero_point = bench.look_at_zero_point().unwrap();
    if let Some(preset) = zero_point.filter(|found| found.takes_position()).map(|found| found.preset()) {
        // If the user allows it, the zero point is moved, too.
        let _ = bench.with_leave_to_move(|bench| bench.download_now(preset, &100_u32.to_le_bytes()));
    }
    listener.0.lock().unwrap().clear();
    let run = interrupted_run(&before, zero_point, model);
    interrupted::put_back(&mut bench, &run, None).expect("the device answers");
    let commands = restore::commands(&bench, "can0", &before, &changes(&before), &changes(&before));
    let index = |command: &String| u16::from_str_radix(command.split(' ').nth(5)?.split(':').next()?, 16).ok();
    let printed =
        commands.iter().filter(|command| command.contains(" sdo write ")).map(|command| index(command).unwrap());
    (listener.written(model), printed.collect())
}

#[test]
fn no_object_that_acts_is_written() {
    let mut tried = 0;
    for model in Model::all() {
        for allow in [&[][..], &[Touch::Nvm], &Touch::ALL] {
            let (sent, printed) = put_back(model, allow);
            assert!(sent.len() > 3 && printed.len() > 3, "{}: {sent:?} {printed:?}", model.id());
            for index in sent.iter().map(|(index, _)| index).chain(&printed) {
                assert!(!acts(model.id(), *index), "{} with {allow:?}: {index:04X}h", model.id());
            }
            let stores: Vec<_> = sent.iter().filter(|(index, _)| *index == STORE).collect();
            assert!(stores.iter().all(|(_, value)| value == b"save"), "{}: {stores:?}", model.id());
            tried += sent.len();
        }
    }
    assert!(tried > 1_000, "{tried} writes were seen");
}
