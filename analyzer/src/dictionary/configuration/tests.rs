//! Configurations: values for a node, and concise DCFs.

use super::*;
use crate::dictionary::KnownDevice;
use crate::identity::CobId;
use proptest::prelude::*;

const DCF: &str = "[DeviceInfo]\nVendorNumber=0x13\nProductNumber=1\nRevisionNumber=2\n\
    [DeviceComissioning]\nNodeID=5\nBaudrate=250\nLSS_SerialNumber=7\n\
    [1014]\nParameterName=COB-ID EMCY\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x80\nParameterValue=$NODEID+0x80\n\
    [1017]\nParameterName=Heartbeat\nDataType=6\nAccessType=rw\nParameterValue=1000\n\
    [1008]\nParameterName=Name\nDataType=9\nAccessType=const\nParameterValue=abc\n\
    [1400]\nParameterName=RPDO\nObjectType=9\nSubNumber=2\n[1400sub0]\nParameterName=n\nDataType=5\nAccessType=ro\n\
    [1400sub1]\nParameterName=id\nDataType=7\nAccessType=rw\nParameterValue=0x183\n\
    [1800]\nParameterName=TPDO\nObjectType=9\nSubNumber=2\n[1800sub0]\nParameterName=n\nDataType=5\nAccessType=ro\n\
    [1800sub1]\nParameterName=id\nDataType=7\nAccessType=rw\nParameterValue=0x40000185\n";

fn read(text: &str) -> DeviceDescription {
    DeviceDescription::read(text.as_bytes()).unwrap()
}

fn node(raw: u8) -> NodeId {
    NodeId::new(raw).unwrap()
}

fn values(text: &str, raw: u8) -> Vec<String> {
    let downloads = configured(&read(text), node(raw)).unwrap();
    let number = |value: &[u8]| value.iter().rev().fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
    downloads.iter().map(|download| format!("{} {:X}", download.at, number(&download.value))).collect()
}

/// Formulas and CAN-IDs of the predefined connection set follow the node; what the device only receives stays.
#[test]
fn cob_ids_follow_the_node() {
    assert_eq!(values(DCF, 5), ["1014h:00 85", "1017h:00 3E8", "1400h:01 183", "1800h:01 40000185"]);
    assert_eq!(values(DCF, 6), ["1014h:00 86", "1017h:00 3E8", "1400h:01 183", "1800h:01 40000186"]);
}

/// Two nodes must not send with the same CAN-ID; one that is switched off is no danger.
#[test]
fn can_ids_of_one_node_are_not_given_to_another() {
    let moved = DCF.replace("0x40000185", "0x1A2");
    assert_eq!(values(&moved, 5)[3], "1800h:01 1A2");
    let told = configured(&read(&moved), node(6)).unwrap_err();
    assert_eq!(told.len(), 1);
    assert!(told[0].to_string().starts_with("1800h:01: the CAN-ID 1A2h is for node 5"), "{}", told[0]);
    assert_eq!(values(&DCF.replace("0x40000185", "0x800001A2"), 6)[3], "1800h:01 800001A2");
    let unfit = configured(&read(&DCF.replace("ParameterValue=1000", "ParameterValue=100000")), node(5));
    assert!(unfit.is_err() || unfit.unwrap().len() == 3, "a value that fits no UNSIGNED16 is never cut");
}

#[test]
fn the_identity_is_that_of_the_file() {
    assert_eq!(identity(&read(DCF), node(5)), [Some(0x13), Some(1), Some(2), Some(7)]);
    assert_eq!(identity(&read(DCF), node(6))[3], None, "another device has another serial number");
}

#[test]
fn what_is_read_becomes_a_formula_where_the_default_is_one() {
    let description = read(DCF);
    let entry = description.dictionary.entry(Multiplexer::new(object::COB_ID_EMCY, 0)).unwrap();
    assert_eq!(setting_of(entry, &[0x89, 0, 0, 0], node(9)), Some(Setting::NodeIdPlus(0x80)));
    assert_eq!(setting_of(entry, &[0x8A, 0, 0, 0], node(9)), Some(Setting::Fixed(Value::Unsigned(0x8A))));
    assert_eq!(setting_of(entry, &[0x8A], node(9)), None);
}

