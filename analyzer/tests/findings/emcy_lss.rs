use crate::traffic::machine;
use canvass_analyzer::findings::Severity;

#[test]
fn an_error_and_its_end() {
    let mut traffic = machine();
    traffic.at(15_000, "083#1081110000000000").at(16_500, "083#0000000000000000");
    let finding = traffic.finds("emcy/raised", Some(3), 15_000);
    assert!(finding.message.contains("8110h") && finding.message.contains("lasted 1.5 s"), "{}", finding.message);
    assert_eq!((finding.count, finding.evidence.len()), (1, 2));
}

#[test]
fn an_error_that_stays() {
    let mut traffic = machine();
    traffic.at(15_000, "083#1081110000000000");
    traffic.finds_among(&["emcy/raised", "emcy/never-cleared"], "emcy/never-cleared", Some(3), 15_000);
}

#[test]
fn a_storm() {
    let mut traffic = machine();
    traffic.every(15_000, 16_000, 20, |n| {
        format!("083#{}", if n % 2 == 0 { "1081110000000000" } else { "0000000000000000" })
    });
    traffic.finds_among(&["emcy/raised", "emcy/storm"], "emcy/storm", Some(3), 15_000);
}

#[test]
fn a_code_that_contradicts_its_register() {
    let mut traffic = machine();
    traffic.at(15_000, "083#0042000000000000").at(15_100, "083#0000000000000000");
    traffic.finds_among(&["emcy/raised", "emcy/contradiction"], "emcy/contradiction", Some(3), 15_000);
    // An error register without bit 0, as in the manual of a device.
    let mut documented = machine();
    documented.at(15_000, "083#0042082084030000").at(15_100, "083#0000000000000000").only(&["emcy/raised"]);
}

/// The dialogue of a commissioning, before the machine is started.
fn commissioning(answers: [&str; 3]) -> crate::traffic::Traffic {
    let mut traffic = machine();
    let master = ["11 2A", "13 00 04", "17"];
    traffic.at(600, "7E5#0401000000000000");
    for (n, (request, answer)) in master.iter().zip(answers).enumerate() {
        let pad = |text: &str| format!("{:0<16}", text.replace(' ', ""));
        let at = 610 + 10 * n as u64;
        traffic.at(at, &format!("7E5#{}", pad(request)));
        if !answer.is_empty() {
            traffic.at(at + 3, &format!("7E4#{}", pad(answer)));
        }
    }
    traffic.at(650, "7E5#0400000000000000");
    traffic
}

#[test]
fn a_good_commissioning_is_no_finding() {
    commissioning(["11 00 00", "13 00 00", "17 00 00"]).only(&[]);
}

#[test]
fn lss_without_an_answer_refused_and_not_stored() {
    commissioning(["11 00 00", "13 00 00", ""]).finds_among(
        &["lss/unanswered", "lss/not-stored"],
        "lss/unanswered",
        None,
        630,
    );
    commissioning(["11 01 00", "13 00 00", "17 00 00"]).finds("lss/refused", None, 613);
    commissioning(["11 00 00", "13 00 00", "17 01 00"]).finds("lss/refused", None, 633);
}

/// Two errors, one of which ends: the register tells which one.
#[test]
fn one_of_two_errors_ends() {
    let mut traffic = machine();
    traffic.at(15_000, "083#3081110000000000").at(15_500, "083#0042190000000000").at(16_000, "083#0000090000000000");
    let found = traffic.only(&["emcy/raised", "emcy/never-cleared"]);
    let stays: Vec<_> = found.iter().filter(|finding| finding.rule.id == "emcy/never-cleared").collect();
    assert!(stays.len() == 1 && stays[0].message.contains("4200h"), "{found:?}");
    let ended: Vec<_> = found.iter().filter(|finding| finding.message.contains("it lasted 1 s")).collect();
    assert!(ended.len() == 1 && ended[0].message.contains("8130h"), "{found:?}");
    let results = traffic.results();
    let node = &results.buses[0].1.nodes.iter().find(|(id, _)| id.raw() == 3).unwrap().1;
    let errors: Vec<_> = node.errors.iter().map(|error| (error.code.0, error.ended.is_some())).collect();
    assert_eq!(errors, [(0x8130, true), (0x4200, false)]);
}

/// Devices of TR-Electronic forget the newest error when the error register is read.
#[test]
fn an_error_that_is_acknowledged_by_reading() {
    let mut traffic = machine();
    traffic.at(15_000, "083#0081110000000000");
    traffic.sdo(16_000, 3, "4001100000000000", "4F01100011000000").at(16_010, "083#0000000000000000");
    let finding = traffic.finds("emcy/raised", Some(3), 15_000);
    assert!(finding.message.ends_with("its end was reported as 1001h was read"), "{}", finding.message);
}

/// LMT of a linear encoder: an address of names and serial number, and no answer to being switched.
fn lmt(answers: [&str; 3]) -> crate::traffic::Traffic {
    let mut traffic = machine();
    let switch = ["0154522D454C4543", "024C4D5033300000", "0332200044002100"];
    for (n, request) in switch.iter().enumerate() {
        traffic.at(600 + n as u64, &format!("7E5#{request}"));
    }
    for (n, (request, answer)) in ["112A", "130003", "17"].iter().zip(answers).enumerate() {
        let at = 610 + 10 * n as u64;
        traffic.at(at, &format!("7E5#{request:0<16}"));
        if !answer.is_empty() {
            traffic.at(at + 3, &format!("7E4#{answer:0<16}"));
        }
    }
    traffic.at(650, "7E5#0400000000000000");
    traffic
}

