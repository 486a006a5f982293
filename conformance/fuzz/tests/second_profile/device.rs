//! The application of the profile's device. The inputs are wired to the outputs and show their values. If all outputs
//! are on, the current is too high.

use super::{INPUTS, NUMBER, OUTPUTS, OVERLOAD, STUCK, model, node};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{
    Application, ApplicationError, ApplicationErrors, Device, Faults, Firmware, Motion, Profile, Registered,
    Surroundings,
};
use canvass_traces::{Direction, Duration, Timestamp, parse_frame};

struct DigitalIo;

inventory::submit! { Registered(&DigitalIo) }

impl Profile for DigitalIo {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn application(&self, model: &Model, _: &Motion, _: &Firmware) -> Option<Box<dyn Application>> {
        let is_own = model.description().device_profile() == Some(NUMBER);
        is_own.then(|| -> Box<dyn Application> { Box::new(Outputs { stuck: model.id() == STUCK }) })
    }
}

#[derive(Clone, Debug)]
struct Outputs {
    stuck: bool,
}

fn outputs(device: &Surroundings<'_>) -> u64 {
    device.parameters.number_or_zero(OUTPUTS.index.0, OUTPUTS.sub.0)
}

impl Application for Outputs {
    fn boxed_clone(&self) -> Box<dyn Application> {
        Box::new(self.clone())
    }

    fn value(&self, _: Timestamp, at: Multiplexer, device: &Surroundings<'_>) -> Option<u64> {
        (at == INPUTS).then(|| if self.stuck { 0 } else { outputs(device) })
    }

    fn errors(&self, _: Timestamp, device: &Surroundings<'_>) -> ApplicationErrors {
        let code = EmcyCode(OVERLOAD);
        let overload = ApplicationError { number: 0, code, register: 0, manufacturer: [0; 5], behaviour: None };
        [Some((overload, outputs(device) == 0xFF)), None, None, None]
    }
}

/// The frames that the device sends within a second after power-on and after each request.
fn answers(requests: &[&str]) -> Vec<String> {
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(Device::new(model("io"), Some(node()), Faults::NONE, 0)));
    let mut sent = Vec::new();
    for request in [None].into_iter().chain(requests.iter().map(Some)) {
        if let Some(request) = request {
            bus.send(&parse_frame(request).unwrap().frame).unwrap();
        }
        let deadline = bus.now() + Duration::from_secs(1);
        while let Some(record) = bus.receive(deadline).unwrap() {
            if record.direction == Direction::Rx {
                sent.push(record.frame.to_string());
            }
        }
    }
    sent
}

#[test]
fn inputs_follow_outputs_and_errors_are_reported() {
    const START: &str = "000#0109";
    const PRE_OPERATIONAL: &str = "000#8009";
    const READ_INPUTS: &str = "609#4000600100000000";
    // An RPDO sets the outputs. The inputs are read by SDO, and a TPDO sends them at each start.
    let sent = answers(&[START, "209#05", READ_INPUTS, PRE_OPERATIONAL, START, "209#FF", "209#00"]);
    let expected =
        ["709#00", "189#00", "589#4F00600105000000", "189#05", "089#2023030000000000", "089#0000000000000000"];
    assert_eq!(sent, expected);
}