/// Set-points of a drive and outputs in an RPDO are no settings: writing them moves something.
#[test]
fn what_moves_a_machine_is_no_setting() {
    let entry = |index: &str, more: &str| format!("[{index}]\nParameterName=x\nDataType=7\nAccessType=rw\n{more}\n");
    let drive = format!(
        "{}{}{}{}{}",
        entry("1000", "DefaultValue=0x00020192"),
        entry("6040", ""),
        entry("687A", ""),
        entry("6081", ""),
        entry("60FE", "")
    );
    let known = KnownDevice::described(read(&drive));
    let settings = DeviceSettings::described(&known, node(5));
    let acts = |index| settings.acts(Multiplexer::new(index, 0));
    assert_eq!([0x6040, 0x687A, 0x60FE, 0x6081].map(acts), [true, true, true, false]);
    // An output module: 2001h is in RPDO 1, 2002h is not, and the second entry of the mapping is not counted.
    let module = format!(
        "[DeviceComissioning]\nNodeID=5\n{}{}{}[1600]\nParameterName=m\nObjectType=9\nSubNumber=3\n[1600sub0]\nParameterName=n\nDataType=5\n\
         AccessType=rw\nParameterValue=1\n{}{}",
        entry("1000", "DefaultValue=0x00020191"),
        entry("2001", ""),
        entry("2002", ""),
        entry("1600sub1", "ParameterValue=0x20010020"),
        entry("1600sub2", "ParameterValue=0x20020020")
    );
    let known = KnownDevice::described(read(&module));
    let settings = DeviceSettings::described(&known, node(5));
    let why = |index| {
        let at = Multiplexer::new(index, 0);
        settings.excluded(at, known.description.dictionary.entry(at).unwrap())
    };
    assert_eq!((why(0x2001), why(0x2002)), (Some(Excluded::Process), None));
    assert_eq!(settings.hazard(Multiplexer::new(0x2001, 0), &[1]), Some(Hazard::Process));
}

fn downloads() -> impl Strategy<Value = Vec<Download>> {
    let one = (any::<u16>(), any::<u8>(), prop::collection::vec(any::<u8>(), 0..12));
    let one = one.prop_map(|(index, sub, value)| Download { at: Multiplexer::new(index, sub), value });
    prop::collection::vec(one, 0..20)
}

/// CiA 302-3: one value, 1017h:00 = 1000.
#[test]
fn a_concise_dcf_by_hand() {
    let bytes = [1, 0, 0, 0, 0x17, 0x10, 0, 2, 0, 0, 0, 0xE8, 3];
    let heartbeat = Download { at: Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0), value: vec![0xE8, 3] };
    assert_eq!(read_concise(&bytes), Ok(vec![heartbeat]));
    assert_eq!(read_concise(&bytes[..12]), Err(BadConcise::Short { at: 4, announced: 1, number: 1 }));
    assert_eq!(read_concise(&[&bytes[..], &[0]].concat()), Err(BadConcise::Long { at: 13, announced: 1, rest: 1 }));
    assert_eq!(read_concise(&bytes[..3]), Err(BadConcise::Short { at: 0, announced: 0, number: 0 }));
}

proptest! {
    #[test]
    fn concise_dcfs_are_read_as_written(downloads in downloads()) {
        prop_assert_eq!(read_concise(&write_concise(&downloads)), Ok(downloads));
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
        if let Ok(downloads) = read_concise(&bytes) {
            prop_assert_eq!(write_concise(&downloads), bytes);
        }
    }

    /// Each value is written last as it is wanted, and a COB-ID never changes while its object is valid.
    #[test]
    fn the_order_ends_with_the_wanted_values(ids in prop::collection::vec((0_u16..4, 0x181_u32..0x57F, any::<bool>()), 1..5)) {
        let mut wanted = std::collections::BTreeMap::new();
        for (pdo, id, valid) in ids {
            let value = if valid { id } else { id | CobId::INVALID };
            wanted.insert(Multiplexer::new(0x1800 + pdo, 1), value);
            wanted.insert(Multiplexer::new(0x1A00 + pdo, 0), 1);
        }
        let downloads: Vec<Download> = wanted
            .iter()
            .map(|(at, value)| Download { at: *at, value: value.to_le_bytes().to_vec() })
            .collect();
        let mut now = std::collections::BTreeMap::new();
        for Download { at, value } in ordered(&downloads, &[]) {
            let number = value.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte));
            if at.index.0 >= 0x1A00 {
                let off = now.get(&Multiplexer::new(at.index.0 - 0x200, 1)).is_some_and(|id: &u32| !CobId(*id).is_valid());
                prop_assert!(off, "{at} is written while its PDO is on");
            }
            now.insert(at, number);
        }
        prop_assert_eq!(now, wanted);
    }
}
