use super::*;
use proptest::prelude::*;

const EDS: &str = include_str!("../../../../conformance/device/models/kuebler-sendix-f58.eds");

fn of(text: &str, id: u8) -> (String, Database) {
    let description = DeviceDescription::read(text.as_bytes()).unwrap();
    let database = database(KnownDevice::described(description), NodeId::new(id).unwrap());
    let text = database.bytes.iter().map(|&byte| char::from(byte)).collect();
    (text, database)
}

#[test]
fn pdos_stand_as_they_are_mapped() {
    let (text, database) = of(EDS, 63);
    for line in [
        "BU_: Sendix_F5868_63",
        "BO_ 447 Sendix_F5868_63_TPDO1: 4 Sendix_F5868_63",
        " SG_ Position_value : 0|32@1+ (0.0439453125,0) [0|0] \"\u{B0}\" Vector__XXX",
        "CM_ SG_ 447 Position_value \"6004h:00 Position value\";",
    ] {
        assert!(text.lines().any(|found| found == line), "{line} is not in\n{text}");
    }
    assert_eq!(database.messages, text.matches("\nBO_ ").count());
}

/// The DBC entries of an RPDO, a real number, a gap, a name without letters and a 29-bit identifier.
#[test]
fn unusual_pdos_are_written_too() {
    let object = |index: &str, name: &str, kind: &str, access: &str| {
        format!("[{index}]\nParameterName={name}\nDataType={kind}\nAccessType={access}\nPDOMapping=1\n")
    };
    let record = |index: &str, subs: &[(u8, &str, &str)]| {
        let subs: String = subs
            .iter()
            .map(|(sub, kind, value)| {
                format!("[{index}sub{sub}]\nParameterName=x\nDataType={kind}\nAccessType=rw\nDefaultValue={value}\n")
            })
            .collect();
        format!("[{index}]\nParameterName=PDO\nObjectType=9\n{subs}")
    };
    let text = [
        "[DeviceInfo]\nProductName=\u{FC}\n".to_owned(),
        record("1400", &[(0, "5", "2"), (1, "7", "$NODEID+0x20000200"), (2, "5", "1")]),
        record("1600", &[(0, "5", "3"), (1, "7", "0x20000020"), (2, "7", "0x00050008"), (3, "7", "0x20010008")]),
        record("1800", &[(0, "5", "1"), (1, "7", "0x80000180")]),
        record("1801", &[(0, "5", "1"), (1, "7", "$NODEID+0x280")]),
        record("1A01", &[(0, "5", "2"), (1, "7", "0x20000020"), (2, "7", "0x20020040")]),
        record("1802", &[(0, "5", "1"), (1, "7", "$NODEID+0x380")]),
        object("2000", "Set \"point\"", "8", "rw"),
        object("2001", "", "2", "rw"),
    ]
    .concat();
    let (text, database) = of(&text, 5);
    let expected = "BO_ 2147484165 Node_5_RPDO1: 6 Vector__XXX\n SG_ Set_point : 0|32@1- (1,0) [0|0] \"\" Node_5\n \
                    SG_ Object_2001_00 : 40|8@1- (1,0) [0|0] \"\" Node_5\n";
    assert!(text.contains(expected), "{text}");
    assert!(text.contains("CM_ BO_ 2147484165 \"RPDO 1 (1400h, 1600h), transmission type 1\";"), "{text}");
    assert!(
        text.contains("\"2000h:00 Set 'point'\"") && text.contains("SIG_VALTYPE_ 2147484165 Set_point : 1;"),
        "{text}"
    );
    assert_eq!(
        database.left_out,
        [
            "TPDO 1: it is switched off",
            "TPDO 2: 12 bytes are mapped, and a CAN frame has 8",
            "TPDO 3: nothing is mapped, or the mapping is not described"
        ]
    );
}

proptest! {
    /// No text of a description can change the lines of the database.
    #[test]
    fn texts_of_files_do_not_act(name in "\\PC{0,40}", product in "[\u{0}-\u{20}\"\\\\;a-z\u{FC}]{0,20}") {
        let text = EDS.replace("ParameterName=Position value", &format!("ParameterName={name}"))
            .replace("ProductName=", &format!("ProductName={product}"));
        let (text, _) = of(&text, 63);
        prop_assert!(text.lines().all(|line| {
            line.is_empty() || ["VERSION ", "NS_ ", "BS_:", "BU_: ", "BO_ ", " SG_ ", "CM_ ", "SIG_VALTYPE_ "].iter().any(|word| line.starts_with(word))
        }), "{text}");
        prop_assert!(text.lines().all(|line| line.matches('"').count() % 2 == 0), "{text}");
    }
}
