//! Drives: faults, drives that leave operation by themselves, and drives that are not enabled; several axes; and what
//! correct drives do. EMCY codes by the profile of a node.

use crate::traffic::Traffic;
use canvass_analyzer::findings::{Finding, Results, Severity};

/// Node 1 is a drive (1000h) that sends its statusword in TPDO 1 and takes its controlword from RPDO 1; `axes` of them.
fn drive(axes: u64) -> Traffic {
    let mut traffic = Traffic::default();
    traffic.at(10, "701#00").sdo(20, 1, "4000100000000000", "4300100092010200");
    for (at, mapping, object) in [(30, "001A", 0x41_u8), (90, "0016", 0x40)] {
        traffic.sdo(at, 1, &format!("2F{mapping}0000000000"), &format!("60{mapping}0000000000"));
        for axis in 0..axes {
            let entry = format!("23{mapping}{:02X}1000{object:02X}{:02X}", axis + 1, 0x60 + 8 * axis);
            traffic.sdo(at + 10 * (axis + 1), 1, &entry, &format!("60{mapping}{:02X}00000000", axis + 1));
        }
        traffic.sdo(at + 30, 1, &format!("2F{mapping}00{axes:02X}000000"), &format!("60{mapping}0000000000"));
    }
    traffic.at(150, "000#0101");
    traffic
}

/// Statuswords every 100 ms, each until a time in milliseconds.
fn shows(traffic: &mut Traffic, phases: &[(u64, &str)]) {
    let mut from = 200;
    for (to, word) in phases {
        traffic.every(from, *to, 100, |_| format!("181#{word}"));
        from = *to;
    }
}

fn of<'a>(results: &'a Results, rule: &str) -> Vec<&'a Finding> {
    results.findings.iter().filter(|finding| finding.rule.id == rule).collect()
}

#[track_caller]
fn head(results: &Results) -> &Finding {
    &results.findings[results.stories[0].head[0]]
}

#[test]
fn a_fault_is_the_main_event() {
    let mut traffic = drive(1);
    shows(&mut traffic, &[(2_200, "3702"), (4_200, "1802")]);
    let results = traffic.results();
    assert_eq!((head(&results).rule.id, head(&results).severity), ("drive/fault", Severity::Error));
    assert_eq!(
        head(&results).message,
        "from operation enabled to fault, for 1.9 s, and still at the end of the capture; no reset was tried"
    );
    assert_eq!(results.stories.len(), 1);
    let texts: Vec<&str> = head(&results).evidence.iter().map(|exhibit| exhibit.text.as_str()).collect();
    assert!(
        texts[0].ends_with("6041h:00 Statusword = 0237h (567) (operation enabled, voltage enabled, remote)"),
        "{texts:?}"
    );
    assert!(texts[1].ends_with("6041h:00 Statusword = 0218h (536) (fault, voltage enabled, remote)"), "{texts:?}");
}

#[test]
fn a_fault_that_is_reset() {
    let mut traffic = drive(1);
    shows(&mut traffic, &[(2_000, "3702"), (3_000, "1802"), (3_500, "5002"), (6_000, "3702")]);
    traffic.at(190, "201#0F00").at(2_500, "201#0000").at(2_700, "201#8000").at(3_100, "201#0600").at(3_300, "201#0F00");
    let results = traffic.results();
    let [found] = of(&results, "drive/fault")[..] else { panic!("{:#?}", results.findings) };
    assert!(found.message.ends_with(", then switch on disabled; a reset was tried once"), "{}", found.message);
    assert_eq!(results.findings.len(), 1, "{:#?}", results.findings);
}

/// A bit that stays set is one reset; a reset without effect leaves the fault.
#[test]
fn a_reset_without_effect() {
    let mut traffic = drive(1);
    shows(&mut traffic, &[(1_000, "3702"), (4_000, "1802")]);
    for (at, word) in [(1_500, "8000"), (1_600, "8000"), (1_700, "0000"), (2_000, "8000")] {
        traffic.at(at, &format!("201#{word}"));
    }
    let results = traffic.results();
    let found = of(&results, "drive/fault");
    assert!(found[0].message.ends_with("still at the end of the capture; a reset was tried 2 times"), "{found:#?}");
}

#[test]
fn an_emcy_tells_the_cause_of_a_fault() {
    let mut traffic = drive(1);
    shows(&mut traffic, &[(2_000, "3702"), (4_000, "1802")]);
    traffic.at(1_990, "081#2171210000000000");
    let results = traffic.results();
    assert_eq!(results.stories.len(), 1, "{:#?}", results.findings);
    assert_eq!(head(&results).rule.id, "emcy/raised");
    assert!(head(&results).message.starts_with("EMCY 7121h motor blocked, register 21h"), "{}", head(&results).message);
    assert_eq!(of(&results, "drive/fault").len(), 1);
}

#[test]
fn each_axis_is_told_apart() {
    let mut traffic = drive(2);
    shows(&mut traffic, &[(2_000, "37023702"), (4_000, "37021802")]);
    let results = traffic.results();
    let found = of(&results, "drive/fault");
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].message.starts_with("axis 2: from operation enabled to fault"), "{}", found[0].message);
    let mut both = drive(2);
    shows(&mut both, &[(2_000, "37023702"), (4_000, "18021802")]);
    let results = both.results();
    assert_eq!((of(&results, "drive/fault").len(), results.stories.len()), (2, 1));
}