#[test]
fn dialogues_of_lmt() {
    lmt(["110000", "130000", "170000"]).only(&[]);
    lmt(["110000", "130100", "170000"]).finds("lss/refused", None, 623);
    let among = ["lss/unanswered", "lss/not-stored"];
    let finding = lmt(["110000", "130000", ""]).finds_among(&among, "lss/not-stored", None, 613);
    assert!(finding.message.contains("42"), "{}", finding.message);
    lmt(["110000", "130000", ""]).finds_among(&among, "lss/unanswered", None, 630);
}

#[test]
fn dialogues_that_go_wrong() {
    commissioning(["11 00 00", "17 00 00", "17 00 00"]).finds_among(
        &["lss/dialogue", "lss/not-stored"],
        "lss/dialogue",
        None,
        623,
    );
    let mut two = commissioning(["11 00 00", "13 00 00", "17 00 00"]);
    two.at(615, "7E4#1100000000000000");
    let finding = two.finds("lss/dialogue", None, 615);
    assert!(finding.message.starts_with("more than one slave"), "{}", finding.message);
    let mut unasked = machine();
    unasked.at(15_000, "7E4#5E03000000000000").finds("lss/dialogue", None, 15_000);
}

/// Several slaves answer an identification. A master that assigns node-IDs at every start does not store them.
#[test]
fn a_master_that_assigns_node_ids() {
    let mut traffic = machine();
    traffic.at(600, "7E5#5100000000800000").at(603, "7E4#4F00000000000000").micros(603_400, "7E4#4F00000000000000");
    traffic.at(610, "7E5#112A000000000000").at(613, "7E4#1100000000000000").at(620, "7E5#0400000000000000");
    let finding = traffic.finds("lss/not-stored", None, 613);
    assert_eq!(finding.severity, Severity::Info);
}

#[test]
fn layer_settings_stored_again_and_again() {
    let mut traffic = machine();
    traffic.at(5_000, "7E5#0401000000000000");
    for n in 0..12 {
        traffic.at(5_100 + n * 1000, "7E5#1700000000000000").at(5_103 + n * 1000, "7E4#1700000000000000");
    }
    traffic.at(17_000, "7E5#0400000000000000").finds("lss/store-wear", None, 5_103);
}

/// A master sends its requests on the CAN-ID of the slaves.
#[test]
fn lss_requests_on_the_wrong_can_id() {
    let mut traffic = machine();
    traffic.at(2_000, "7E4#0401000000000000").at(2_500, "7E4#0400000000000000");
    let finding = traffic.finds_among(&["lss/dialogue"], "lss/dialogue", None, 2_000);
    assert!(finding.message.contains("on 7E4h, the CAN-ID of the slaves"), "{}", finding.message);
}

/// The requests of a master, one each 10 ms.
fn requests(rows: &[&str]) -> crate::traffic::Traffic {
    let mut traffic = machine();
    for (at, row) in (5_000..).step_by(10).zip(rows) {
        let id = if row.starts_with("4F") || row.starts_with("44") { "7E4" } else { "7E5" };
        traffic.at(at, &format!("{id}#{:0<16}", row.replace(' ', "")));
    }
    traffic
}

/// CiA 305, switch state selective: vendor-ID, product code, revision number and serial number, in this order.
#[test]
fn addresses_come_complete_and_in_order() {
    let leave = "04 00";
    requests(&["40 01", "41 02", "42 03", "43 04", "44", leave]).only(&[]);
    let told = |rows: &[&str], at: u64, text: &str| {
        let among = ["lss/address-series", "lss/unanswered", "lss/dialogue"];
        let finding = requests(rows).finds_among(&among, "lss/address-series", None, at);
        assert!(finding.message.contains(text), "{}", finding.message);
    };
    told(&["40 01", "42 03", "43 04", "44", leave], 5_010, "in the place of 41h");
    told(&["40 01", "41 02", "43 04", "44", leave], 5_020, "in the place of 42h");
    told(&["46 01", "47 02", "48 01", leave], 5_030, "the next request would be 49h");
    told(&["40 01", "41 02", "41 07", "42 03", "43 04", "44", leave], 5_020, "comes twice");
    // The same request again changes nothing.
    requests(&["40 01", "41 02", "41 02", "42 03", "43 04", "44", leave]).only(&[]);
}

#[test]
fn two_slaves_with_one_address() {
    let identify = |high: &str| {
        let last = format!("4B {high}");
        requests(&["46 01", "47 02", "48 01", "49 01", "4A 07", &last, "4F", "4F"])
    };
    identify("07").finds("lss/same-address", None, 5_070);
    // Several slaves may have a number of a range.
    identify("09").only(&[]);
}

#[test]
fn requests_that_no_standard_defines() {
    let severity = |row: &str| requests(&[row]).finds("lss/undefined-request", None, 5_000).severity;
    for row in ["04 02", "51 00 00 00 00 21", "51 00 00 00 00 1F 04", "50", "09"] {
        assert_eq!(severity(row), Severity::Warning, "{row}");
    }
    // A manufacturer may use them.
    assert_eq!((severity("00 64"), severity("99")), (Severity::Info, Severity::Info));
    requests(&["51 00 00 00 00 80", "51 00 00 00 00 1F 03 03"]).only(&[]);
}

#[test]
fn a_bit_rate_is_activated_while_all_slaves_wait() {
    requests(&["04 01", "04 00", "15 64"]).finds("lss/not-in-configuration", None, 5_020);
    requests(&["04 01", "15 64", "04 00"]).only(&[]);
}
