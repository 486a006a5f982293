//! Faults of a firmware that a capture shows.

use crate::machine::{Machine, frame, shown};
use canvass_device::Fault;
use canvass_device::models::Model;
use canvass_traces::Record;

/// A fault, the actions of a master that make it show, and the rule that must find it.
type FaultSeen = (Fault, fn(&mut Machine), &'static str);

const FAULTS: [FaultSeen; 14] = [
    (Fault::BootUpTwice, reset, "nodes/starts-twice"),
    (Fault::HeartbeatPeriodDoubled, reset, "nodes/heartbeat-missing"),
    (Fault::HeartbeatWrongState, reset, "nodes/command-not-obeyed"),
    (Fault::HeartbeatLostOnStateChange, reset, "nodes/heartbeat-ended"),
    (Fault::NmtStopWhenOperationalIgnored, stop, "nodes/command-not-obeyed"),
    (Fault::TpdoWhenStopped, stop, "nodes/pdo-outside-operational"),
    (Fault::SdoAnsweredWhenStopped, stop, "nodes/sdo-in-stopped"),
    (Fault::GuardingToggleStuck, guard, "nodes/guarding-toggle"),
    (Fault::EventTimerDoubled, cycle, "pdo/period"),
    (Fault::SyncCycleIgnored, synchronous, "pdo/sync-pdo-missing"),
    (Fault::SdoStaleMultiplexer, absent, "sdo/protocol-violation"),
    (Fault::SdoSegmentLengthWrong, name, "sdo/protocol-violation"),
    (Fault::SdoSilentWhenOperational, cycle, "sdo/unanswered"),
    (Fault::RestrictedCanIdAccepted, restricted, "bus/restricted-cob-id"),
];

fn heartbeat(machine: &mut Machine) {
    machine.read(0x1000, 0);
    machine.write(0x1017, 0, 100, 2);
    machine.run(1_000);
}

fn reset(machine: &mut Machine) {
    heartbeat(machine);
    machine.write(0x1010, 1, u32::from_le_bytes(*b"save"), 4);
    machine.run(500);
    // The machine resets twice: after the first reset the diagnosis knows whether the device sends a boot-up message.
    machine.command(0x01);
    machine.run(3_000);
    machine.command(0x82);
    machine.run(3_000);
    machine.command(0x01);
    machine.syncs = true;
    machine.run(8_000);
}

fn stop(machine: &mut Machine) {
    heartbeat(machine);
    machine.write(0x1800, 5, 50, 2);
    machine.command(0x01);
    machine.run(2_000);
    machine.command(0x02);
    machine.run(1_000);
    machine.send(0x600 + u16::from(machine.node.raw()), &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    machine.run(2_000);
}

fn guard(machine: &mut Machine) {
    machine.guards = true;
    machine.run(3_000);
}

fn cycle(machine: &mut Machine) {
    machine.read(0x1800, 2);
    machine.write(0x1800, 5, 50, 2);
    machine.read(0x1800, 5);
    heartbeat(machine);
    machine.command(0x01);
    machine.run(3_000);
    machine.read(0x6004, 0);
    machine.run(2_500);
}

fn synchronous(machine: &mut Machine) {
    machine.write(0x1801, 2, 4, 1);
    machine.syncs = true;
    machine.command(0x01);
    machine.run(3_000);
}

fn absent(machine: &mut Machine) {
    machine.read(0x1018, 1);
    machine.ask([0x40, 0x00, 0x50, 0, 0, 0, 0, 0]);
    machine.run(200);
}

fn name(machine: &mut Machine) {
    machine.read(0x1008, 0);
    machine.run(200);
}

fn restricted(machine: &mut Machine) {
    let cob_id = machine.read(0x1800, 1).unwrap();
    machine.write(0x1800, 1, cob_id | 0x8000_0000, 4);
    machine.write(0x1800, 1, 0x0101, 4);
    machine.run(200);
}

#[test]
fn faults_that_show_in_a_capture_are_found() {
    let model = Model::by_id("kuebler-sendix-58x8").unwrap();
    let mut missed = Vec::new();
    for (fault, act, rule) in FAULTS {
        let mut machine = Machine::new(model, fault);
        act(&mut machine);
        let findings = machine.findings(false);
        let own = findings.iter().filter(|finding| finding.rule.id == rule);
        let right = own.filter(|finding| finding.node == Some(machine.node) && !finding.evidence.is_empty()).count();
        if right == 0 {
            missed.push(format!("{fault}: {:#?}", findings.iter().map(shown).collect::<Vec<_>>()));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

/// The actions that make the faults show cause no findings on a fault-free device.
#[test]
fn without_their_fault_nothing_is_found() {
    let model = Model::by_id("kuebler-sendix-58x8").unwrap();
    for (fault, act, _) in FAULTS {
        // The actions for these faults make requests that a fault-free device refuses.
        if matches!(fault, Fault::SdoStaleMultiplexer | Fault::RestrictedCanIdAccepted) {
            continue;
        }
        let mut machine = Machine::new(model, canvass_device::Faults::NONE);
        act(&mut machine);
        let findings = machine.findings(false);
        assert!(findings.is_empty(), "{fault}: {:#?}", findings.iter().map(shown).collect::<Vec<_>>());
    }
}

/// Both channels of a draw-wire encoder suddenly move by 2.5 m: a finding. If a download just before the jump explains
/// it, there is no finding.
#[test]
fn a_draw_wire_jumps() {
    const FURTHER: u16 = 25_000;
    let mut machine = Machine::new(Model::by_id("kuebler-c100").unwrap(), canvass_device::Faults::NONE);
    machine.read(0x1000, 0);
    machine.command(0x01);
    machine.run(5_000);
    assert!(machine.findings(true).is_empty());
    let id = 0x180 + u16::from(machine.node.raw());
    let tpdos: Vec<usize> =
        (0..machine.records.len()).filter(|&at| machine.records[at].frame.cob_id() == Some(id)).collect();
    let (first, end) = (tpdos[20], tpdos[25]);
    machine.records.truncate(end);
    let channels = |record: &Record| {
        let bytes = record.frame.bytes();
        [u16::from_le_bytes([bytes[0], bytes[1]]), u16::from_le_bytes([bytes[2], bytes[3]])]
    };
    let forwards = channels(&machine.records[first])[0] < FURTHER;
    for at in tpdos.into_iter().filter(|at| (first..end).contains(at)) {
        let [a, b] = channels(&machine.records[at]);
        let [a, b] = if forwards { [a + FURTHER, b - FURTHER] } else { [a - FURTHER, b + FURTHER] };
        machine.records[at].frame = frame(id, &[a.to_le_bytes(), b.to_le_bytes()].concat());
    }
    let findings = machine.findings(true);
    let [finding] = findings.as_slice() else { panic!("{:#?}", findings.iter().map(shown).collect::<Vec<_>>()) };
    assert_eq!((finding.rule.id, finding.node), ("encoder/position-jump", Some(machine.node)));
    assert_eq!(finding.first, machine.records[first].timestamp);
    let dialogue = [(0x600, [0x2F, 0x03, 0x30, 0x00, 0x01, 0, 0, 0]), (0x580, [0x60, 0x03, 0x30, 0x00, 0, 0, 0, 0])];
    for (at, (base, bytes)) in (first..).zip(dialogue) {
        let mut record = machine.records[first - 1].clone();
        record.frame = frame(base + u16::from(machine.node.raw()), &bytes);
        machine.records.insert(at, record);
    }
    let findings = machine.findings(true);
    assert!(findings.is_empty(), "{:#?}", findings.iter().map(shown).collect::<Vec<_>>());
}
