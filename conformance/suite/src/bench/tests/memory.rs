//! The memory of a device and its zero point are as before, whatever a case did to them: tested on simulated devices by
//! the values after the next start.

#![cfg(test)]

use super::super::{Bench, Options, Target, baseline, dictionary, interrupted};
use crate::journal::Interrupted;
use crate::touch::Touch;
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Faults, Firmware};
use canvass_traces::{Duration, Record, Timestamp};
use std::sync::atomic::AtomicBool;

const HEARTBEAT: Multiplexer = Multiplexer::new(0x1017, 0);
const INHIBIT: Multiplexer = Multiplexer::new(0x1015, 0);
const GUARD_TIME: Multiplexer = Multiplexer::new(0x100C, 0);
const STORE: Multiplexer = Multiplexer::new(0x1010, 1);
const RESTORE: Multiplexer = Multiplexer::new(0x1011, 1);
const PRESET: Multiplexer = Multiplexer::new(0x6003, 0);
const OFFSET: Multiplexer = Multiplexer::new(0x6509, 0);
const POSITION: Multiplexer = Multiplexer::new(0x6004, 0);

/// Runs `test` on a bench with a device of this model, which has started and whose dictionary was read.
fn on<T>(model: &str, fault: Option<Fault>, allow: &[Touch], test: impl FnOnce(&mut Bench<'_>) -> T) -> T {
    let model = Model::by_id(model).unwrap();
    let node = model.default_node().unwrap();
    let faults: Faults = fault.into_iter().collect();
    let firmware: Firmware = faults.into();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(Box::new(Device::new(model, Some(node), firmware, 0)));
    bus.receive(Timestamp::ZERO + Duration::from_secs(6)).unwrap();
    let (target, cancel) = (Target::of(model, node), AtomicBool::new(false));
    let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
    let mut annotate = |record: &Record| record.frame.to_string();
    test(&mut Bench::new(&mut bus, &target, &options, &mut annotate, &cancel))
}

/// A user has stored a heartbeat time of 2 s, and works with one of 1 s.
fn at_work(bench: &mut Bench<'_>) -> Vec<(Multiplexer, Vec<u8>)> {
    bench.write(HEARTBEAT, &[0xD0, 7]).unwrap();
    bench.write(STORE, b"save").unwrap();
    bench.listen(Duration::from_millis(500)).unwrap();
    bench.write(HEARTBEAT, &[0xE8, 3]).unwrap();
    bench.begin();
    bench.changes.take();
    baseline::note_zero_point(bench, true);
    let dictionary = dictionary::dump(bench);
    baseline::learn_memory(bench, &dictionary).unwrap();
    dictionary
}

fn after_a_start(bench: &mut Bench<'_>, at: Multiplexer) -> u32 {
    bench.reset(Command::RESET_NODE).unwrap();
    bench.read_number(at).unwrap()
}

/// All values that a case stored, those that it has written and those that were in use, are gone after the next start;
/// the values in use are in use again.
#[test]
fn what_a_case_stored_does_not_stay() {
    on("reference-301", None, &[Touch::Nvm], |bench| {
        let dictionary = at_work(bench);
        bench.begin();
        bench.write(HEARTBEAT, &[50, 0]).unwrap();
        bench.write(GUARD_TIME, &[100, 0]).unwrap();
        bench.write(STORE, b"save").unwrap();
        bench.finish();
        assert_eq!(after_a_start(bench, HEARTBEAT), 50, "finish puts back what is in use only");
        baseline::settle_memory(bench, &[Touch::Nvm]);
        assert_eq!(after_a_start(bench, HEARTBEAT), 2_000);
        assert_eq!(bench.read_number(GUARD_TIME), Ok(0));
        let comparison = baseline::put_back_device(bench, "sim:x", false, &dictionary);
        assert!(comparison.is_as_found(), "{comparison:?}");
        assert_eq!(bench.read_number(HEARTBEAT), Ok(1_000));
        assert_eq!(after_a_start(bench, HEARTBEAT), 2_000);
    });
}

/// A memory without changes is not written again, because it wears out.
#[test]
fn a_memory_that_is_as_it_was_is_not_written() {
    on("reference-301", None, &[Touch::Nvm], |bench| {
        at_work(bench);
        let stores = bench.stores();
        baseline::settle_memory(bench, &[Touch::Nvm]);
        baseline::settle_memory(bench, &[]);
        assert_eq!(bench.stores(), stores);
    });
}

/// Restored defaults do not remain in the memory.
#[test]
fn restored_defaults_do_not_stay() {
    on("reference-301", None, &[Touch::Nvm, Touch::FactoryDefaults], |bench| {
        at_work(bench);
        bench.begin();
        bench.write(RESTORE, b"load").unwrap();
        assert_eq!(after_a_start(bench, HEARTBEAT), 0);
        bench.finish();
        baseline::settle_memory(bench, &[Touch::Nvm, Touch::FactoryDefaults]);
        assert_eq!(after_a_start(bench, HEARTBEAT), 2_000);
    });
}

/// A device that does not store restored defaults still has in its memory the values that a case has stored before. No
/// reset shows these values, only power-off.
#[test]
fn what_restored_defaults_hide_does_not_stay() {
    on("lika-ax58", None, &[Touch::Nvm, Touch::FactoryDefaults], |bench| {
        bench.begin();
        baseline::note_zero_point(bench, true);
        let dictionary = dictionary::dump(bench);
        baseline::learn_memory(bench, &dictionary).unwrap();
        let as_delivered = bench.read_number(INHIBIT).unwrap();
        bench.begin();
        bench.write(INHIBIT, &[100, 0]).unwrap();
        bench.write(STORE, b"save").unwrap();
        bench.listen(Duration::from_millis(500)).unwrap();
        bench.write(RESTORE, b"load").unwrap();
        bench.finish();
        let stores = bench.stores();
        baseline::settle_memory(bench, &[Touch::Nvm, Touch::FactoryDefaults]);
        assert_eq!(bench.stores(), stores + 1, "the values as delivered are stored");
        let comparison = baseline::put_back_device(bench, "sim:x", false, &dictionary);
        assert!(comparison.is_as_found(), "{comparison:?}");
        assert_eq!([after_a_start(bench, INHIBIT), after_a_start(bench, INHIBIT)], [as_delivered; 2]);
    });
}

/// Stored values that can't be put back are reported with the commands that put them back, memory first, even if the
/// user had not allowed writing the memory.
#[test]
fn a_memory_that_is_not_as_it_was_is_told() {
    on("reference-301", None, &[], |bench| {
        let dictionary = at_work(bench);
        bench.write(HEARTBEAT, &[50, 0]).unwrap();
        // The store counts as a store of somebody else.
        bench.write(STORE, b"save").unwrap();
        let comparison = baseline::put_back_device(bench, "sim:x", false, &dictionary);
        let stored: Vec<(String, Option<Vec<u8>>)> =
            comparison.stored.iter().map(|change| (change.multiplexer.to_string(), change.after.clone())).collect();
        assert_eq!(stored, [("1017h:00".to_owned(), Some(vec![50, 0]))]);
        assert!(!comparison.is_as_found());
        let expected = [
            "canvass nmt sim:x reset-node 10",
            "canvass sdo write sim:x 10 1017:00 D007 --type bytes",
            "canvass sdo write sim:x 10 1010:01 73617665 --type bytes",
            "canvass sdo write sim:x 10 1017:00 E803 --type bytes",
        ];
        assert_eq!(comparison.commands, expected);
    });
}

/// Stores a zero point other than the one as delivered.
fn preset_to(bench: &mut Bench<'_>, position: u32) -> u32 {
    bench.write(PRESET, &position.to_le_bytes()).unwrap();
    bench.write(STORE, b"save").unwrap();
    bench.listen(Duration::from_millis(500)).unwrap();
    bench.begin();
    baseline::note_zero_point(bench, true);
    let dictionary = dictionary::dump(bench);
    baseline::learn_memory(bench, &dictionary).unwrap();
    bench.read_number(OFFSET).unwrap()
}

/// A preset that a case stored is reversed at rest, to the step, and stored.
#[test]
fn a_zero_point_that_a_case_stored_is_put_back() {
    on("reference-406", None, &[Touch::Nvm, Touch::Preset], |bench| {
        let offset = preset_to(bench, 30_000);
        bench.begin();
        bench.write(PRESET, &[1, 2, 3, 0]).unwrap();
        bench.write(STORE, b"save").unwrap();
        bench.finish();
        assert_ne!(after_a_start(bench, OFFSET), offset);
        baseline::settle_memory(bench, &[Touch::Nvm, Touch::Preset]);
        assert_eq!((after_a_start(bench, OFFSET), bench.read_number(POSITION)), (offset, Ok(30_000)));
    });
}

/// On a firmware that stores presets by itself, the zero point is put back if the user allows presets, even if the user
/// does not allow stores.
#[test]
fn a_zero_point_that_stays_by_itself_is_put_back() {
    on("reference-406", Some(Fault::PresetPersists), &[Touch::Preset], |bench| {
        let before = preset_to(bench, 30_000);
        bench.begin();
        bench.write(PRESET, &[1, 2, 3, 0]).unwrap();
        bench.finish();
        baseline::settle_memory(bench, &[Touch::Preset]);
        assert_eq!((after_a_start(bench, OFFSET), bench.read_number(POSITION)), (before, Ok(30_000)));
    });
}

/// The end of a run does not put back a moved zero point: only a case with the user's permission moves one. The report
/// gives the movement to the step, without a command that reverses it.
#[test]
fn a_zero_point_that_moved_is_told_and_not_put_back() {
    let moved = |bench: &mut Bench<'_>| {
        let before = preset_to(bench, 30_000);
        let dictionary = dictionary::dump(bench);
        bench.write(PRESET, &30_307_u32.to_le_bytes()).unwrap();
        bench.write(STORE, b"save").unwrap();
        bench.begin();
        (before, dictionary)
    };
    on("reference-406", None, &[Touch::Nvm, Touch::Preset], |bench| {
        let (_, dictionary) = moved(bench);
        // `canvass restore` finds the device like this, and has no permission of the user.
        let (before, options) = (bench.changes.baseline.clone(), Options::default());
        let cancel = AtomicBool::new(false);
        let mut annotate = |record: &Record| record.frame.to_string();
        let mut other = Bench::new(&mut *bench.traffic.bus, bench.target, &options, &mut annotate, &cancel);
        other.changes.baseline = before;
        let comparison = baseline::put_back_device(&mut other, "sim:x", false, &dictionary);
        let told: Vec<(i64, bool)> =
            comparison.zero_points.iter().map(|moved| (moved.steps, moved.is_stored)).collect();
        assert_eq!(told, [(307, false), (307, true)]);
        assert!(!comparison.is_as_found() && comparison.commands.is_empty(), "{comparison:?}");
        assert_eq!(other.read_number(POSITION), Ok(30_307), "it was left where it is");
        assert!(other.evidence().frames().all(|exhibit| !exhibit.text.starts_with("614#23036000")));
    });
}

