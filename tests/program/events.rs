//! `canvass decode --events` as a user runs it.

use crate::running::{run, run_with_input};
use serde_json::{Value, json};

const COMMISSIONING: &str = "docs/examples/commissioning.log";

fn events(args: &[&str], input: &str) -> Vec<Value> {
    let args: Vec<&str> = ["decode", "-", "--events", "--format", "json"].iter().chain(args).copied().collect();
    let ended = run_with_input(&args, input);
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    ended.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn what_happened_in_words() {
    let ended = run(&["decode", COMMISSIONING, "--events", "--device", "63=kuebler-sendix-58x8", "--time", "relative"]);
    let words = [
        "0.102100  can0       lss      <- LSS node-ID 63, after 1.1 ms",
        "0.121000  can0   63  state    pre-operational -> initialisation, as commanded",
        "0.400000  can0    5  node-id  node 63 has become node 5, as set by layer setting",
        "0.503000  can0    5  sdo      read 1008h:00 Manufacturer device name = \"Kuebler\": segmented, 7 bytes in 1 segment, 3 ms",
        "0.511000  can0    5  sdo      read 5000h:00: expedited, 1 ms, aborted by server: 0602 0000h object does not exist",
        "0.521000  can0    5  mapping  TPDO 2: no mapping",
        "0.529000  can0    5  mapping  TPDO 2: 6030h:01 (16 bits), 6004h:00 (32 bits)",
        "0.531000  can0    5  cob-id   TPDO 2: 285h -> 1C5h, by SDO traffic",
        "0.570000  can0    5  emcy     raised: 4310h temperature",
        "0.600000  can0    5  emcy     gone: 0000h",
        "0.613000  can0    5  sdo      read 1008h:00 Manufacturer device name = \"Kuebler\": segmented, 7 bytes in 1 segment, 3 ms [violation: toggle bit not alternated]",
        "0.620000  can0    5  sdo      read 1000h:00 Device type: expedited, 0 ns, open at the end of the capture",
    ];
    let mut lines = ended.stdout.lines();
    for said in words {
        assert!(lines.any(|line| line.starts_with(said)), "not said, or too late: {said}\n{}", ended.stdout);
    }
}

#[test]
fn a_request_instead_of_the_next_segment_leaves_the_transfer() {
    let events = events(
        &[],
        "\
(1.000000) can0 601#4008100000000000
(1.001000) can0 581#4108100064000000
(1.500000) can0 601#4000100000000000
(1.501000) can0 581#4300100096010200
(1.600000) can0 601#4008100000000000
(1.700000) can0 701#00
",
    );
    let outcomes: Vec<_> = events
        .iter()
        .filter(|event| event["event"] == "sdo")
        .map(|event| (&event["index"], &event["outcome"]))
        .collect();
    let expected =
        [(json!(0x1008), json!("superseded")), (json!(0x1000), json!("complete")), (json!(0x1008), json!("reset"))];
    assert_eq!(outcomes, expected.iter().map(|row| (&row.0, &row.1)).collect::<Vec<_>>());
    assert_eq!(events[0]["duration_ns"], 1_000_000);
}

#[test]
fn one_command_to_all_changes_the_state_of_each() {
    let frames = "(1.000000) can0 701#05\n(1.100000) can0 702#7F\n(2.000000) can0 000#0100\n";
    let all = events(&[], frames);
    let changes: Vec<_> = all.iter().map(|event| (&event["node"], &event["from"], &event["to"])).collect();
    let (null, operational, pre) = (Value::Null, json!("operational"), json!("pre-operational"));
    let expected = [(&json!(1), &null, &operational), (&json!(2), &null, &pre), (&json!(2), &pre, &operational)];
    assert_eq!(changes, expected, "node 1 was operational already");
    assert_eq!(events(&["--node", "2"], frames).len(), 2);
    assert_eq!(events(&["--filter", "service=nmt"], frames).len(), 1);
}

#[test]
fn bit_rates_follow_layer_setting() {
    let frames = "\
(1.000000) can0 7E5#0401000000000000
(1.100000) can0 7E5#1300030000000000
(1.101000) can0 7E4#1300000000000000
(1.200000) can0 7E5#15E8030000000000
(1.300000) can0 7E5#5E00000000000000
(1.400000) can0 7E5#5E00000000000000
";
    let events = events(&[], frames);
    let rate = events.iter().find(|event| event["event"] == "bit-rate").unwrap();
    assert_eq!((&rate["bit_rate"], &rate["delay_ns"]), (&json!(250_000), &json!(1_000_000_000_u64)));
    let unanswered: Vec<_> = events.iter().map(|event| event["previous_unanswered"] == true).collect();
    assert_eq!(unanswered, [false, false, false, false, false, false, true]);
}

#[test]
fn cob_ids_come_back_with_the_boot_up() {
    let frames = "\
(1.000000) can0 605#2301180110010040
(1.001000) can0 585#6001180100000000
(2.000000) can0 705#00
";
    let moves: Vec<_> = events(&[], frames).into_iter().filter(|event| event["event"] == "cob-id").collect();
    assert_eq!(
        (&moves[0]["from"], &moves[0]["to"], &moves[0]["source"]),
        (&json!(0x285), &json!(0x110), &json!("trace"))
    );
    assert_eq!((&moves[1]["from"], &moves[1]["to"]), (&json!(0x110), &json!(0x285)));
    assert_eq!((moves.len(), &moves[1]["source"]), (2, &json!("predefined")));
}

#[test]
fn events_are_no_rows() {
    let ended = run(&["decode", COMMISSIONING, "--events", "--format", "csv"]);
    assert_eq!(ended.status, 2);
    assert!(ended.stderr.contains("text and json"), "{}", ended.stderr);
}

/// The identity in the trace is sufficient: from there on, names, units and PDOs of the built-in model are known.
#[test]
fn a_built_in_model_is_recognised() {
    let log = "\
(1.000) can0 63F#4000100000000000
(1.001) can0 5BF#4300100096010200
(1.002) can0 63F#4018100100000000
(1.003) can0 5BF#4318100113000000
(1.004) can0 63F#4018100200000000
(1.005) can0 5BF#4318100201206858
(1.006) can0 63F#4050210000000000
(1.007) can0 5BF#4B50210003010000
";
    let events = events(&[], log);
    let device = events.iter().find(|event| event["event"] == "device").unwrap();
    assert_eq!((&device["node"], &device["model"]), (&json!(63), &json!("kuebler-sendix-58x8")));
    assert_eq!(device["by"][0], json!({"index": 0x1000, "sub": 0}));
    let text = run_with_input(&["decode", "-"], log).stdout;
    assert!(text.lines().last().unwrap().ends_with("25.9 °C"), "{text}");
    let words = run_with_input(&["decode", "--events", "-"], log).stdout;
    assert!(
        words.contains("63  device   recognised as kuebler-sendix-58x8 by 1000h:00, 1018h:01, 1018h:02"),
        "{words}"
    );
}
