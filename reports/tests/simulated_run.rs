//! A whole run on the simulated bus, shown in every report.

// `cfg(test)` has no effect here, but clippy uses it to recognise where a test may unwrap.
#![cfg(test)]

use canvass_bus::{Bus, SimulatedBus};
use canvass_device::Device;
use canvass_device::Fault;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_reports::conformance::{Reporter, RunReport};
use canvass_reports::document::{Form, Style};
use canvass_suite::bench::{Bench, Decoder, Options, Target};
use canvass_suite::catalogue;
use canvass_suite::runner::{Plan, Summary, run};
use canvass_suite::verdict::{Authority, Deviation, Kind};
use std::sync::atomic::AtomicBool;

const MODEL: &str = "kuebler-sendix-58x8";

fn run_with(faults: Faults, reporters: &mut [&mut dyn Reporter]) -> Summary {
    let model = Model::by_id(MODEL).unwrap();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(Box::new(Device::new(model, model.default_node(), faults, 0)));
    let bit_rate = bus.bit_rate();
    let target = Target {
        node: model.default_node().unwrap(),
        model: MODEL.to_owned(),
        description: Some(model.description().clone()),
        manual: model.device().manual.clone(),
        deviations: vec![Deviation {
            cases: vec!["301/identity/names".to_owned()],
            subject: Some("1008".parse().unwrap()),
            situation: None,
            does: "value *".parse().unwrap(),
            documented: "the manual says so".to_owned(),
            by: Authority::Manual,
        }],
        quarantines: Vec::new(),
        described_alone: false,
    };
    let (options, cancel) = (Options::default(), AtomicBool::new(false));
    let mut decoder = Decoder::new(&target);
    let mut bench = Bench::new(&mut bus, &target, &options, &mut decoder, &cancel);
    let plan = Plan { cases: &catalogue::cases(), bus: "sim:kuebler-sendix-58x8", bit_rate, seed: 0, shuffle: None };
    run(&mut bench, &plan, &mut |event| reporters.iter_mut().for_each(|reporter| reporter.event(event).unwrap()))
        .unwrap()
}

#[test]
fn two_runs_give_the_same_bytes() {
    let document = || {
        let mut out = Vec::new();
        run_with(Faults::NONE, &mut [&mut RunReport::new(&mut out, Form::Json)]);
        out
    };
    let first = document();
    assert!(first.len() > 10_000);
    assert_eq!(first, document());
}

#[test]
fn every_report_of_a_faulty_device() {
    let faults: Faults =
        [Fault::SdoStaleMultiplexer, Fault::HeartbeatPeriodDoubled, Fault::DeviceNameWithGarbage].into_iter().collect();
    let [mut page, mut xml, mut text, mut lines] = [const { Vec::new() }; 4];
    let summary = run_with(
        faults,
        &mut [
            &mut RunReport::new(&mut page, Form::Html),
            &mut RunReport::new(&mut xml, Form::Junit),
            &mut RunReport::new(&mut text, Form::Markdown),
            &mut RunReport::new(&mut lines, Form::Text(Style::default())),
        ],
    );
    // The fault of a stale multiplexer shows in every case that provokes an abort.
    let failures = summary.count(Kind::Fail);
    assert!(failures >= 2 && summary.count(Kind::Deviation) == 1, "{summary:?}");
    // The files are kept for inspection.
    let directory = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (name, bytes) in [("run.html", &page), ("run.xml", &xml), ("run.md", &text), ("run.txt", &lines)] {
        std::fs::write(directory.join(name), bytes).unwrap();
    }
    let lines = String::from_utf8(lines).unwrap();
    assert!(lines.contains("✗ fail  301/sdo/abort/multiplexer"), "{lines}");
    assert!(lines.contains("documented  the manual says so"), "{lines}");
    assert!(String::from_utf8(text).unwrap().contains(&format!("| ✗ fail | {failures} |")));
    let xml = String::from_utf8(xml).unwrap();
    assert_eq!(xml.matches("<failure ").count(), failures);
}