#[test]
fn a_drive_that_is_switched_off_by_itself() {
    let mut traffic = drive(1);
    shows(&mut traffic, &[(2_000, "3702"), (4_000, "5002")]);
    traffic.every(190, 4_000, 100, |_| "201#0F00".to_owned());
    let results = traffic.results();
    assert_eq!((head(&results).rule.id, head(&results).severity), ("drive/left-operation", Severity::Error));
    assert_eq!(
        head(&results).message,
        "from operation enabled to switch on disabled, although the controlword 000Fh enables operation"
    );
    let mut unseen = drive(1);
    shows(&mut unseen, &[(2_000, "3702"), (4_000, "5002")]);
    assert_eq!(unseen.finds("drive/left-operation", Some(1), 2_000).severity, Severity::Info);
}

/// A drive is enabled step by step, moves, and is switched off by its controller or by NMT.
#[test]
fn a_drive_that_obeys() {
    let mut traffic = drive(1);
    shows(
        &mut traffic,
        &[(400, "5002"), (600, "3102"), (800, "3302"), (5_000, "3706"), (5_500, "3102"), (6_000, "5002")],
    );
    for (at, word) in [(350, "0600"), (550, "0700"), (750, "0F00"), (1_000, "1F00"), (4_950, "0600"), (5_450, "0000")] {
        traffic.at(at, &format!("201#{word}"));
    }
    traffic.only(&[]);
    let mut stopped = drive(1);
    shows(&mut stopped, &[(2_000, "3702"), (2_100, "5002")]);
    stopped.at(190, "201#0F00").at(1_980, "000#8001").only(&[]);
}

/// The controlword may be in an RPDO whose mapping the capture does not show; or the command was short.
#[test]
fn a_command_that_is_not_seen() {
    let mut hidden = drive(1);
    hidden.remove(|ms, _| (90..150).contains(&ms)).sdo(160, 1, "2B4060000F000000", "6040600000000000");
    shows(&mut hidden, &[(2_000, "3702"), (6_000, "5002")]);
    hidden.at(1_990, "201#0000");
    assert_eq!(hidden.finds("drive/left-operation", Some(1), 2_000).severity, Severity::Info);
    let mut short = drive(1);
    shows(&mut short, &[(2_000, "3702"), (3_000, "3102"), (6_000, "3702")]);
    short.at(190, "201#0F00").at(1_900, "201#0600").at(1_950, "201#0F00").only(&[]);
    let mut local = drive(1);
    shows(&mut local, &[(2_000, "3702"), (6_000, "5000")]);
    local.at(190, "201#0F00");
    let found = local.only(&["drive/left-operation", "drive/not-enabled"]);
    assert!(found.iter().all(|found| found.severity != Severity::Error), "{found:#?}");
}

#[test]
fn a_drive_that_is_not_enabled() {
    let mut traffic = drive(1);
    shows(&mut traffic, &[(6_000, "3102")]);
    traffic.at(350, "201#0700").at(550, "201#0F00");
    let found = traffic.finds("drive/not-enabled", Some(1), 550);
    assert!(found.message.starts_with("still ready to switch on 3.0"), "{}", found.message);
    // A drive may take its time.
    let mut slow = drive(1);
    shows(&mut slow, &[(2_500, "3102"), (6_000, "3702")]);
    slow.at(350, "201#0700").at(550, "201#0F00").only(&[]);
}

/// The same statusword of a node with another profile is no drive's.
#[test]
fn another_profile_is_no_drive() {
    let mut traffic = drive(1);
    traffic.silence(0x581, 20, 25).at(23, "581#4300100091010200");
    shows(&mut traffic, &[(2_200, "3702"), (4_200, "1802")]);
    traffic.only(&[]);
}

#[test]
fn error_codes_by_profile() {
    let text = |profile: &str, emcy: &str| {
        let mut traffic = Traffic::default();
        traffic.sdo(0, 1, "4000100000000000", &format!("43001000{profile}0000"));
        traffic.at(1_000, &format!("081#{emcy}")).at(2_000, "081#0000000000000000");
        traffic.finds("emcy/raised", Some(1), 1_000).message
    };
    assert!(text("9201", "2171210200000000").starts_with("EMCY 7121h motor blocked, register 21h"));
    assert!(text("9201", "2073210000000000").starts_with("EMCY 7320h position sensor"));
    assert!(text("9201", "1186210000000000").starts_with("EMCY 8611h following error"));
    assert!(text("9101", "2023030000000000").starts_with("EMCY 2320h short circuit at outputs"));
    assert!(text("9A01", "2050010000000000").starts_with("EMCY 5020h sensor error, Y axis"));
    assert!(text("9601", "2171210200000000").starts_with("EMCY 7121h additional modules"));
    assert!(text("9201", "3081110000000000").starts_with("EMCY 8130h life guard error or heartbeat error"));
}
