//! Replays the dialogues that the manuals print (`tests/manuals/kuebler-replay.toml`) with the models.

use crate::rig::Rig;
use canvass_device::Faults;
use canvass_device::Motion;
use canvass_device::models::Model;
use serde::Deserialize;

#[derive(Deserialize)]
struct Examples {
    example: Vec<Example>,
}

#[derive(Deserialize)]
struct Example {
    manual: String,
    section: String,
    models: Vec<String>,
    #[serde(default = "sendix")]
    node: u8,
    #[serde(default = "rest")]
    rest: i64,
    #[serde(default = "sendix_bit_rate")]
    bit_rate: u32,
    erratum: Option<String>,
    frames: Vec<String>,
}

fn sendix() -> u8 {
    63
}

fn sendix_bit_rate() -> u32 {
    250_000
}

fn rest() -> i64 {
    0x4CBA
}

/// The first wrong answer of a model in an example, as text; `None` if all answers are right.
fn complaint(example: &Example, model: &str) -> Option<String> {
    let model = Model::by_id(model).unwrap();
    let node = (example.node > 0).then_some(example.node);
    let mut rig = Rig::powered_at(example.bit_rate, model, node, Faults::NONE, &Motion::still(example.rest));
    rig.run(300);
    let mut steps = example.frames.iter().peekable();
    while let Some(step) = steps.next() {
        let heard = match step.strip_prefix('+') {
            Some(millis) => rig.run(millis.parse().unwrap()),
            None => {
                rig.send(step.strip_prefix("> ").unwrap());
                // Frames after a pause are received during the pause, not here.
                let waits = steps.peek().is_some_and(|next| next.starts_with('+'));
                if waits { Vec::new() } else { rig.ask_nothing() }
            }
        };
        let mut expected = Vec::new();
        while let Some(frame) = steps.next_if(|next| next.starts_with('<')) {
            expected.push(frame[2..].to_owned());
        }
        if heard != expected {
            return Some(format!(
                "{} {} {}: {step}: {expected:?}, found {heard:?}",
                example.manual,
                example.section,
                model.id()
            ));
        }
    }
    None
}

#[test]
fn the_manuals_dialogues() {
    let examples: Examples = toml::from_str(include_str!("../manuals/kuebler-replay.toml")).unwrap();
    let pairs = examples.example.iter().flat_map(|example| example.models.iter().map(move |model| (example, model)));
    let complaints: Vec<String> = pairs.filter_map(|(example, model)| complaint(example, model)).collect();
    assert!(complaints.is_empty(), "{}:\n{}", complaints.len(), complaints.join("\n"));
    assert!(examples.example.iter().all(|example| example.erratum.as_deref() != Some("")));
}

/// Section 5.7.7: 6200h makes the encoder send its position every 10 ms, counter-clockwise.
#[test]
fn the_trace_goes_on_in_operational() {
    let mut rig = Rig::powered(crate::rig::model(), Some(63), Faults::NONE, &Motion::still(-0x4CBA));
    rig.run(300);
    rig.dialogue(&[("2B0062000A000000", "6000620000000000"), ("2B00600001000000", "6000600000000000")]);
    rig.send("000#013F");
    let frames: Vec<String> = rig.run(35).into_iter().filter(|frame| frame.starts_with("1BF")).collect();
    assert_eq!(frames, ["1BF#BA4C0000"; 4]);
    rig.send("000#803F");
    rig.run(5);
    assert_eq!(rig.run(100), Vec::<String>::new());
}