/// Restoring the defaults moves a zero point that a preset has set, so the user must have allowed presets, too.
#[test]
fn defaults_are_not_restored_over_a_zero_point_without_leave() {
    let loses = |allow: &[Touch], position: Option<u32>| {
        on("reference-406", None, &[Touch::Nvm, Touch::Preset], |bench| {
            match position {
                Some(position) => drop(preset_to(bench, position)),
                None => drop(at_work(bench)),
            }
            let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
            let (cancel, baseline) = (AtomicBool::new(false), bench.changes.baseline.clone());
            let mut annotate = |record: &Record| record.frame.to_string();
            let mut other = Bench::new(&mut *bench.traffic.bus, bench.target, &options, &mut annotate, &cancel);
            other.changes.baseline = baseline;
            baseline::would_lose_zero_point(&other)
        })
    };
    assert!(loses(&[Touch::FactoryDefaults], Some(30_000)));
    assert!(!loses(&[Touch::FactoryDefaults, Touch::Preset], Some(30_000)));
    assert!(!loses(&[Touch::FactoryDefaults], None), "it is that of the delivery");
}

/// An encoder that stores each write at once is written only if the user allows writing its memory.
#[test]
fn what_is_stored_at_once_is_written_with_leave_only() {
    const OPERATING_PARAMETERS: Multiplexer = Multiplexer::new(0x6000, 0);
    let written = |allow: &[Touch]| {
        on("tr-c65", None, allow, |bench| {
            let value = bench.read(OPERATING_PARAMETERS).unwrap();
            match bench.download(OPERATING_PARAMETERS, &value) {
                Ok(_) => true,
                Err(Stop::NotApplicable(_)) => false,
                Err(other) => panic!("{other:?}"),
            }
        })
    };
    assert_eq!((written(&[]), written(&[Touch::Preset]), written(&[Touch::Nvm])), (false, false, true));
}

