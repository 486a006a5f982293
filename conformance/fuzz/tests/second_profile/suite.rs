//! A case of the profile.

use super::{INPUTS, NUMBER, OUTPUTS, STUCK, model, node};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_device::{Fault, Faults};
use canvass_macros::case;
use canvass_suite::bench::objects::candidate;
use canvass_suite::bench::{Bench, Candidate, Profile, Registered, Target};
use canvass_suite::catalogue;
use canvass_suite::selftest::judge_target;
use canvass_suite::situation::Situation;
use canvass_suite::verdict::{Judged, Kind};

struct DigitalIo;

inventory::submit! { Registered(&DigitalIo) }

impl Profile for DigitalIo {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn scratch(&self) -> &'static [Candidate] {
        const SCRATCH: [Candidate; 1] = [candidate(OUTPUTS.index.0, OUTPUTS.sub.0, DataType::UNSIGNED8, [1, 2])];
        &SCRATCH
    }

    fn is_parameter(&self, at: Multiplexer) -> bool {
        at == OUTPUTS
    }
}

mod needs {
    use super::INPUTS;
    use canvass_suite::need::Need;

    pub static DIGITAL_INPUTS: Need =
        Need::new("digital-inputs", "digital inputs (6000h)", |bench| bench.has_all(&[INPUTS]));
}

/// Inputs that are wired to outputs show what the outputs were set to, and can't be written.
#[case(id = "401/inputs/wired", clause = "CiA 401", confidence = Unknown, level = Must,
       needs = self::needs[DigitalInputs], catches = [SdoReadOnlyWritable])]
fn wired(bench: &mut Bench<'_>) -> Judged {
    for value in [0x01, 0x02] {
        bench.write(OUTPUTS, &[value])?;
        bench.expect_value(INPUTS, &[value], "an input shows the output that it is wired to")?;
    }
    let attempt = bench.download(INPUTS, &[4])?;
    bench.check(attempt.refused(Situation::ReadOnly))
}

#[test]
fn the_case_passes_on_a_right_device_and_fails_on_a_faulty_one() {
    let case = catalogue::find("401/inputs/wired").unwrap();
    let kind = |name, faults| {
        let model = model(name);
        judge_target(case, model, faults, &Target::of(model, node())).verdict.kind()
    };
    assert_eq!(kind("io", Faults::NONE), Kind::Pass);
    assert_eq!(kind(STUCK, Faults::NONE), Kind::Fail);
    assert_eq!(kind("io", Faults::from(Fault::SdoReadOnlyWritable)), Kind::Fail);
}
