//! Single sequences on a simulated bus with a device that is reset, not made anew.

use super::*;
use crate::Spent;
use crate::live::Live;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::sync;
use canvass_bus::SimulatedBus;
use canvass_device::models::Model;
use canvass_device::{Device, Faults};
use canvass_traces::{CanId, Duration};

const NODE: NodeId = NodeId::MIN;

/// Runs the sequences. Returns how each ended and how its time was used.
fn run(sequences: &[Vec<Stimulus>]) -> Vec<(Ended, Spent)> {
    let model = Model::by_id("reference-301").unwrap();
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(Device::new(model, Some(NODE), Faults::NONE, 0)));
    let knowledge = Arc::new(Knowledge::new(NODE, Some(model.description()), Some(model.sheet())));
    let mut executor = Executor::new(Arc::clone(&knowledge), TimeLimit::default());
    let mut stand = Live::new(&mut bus, &knowledge);
    let run = |stimuli: &Vec<Stimulus>| {
        let sequence = Sequence { start: Start::Configured, stimuli: stimuli.clone() };
        let before = executor.tally.spent;
        let ended = executor.run(&mut stand, &sequence, Pace::Swift, true).unwrap();
        (ended, executor.tally.spent.since(&before))
    };
    sequences.iter().map(run).collect()
}

fn request(data: [u8; 8]) -> Stimulus {
    frame(0x601, &data)
}

fn frame(id: u16, data: &[u8]) -> Stimulus {
    Stimulus::settle(Frame::new(CanId::standard_masked(id.into()), data).unwrap())
}

/// A frame of two bytes leaves the state of the server open. An earlier value of 1000h is no answer to the request to
/// read 1000h that clears up this state.
#[test]
fn a_value_that_was_read_before_answers_no_question() {
    let mut stimuli = vec![request([0x40, 0x00, 0x10, 0, 0, 0, 0, 0])];
    stimuli.extend([request([0x80, 0, 0, 0, 0, 0, 0, 0]); LATELY]);
    stimuli.push(frame(0x601, &[0xA2, 0xCD]));
    stimuli.extend([frame(sync::CAN_ID, &[]); 4]);
    let ran = run(&[stimuli]);
    assert!(matches!(ran[..], [(Ended::Well, _)]), "{ran:?}");
}

/// CiA 305 leaves open what LSS does in initialisation, so nothing is judged any more. But the boot-up message of the
/// device is seen.
#[test]
fn a_device_that_has_booted_unseen_is_not_waited_for() {
    let reset = Stimulus { then: Then::AtOnce, ..frame(0, &[0x81, 1]) };
    let wait = frame(lss::MASTER_CAN_ID, &[0x04, 0, 0, 0, 0, 0, 0, 0]);
    let ran = run(&[vec![reset, Stimulus { then: Then::Pause(Duration::from_secs(1)), ..wait }], Vec::new()]);
    let [(Ended::Well, _), (Ended::Well, next)] = &ran[..] else { panic!("{ran:?}") };
    let (starts, time) = next.of(Cause::Start);
    assert!(starts == 1 && time < Duration::from_millis(300), "{next}");
}

/// A second reset is under way when the sequence ends. Its boot-up message is not taken for that of the start.
#[test]
fn a_device_that_is_reset_unseen_is_waited_for() {
    let (reset, wait) = (frame(0, &[0x81, 1]), frame(lss::MASTER_CAN_ID, &[0x04, 0, 0, 0, 0, 0, 0, 0]));
    let odd = vec![
        Stimulus { then: Then::AtOnce, ..reset },
        Stimulus { then: Then::Pause(Duration::from_secs(1)), ..wait },
        Stimulus { then: Then::AtOnce, ..reset },
    ];
    let ran = run(&[odd, vec![request([0x40, 0x00, 0x10, 0, 0, 0, 0, 0])], Vec::new()]);
    assert!(ran.iter().all(|(ended, _)| matches!(ended, Ended::Well)), "{ran:?}");
}