/// The journal says that the memory was written, though no command to store was sent: a restore after the tester was
/// killed writes the memory, too, and names a preset that only power-on shows.
#[test]
fn a_value_that_is_stored_at_once_is_in_the_journal() {
    const TIMER: Multiplexer = Multiplexer::new(0x6200, 0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal");
    let model = Model::by_id("tr-c65").unwrap();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    let node = model.default_node().unwrap();
    bus.attach(Box::new(Device::new(model, Some(node), Firmware::from(Faults::NONE), 0)));
    bus.receive(Timestamp::ZERO + Duration::from_secs(6)).unwrap();
    let (target, cancel) = (Target::of(model, node), AtomicBool::new(false));
    let options = Options { allow: [Touch::Nvm].into(), journal: Some(path.clone()), ..Options::default() };
    let mut annotate = |record: &Record| record.frame.to_string();
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    let dictionary = dictionary::dump(&mut bench);
    interrupted::begin_journal(&mut bench, "sim:x", false, &dictionary).unwrap();
    bench.changes.begin_case("406/cyclic-timer/period", &[Touch::Nvm]).unwrap();
    let read = || Interrupted::read(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert!(!read().stored);
    bench.write(TIMER, &[100, 0]).unwrap();
    let run = read();
    assert!(run.stored);
    let presets: Vec<_> =
        interrupted::unseen_presets(&mut bench, &run).iter().map(|change| change.multiplexer).collect();
    assert_eq!(presets, [PRESET]);
}

/// A device that is not an encoder has no zero point, whatever it answers at 6004h.
#[test]
fn only_an_encoder_has_a_zero_point() {
    on("reference-301", None, &[], |bench| assert_eq!(bench.look_at_zero_point().unwrap(), None));
    on("reference-406", None, &[], |bench| assert!(bench.look_at_zero_point().unwrap().is_some()));
    on("kuebler-c100", None, &[], |bench| assert!(bench.look_at_zero_point().unwrap().is_some(), "that of its angle"));
}
