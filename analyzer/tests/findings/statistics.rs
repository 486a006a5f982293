use crate::traffic::{Traffic, diagnose, machine, ms};
use canvass_analyzer::Service;
use canvass_analyzer::statistics::TestCase;
use canvass_analyzer::wire::error_control::State;

#[test]
fn figures_of_a_bus_and_its_nodes() {
    let results = machine().results();
    let (_, bus) = &results.buses[0];
    assert_eq!(bus.total(), machine().records().len() as u64);
    assert_eq!(bus.bit_rate, Some(500_000));
    assert!(bus.mean_load().is_some_and(|load| load > 1.0 && load < 20.0), "{:?}", bus.mean_load());
    let nodes: Vec<u8> = bus.nodes.iter().filter(|(_, node)| node.present).map(|(id, _)| id.raw()).collect();
    assert_eq!(nodes, [1, 3, 4, 6]);
    let (_, encoder) = &bus.nodes[1];
    assert_eq!(encoder.identity.device_type, Some(0x0002_0196));
    assert_eq!(encoder.identity.numbers, [Some(0x13), None, None, Some(0x3039)]);
    assert_eq!(encoder.boot_ups, 1);
    assert!(encoder.responses.quantile(50).is_some_and(|median| median > ms(2) && median < ms(4)));
    let states: Vec<State> = encoder.states.iter().map(|change| change.state).collect();
    assert_eq!(states, [State::PRE_OPERATIONAL, State::OPERATIONAL]);
    let (_, other) = &bus.nodes[2];
    assert_eq!(other.identity.names[0].as_deref(), Some("ENCODER 17"));
    assert_eq!(other.boot_ups, 2);
    assert_eq!(encoder.frames[Service::Emcy as usize], 0);
}

#[test]
fn a_certification_run_is_cut_into_its_cases() {
    let mut traffic = Traffic::default();
    traffic.at(0, "7FF#010307000000").at(10, "703#05").at(20, "703#05").at(30, "7FF#020307000100");
    traffic.at(40, "703#05").at(50, "7FF#010308000000").at(60, "703#05").at(70, "7FF#020308000400");
    let run = diagnose(&traffic.records(), |_| {}).buses.remove(0).1.test_run;
    let told =
        |case: &TestCase| (case.name.to_string(), case.verdict.as_deref().unwrap_or("none").to_owned(), case.frames);
    let cases: Vec<_> = run.cases.iter().map(told).collect();
    let expected = [("case 7 of group 3", "pass", 2), ("case 8 of group 3", "fail", 1)];
    assert_eq!(cases, expected.map(|(name, verdict, frames)| (name.to_owned(), verdict.to_owned(), frames)));
}

#[test]
fn loads_and_peaks_of_nodes_and_services() {
    let results = machine().results();
    let (_, bus) = &results.buses[0];
    let (_, peak) = bus.peak_load().unwrap();
    let mean = bus.mean_load().unwrap();
    assert!(peak > mean && peak < 20.0, "{mean} {peak}");
    let pdo = Service::Pdo as usize;
    let (_, of_pdos) = bus.peaks[pdo].percent(500_000).unwrap();
    assert!(of_pdos > 1.0 && of_pdos <= peak, "{of_pdos}");
    let share: f64 = bus.bits.iter().filter_map(|&bits| bus.share_of_load(bits)).sum();
    assert!((share - mean).abs() < 1e-6);
    let (_, encoder) = &bus.nodes[1];
    let of_node = bus.share_of_load(encoder.bits).unwrap();
    assert!(of_node > 1.0 && of_node < mean && encoder.peak.best().is_some());
    assert!(bus.rate(bus.frames[Service::Sync as usize]).is_some_and(|rate| rate > 45.0 && rate < 50.0));
}

/// If a client repeats a request, the response time counts from the first request.
#[test]
fn response_times_count_from_the_first_request() {
    let mut traffic = Traffic::default();
    traffic.at(900, "703#00").at(1_000, "603#4000100000000000").at(1_300, "603#4000100000000000");
    traffic.at(1_500, "583#4300100096010200");
    let results = traffic.results();
    let (_, node) = &results.buses[0].1.nodes[0];
    let longest = node.responses.max().unwrap();
    assert!((ms(499)..ms(501)).contains(&longest), "{longest}");
    assert_eq!(node.responses.count(), 1);
}

/// A finding that a conformance test provokes is reported with the case that provoked it.
#[test]
fn findings_in_a_certification_run_name_their_case() {
    let mut traffic = Traffic::default();
    traffic.at(0, "703#00").at(100, "7FF#010307000000").at(200, "083#1081110000000000");
    traffic.sdo(300, 3, "4055550000000000", "8055550000000206").at(400, "083#0000000000000000");
    traffic.at(500, "7FF#020307000100").at(600, "7FF#010401000000").at(700, "083#1081110000000000");
    traffic.at(750, "083#0000000000000000").at(800, "7FF#020401000100");
    traffic.at(2_000, "083#2081110000000000").at(2_100, "083#0000000000000000");
    let found = traffic.results().findings;
    let case = |text: &str| {
        let finding = found.iter().find(|finding| finding.message.contains(text)).unwrap();
        (finding.case.as_ref().map(ToString::to_string), finding.message.clone())
    };
    let (of_abort, words) = case("0602 0000h");
    assert!(
        of_abort.as_deref() == Some("case 7 of group 3") && words.ends_with("; in case 7 of group 3 of the test run"),
        "{words}"
    );
    let (of_error, words) = case("8110h");
    assert!(
        of_error.as_deref() == Some("case 7 of group 3")
            && words.ends_with("; first in case 7 of group 3 of the test run, then in 1 other"),
        "{words}"
    );
    let (afterwards, words) = case("8120h");
    assert!(afterwards.is_none() && !words.contains("case"), "{words}");
}
