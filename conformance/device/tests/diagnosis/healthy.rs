//! Each built-in model without faults: boot-up, identity, configuration, LSS, a store, operation, stop, reset.

use crate::machine::{Machine, shown};
use canvass_device::Faults;
use canvass_device::models::Model;

/// The usual actions of a master with an encoder, as far as the model supports them.
fn operate(model: &'static Model) -> Machine {
    let mut machine = Machine::new(model, Faults::NONE);
    for (index, sub) in [(0x1000, 0), (0x1001, 0), (0x1018, 1), (0x1018, 2), (0x1018, 3), (0x1018, 4)] {
        machine.read(index, sub);
    }
    for index in [0x1008, 0x1009, 0x100A, 0x6500, 0x6501, 0x6502, 0x6000, 0x6001, 0x6002, 0x6503, 0x6505] {
        machine.read(index, 0);
    }
    for pdo in 0..4 {
        for sub in [1, 2, 3, 5] {
            machine.read(0x1800 + pdo, sub);
        }
        for sub in 0..3 {
            machine.read(0x1A00 + pdo, sub);
        }
    }
    error_control(&mut machine);
    if machine.has_writable(0x6200, 0) {
        machine.write(0x6200, 0, 50, 2);
    }
    if machine.has_writable(0x1800, 5) {
        machine.write(0x1800, 5, 50, 2);
    }
    if model.sheet().network.lss {
        layer_setting(&mut machine);
    }
    if machine.has_writable(0x1010, 1) {
        machine.write(0x1010, 1, u32::from_le_bytes(*b"save"), 4);
    }
    machine.run(500);
    machine.syncs = true;
    machine.command(0x01);
    for _ in 0..10 {
        machine.run(900);
        machine.read(0x6004, 0);
        machine.read(0x6020, 1);
    }
    machine.command(0x02);
    machine.run(1_000);
    machine.command(0x01);
    machine.run(2_000);
    machine.guards = false;
    machine.command(0x81);
    machine.run(1_500);
    machine.command(0x01);
    machine.run(3_000);
    machine
}

/// Configures the heartbeat, or guarding if the device has no heartbeat.
fn error_control(machine: &mut Machine) {
    if machine.has_writable(0x1017, 0) {
        return machine.write(0x1017, 0, 200, 2);
    }
    if machine.model.sheet().network.node_guarding {
        if machine.has_writable(0x100C, 0) {
            machine.write(0x100C, 0, 300, 2);
            machine.write(0x100D, 0, 3, 1);
        }
        machine.guards = true;
    }
}

/// Inquires the LSS address and the node-ID of the only slave.
fn layer_setting(machine: &mut Machine) {
    machine.send(0x7E5, &[0x04, 0x01, 0, 0, 0, 0, 0, 0]);
    for command in 0x5A..=0x5E {
        machine.run(20);
        machine.send(0x7E5, &[command, 0, 0, 0, 0, 0, 0, 0]);
    }
    machine.run(20);
    machine.send(0x7E5, &[0x04, 0x00, 0, 0, 0, 0, 0, 0]);
    machine.run(1_500);
}

#[test]
fn nothing_is_found_with_any_model_in_normal_operation() {
    let mut problems = Vec::new();
    for model in Model::all() {
        let machine = operate(model);
        let pdos = machine.records.iter().filter(|record| matches!(record.frame.cob_id(), Some(0x181..=0x57F)));
        assert!(pdos.count() > 100, "{} has sent hardly any PDO", model.id());
        for described in [false, true] {
            let findings = machine.findings(described);
            let how = if described { "described" } else { "unknown" };
            problems.extend(findings.iter().map(|finding| format!("{}, {how}: {}", model.id(), shown(finding))));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

/// A capture may begin and end at any time.
#[test]
fn nothing_is_found_in_any_part_of_it() {
    let mut problems = Vec::new();
    for model in Model::all() {
        let mut machine = operate(model);
        let all = std::mem::take(&mut machine.records);
        for begin in (0..all.len()).step_by(all.len() / 23) {
            let end = (begin + all.len() / 3).min(all.len());
            machine.records = all[begin..end].to_vec();
            let findings = machine.findings(begin % 2 == 0);
            problems.extend(findings.iter().map(|finding| format!("{} from {begin}: {}", model.id(), shown(finding))));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}
