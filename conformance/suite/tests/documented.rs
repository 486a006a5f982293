//! Every case on every model: a case fails only for a documented deviation, and the reference devices pass strictly.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::NodeId;
use canvass_bus::SimulatedBus;
use canvass_device::Faults;
use canvass_device::models::{Deviation as Documented, Model};
use canvass_device::{Device, Motion};
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::runner::run_case;
use canvass_suite::touch::Touch;
use canvass_suite::verdict::{Kind, Ruled};
use canvass_suite::{catalogue, glob};
use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;

fn check(id: &str, executed_at_least: usize) {
    let model = Model::by_id(id).unwrap();
    let deviations = model.deviations();
    // A model without node-ID as delivered gets one.
    let node = model.default_node().or_else(|| NodeId::new(63));
    let target = Target::of(model, node.unwrap());
    let options = Options { allow: Touch::ALL.into_iter().collect(), ..Options::default() };
    let cancel = AtomicBool::new(false);
    let (mut wrong, mut executed, mut used) = (Vec::new(), 0, BTreeSet::new());
    for case in catalogue::cases() {
        let mut bus = SimulatedBus::new(model.default_bit_rate());
        // 30 revolutions per minute if the case needs a turning shaft.
        let turns = case.needs_motion();
        let motion = Motion::constant(0x4CBA, if turns { 30_000 } else { 0 });
        bus.attach(Box::new(Device::with_motion(model, node, Faults::NONE, 0, &motion)));
        let mut annotate = |_: &canvass_traces::Record| String::new();
        let report = run_case(&mut Bench::new(&mut bus, &target, &options, &mut annotate, &cancel), case);
        let kind = report.verdict.kind();
        executed += usize::from(kind.is_executed());
        if kind == Kind::Deviation {
            let explains = |deviation: &Documented| {
                let explained = |ruled: &Ruled| {
                    deviation.subject.covers(ruled.breach.subject) && deviation.does.accepts(&ruled.breach.actual)
                };
                glob::matches(&deviation.case, case.id) && report.verdict.breaches().iter().any(explained)
            };
            used.extend(
                (0..).zip(deviations).filter(|(_, deviation)| explains(deviation)).map(|(at, _): (usize, _)| at),
            );
        }
        let not_restored = report.notes.iter().any(|note| note.contains("restored") || note.contains("set back"));
        if matches!(kind, Kind::Fail | Kind::Error | Kind::Inconclusive) || not_restored {
            wrong.push(format!("{}: {kind}: {:?} {:?}", case.id, report.verdict.reason(), report.notes));
        }
    }
    assert!(wrong.is_empty(), "{id}: {}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(executed >= executed_at_least, "{id}: {executed} cases were executed");
    let idle = (0..).zip(deviations).filter(|(at, _)| !used.contains(at));
    let idle: Vec<String> = idle.map(|(_, row)| format!("{} {}: {}", row.case, row.subject, row.does)).collect();
    assert!(idle.is_empty(), "{id}: explained, but not found: {idle:?}");
}

/// Minimum number of cases that a model executes.
fn executed_at_least(id: &str) -> usize {
    match id {
        "kuebler-sendix-58x8" | "kuebler-sendix-f58" => 140,
        "kuebler-sendix-m58" | "kuebler-sendix-f58m" | "reference-406" => 120,
        "reference-301" => 90,
        "kuebler-c100" | "kuebler-d125" => 70,
        _ => 50,
    }
}

macro_rules! documented {
    ($($name:ident = $id:literal,)*) => {
        $(
            #[test]
            fn $name() {
                check($id, executed_at_least($id));
            }
        )*
    };
}

canvass_device::each_model!(documented);
