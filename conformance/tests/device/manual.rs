//! The dialogues that Kübler manual R67070.0002-07 prints, byte by byte (with its errata as the model's sheet lists them).

use crate::rig::Rig;

/// 5.3.7.4, 5.5.7, 5.5.8, 5.5.27.
#[test]
fn access_examples() {
    Rig::new().dialogue(&[
        ("2B00600001000000", "6000600000000000"),
        ("4000600000000000", "4B00600001000000"),
        ("2310100173617665", "6010100100000000"),
        ("231110016C6F6164", "6011100100000000"),
        ("2B00600005500000", "6000600000000000"),
    ]);
}

/// 5.7.1. The responses to 1802h echo the request; 2105h is sub-index 00.
#[test]
fn basic_parameterizing() {
    Rig::new().dialogue(&[
        ("2310100173617665", "6010100100000000"),
        ("231110016C6F6164", "6011100100000000"),
        ("2F021802FF000000", "6002180200000000"),
        ("2B021805F4010000", "6002180500000000"),
        ("2F00210005000000", "6000210000000000"),
        ("2F0121003F000000", "6001210000000000"),
        ("2F02210000000000", "6002210000000000"),
        ("2305210073617665", "6005210000000000"),
        ("2B00600001000000", "6000600000000000"),
        ("2301600000100000", "6001600000000000"),
        ("2302600000000100", "6002600000000000"),
        ("2303600000000000", "6003600000000000"),
        ("2B0062000A000000", "6000620000000000"),
    ]);
}

/// 5.7.4: the mapping is opened, written and closed while the PDO is invalid (step 1 of the manual's procedure).
#[test]
fn mapping() {
    let mut rig = Rig::new();
    rig.dialogue(&[("23021801BF030080", "6002180100000000")]);
    let procedure = [
        ("2F021A0000000000", "60021A0000000000"),
        ("23021A0120000460", "60021A0100000000"),
        ("23021A0210013060", "60021A0200000000"),
        ("23021A0310014060", "60021A0300000000"),
        ("2F021A0003000000", "60021A0000000000"),
    ];
    rig.dialogue(&procedure);
    // The manual's first line writes 3 entries before it opens them: what was mapped before stays so.
    rig.dialogue(&[("2F021A0003000000", "60021A0000000000")]);
    rig.dialogue(&procedure);
    rig.dialogue(&[("23021801BF030000", "6002180100000000"), ("2B02180514000000", "6002180500000000")]);
    assert!(rig.ask("000#013F").contains(&"3BF#BA4C000000000000".to_owned()));
}

/// 5.7.5, with node 11 and node 8 as the manual has them.
#[test]
fn cob_ids() {
    for (node, request, response, pairs) in [
        (11, "60B", "58B", &["230018018B010080", "230018010B040080", "230018010B040000"][..]),
        (8, "608", "588", &["2301180188030080", "2301180188020080"][..]),
    ] {
        let mut rig = Rig::powered(crate::rig::model(), Some(node), Default::default(), Default::default());
        rig.run(300);
        for pair in pairs {
            let confirmed = format!("{response}#60{}00000000", &pair[2..8]);
            assert_eq!(rig.ask(&format!("{request}#{pair}")), [confirmed]);
        }
    }
}

/// 5.7.7: the whole trace, with its power cycle as a reset node.
#[test]
fn trace() {
    // The manual's device counts counter-clockwise and shows 4CBAh.
    let motion = canvass_conformance::device::Motion::still(-0x4CBA);
    let mut rig = Rig::powered(crate::rig::model(), Some(63), Default::default(), motion);
    assert_eq!(rig.run(300), ["73F#00"]);
    rig.dialogue(&[("231110016C6F6164", "6011100100000000")]);
    rig.send("000#813F");
    assert_eq!(rig.run(300), ["73F#00"]);
    rig.dialogue(&[
        ("2F00210005000000", "6000210000000000"),
        ("2F0121003F000000", "6001210000000000"),
        ("2F02210000000000", "6002210000000000"),
        ("2305210073617665", "6005210000000000"),
    ]);
    rig.send("000#813F");
    assert_eq!(rig.run(300), ["73F#00"]);
    rig.dialogue(&[
        ("2B0062000A000000", "6000620000000000"),
        ("2B00600001000000", "6000600000000000"),
        ("2310100173617665", "6010100100000000"),
    ]);
    rig.send("000#013F");
    let frames: Vec<String> = rig.run(35).into_iter().filter(|frame| frame.starts_with("1BF")).collect();
    assert_eq!(frames, ["1BF#BA4C0000"; 4]);
    rig.send("000#803F");
    rig.run(5);
    assert_eq!(rig.run(100), Vec::<String>::new());
}

/// 5.7.6. "Inquire node-ID" answers the node-ID, as CiA 305 says; the manual prints zeros.
#[test]
fn lss() {
    let mut rig = Rig::new();
    let none: [&str; 0] = [];
    assert_eq!(rig.ask("7E5#0401000000000000"), none);
    assert_eq!(rig.ask("7E5#5E00000000000000"), ["7E4#5E3F000000000000"]);
    assert_eq!(rig.ask("7E5#112A000000000000"), ["7E4#1100000000000000"]);
    assert_eq!(rig.ask("7E5#1300040000000000"), ["7E4#1300000000000000"]);
    assert_eq!(rig.ask("7E5#1700000000000000"), ["7E4#1700000000000000"]);
    assert_eq!(rig.ask("7E5#0400040000000000"), none);
    assert_eq!(rig.run(300), ["72A#00"], "restarts by itself with its new node-ID");
}

/// 5.8.2: the temperature is above its limit.
#[test]
fn emergency() {
    let mut rig = Rig::new();
    assert_eq!(rig.ask("63F#2F20210350000000"), ["0BF#004209805620502E", "5BF#6020210300000000"]);
    assert_eq!(rig.read(0x1001, 0), Ok(9));
}

/// 5.8.4 shows the abort of an object that this device does not have.
#[test]
fn abort() {
    Rig::new().dialogue(&[("4000500000000000", "8000500000000206"), ("2300100000000000", "8000100002000106")]);
}
