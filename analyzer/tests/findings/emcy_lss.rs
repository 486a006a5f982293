use crate::traffic::machine;

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
    // Without bit 0, as in the manual of a device.
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
    commissioning(["11 00 00", "13 00 00", "17 01 00"]).finds_among(
        &["lss/refused", "lss/not-stored"],
        "lss/not-stored",
        None,
        613,
    );
}
