//! The effect of each liberty on the behaviour of a device.

use crate::steps::result;
use Liberty::*;
use canvass_device::{Firmware, Liberty};
use std::collections::BTreeSet;

/// A liberty, the steps with a device of its model, the result without the liberty, and the result with it.
type Shown = (Liberty, &'static [&'static str], &'static str, &'static str);

const START: &str = "000#010A";
const STOP: &str = "000#020A";
const RESET: &str = "000#810A";
/// Begins a segmented download of three bytes to 2012h.
const DOWNLOAD: &str = "60A#2112200003000000";
/// Begins a block upload of 2010h without CRC and threshold.
const BLOCK_UPLOAD: &str = "60A#A01020007F00";

const SHOWN: &[Shown] = &[
    (ToggleIgnored, &["200", DOWNLOAD, "60A#10414243"], "58A#8012200000000305", ""),
    (BlockInitiateRefused, &["200", BLOCK_UPLOAD, "60A#40001000"], "58A#4300100091010F00", "58A#8000100001000405"),
    (
        TransferWithoutTimeout,
        &["200", DOWNLOAD, "1500", "60A#09414243"],
        "58A#8000000001000405",
        "58A#2000000000000000",
    ),
    (TimeoutWithoutAbort, &["200", DOWNLOAD, "1500"], "58A#8012200000000405", ""),
    (SmallBlocks, &["200", "60A#C212200003000000"], "58A#A41220007F000000", "58A#A412200004000000"),
    (SizesUnannounced, &["200", "60A#40102000"], "58A#411020005A000000", "58A#4010200000000000"),
    (StringsInSegments, &["200", "60A#40091000"], "58A#47091000312E3000", "58A#4109100003000000"),
    (StringsOfOneLength, &["200", "w 2011:00 6162"], "ok", "06070013"),
    (ReservedBitsRefused, &["200", "60A#5000100000000000"], "58A#4300100091010F00", "58A#8000000001000405"),
    (ProtocolBeforeBlockSize, &["200", "60A#A00010000004"], "58A#8000100002000405", "58A#4300100091010F00"),
    (BlocksWithoutCrc, &["200", "60A#A41020007F00"], "58A#C61020005A000000", "58A#C21020005A000000"),
    (NoBlockTransfer, &["200", BLOCK_UPLOAD], "58A#C61020005A000000", "58A#8010200001000405"),
    (NoSegmentedTransfer, &["200", "60A#2117100002000000"], "58A#6017100000000000", "58A#8017100001000405"),
    (RefusedAtEnd, &["200", "60A#2100100004000000"], "58A#8000100002000106", "58A#6000100000000000"),
    (ProtocolNotSwitched, &["200", "60A#A00810007F7F"], "58A#4108100015000000", "58A#C608100015000000"),
    (
        LengthBeforeCrc,
        &["200", "60A#C612200005000000", "60A#8141424300000000", "60A#D1FFFF"],
        "58A#8012200004000405",
        "58A#8012200013000706",
    ),
    (LengthCodeGeneral, &["200", "w 1017:00 E8030000"], "06070012", "06070010"),
    (RangeCodeGeneral, &["200", "w 2041:00 0100"], "06090032", "06090030"),
    (LimitCodePrecise, &["200", "w 1029:01 03"], "06090030", "06090031"),
    (SignatureCodeValue, &["200", "w 1010:01 00000000"], "08000020", "06090030"),
    (SignatureCodeGeneral, &["200", "w 1011:01 00000000"], "08000020", "08000000"),
    (HistoryCodeGeneral, &["200", "r 1003:01"], "08000024", "08000000"),
    (OverflowCodeGeneral, &["200", "w 1006:00 10270000", "w 1019:00 0A"], "08000022", "08000000"),
    (EntryCodeMissing, &["200", "w 1800:01 8A010080", "w 1A00:00 00", "w 1A00:01 10001710"], "06040041", "06020000"),
    (EntryCodeUnmappable, &["200", "w 1800:01 8A010080", "w 1A00:00 00", "w 1A00:01 08000050"], "06020000", "06040041"),
    (CountCodeMissing, &["200", "w 1800:01 8A010080", "w 1A00:00 40"], "06040042", "06020000"),
    (CobIdCodeGeneral, &["200", "w 1014:00 91000000"], "06090030", "08000000"),
    (CobIdCodeState, &["200", "w 1800:01 A0060000"], "06090030", "08000022"),
    (CobIdRewriteRefused, &["200", "w 1800:01 8A010000"], "ok", "06090030"),
    (PdoParametersLocked, &["200", "w 1800:05 6400"], "ok", "06090030"),
    (AnswersIn900Ms, &["200", "after 60A#40001000"], "1 ms", "900 ms"),
    (AnswersVary, &["200", "after 60A#40001000"], "1 ms", "189 ms"),
    (RestartIn5S, &["5200", "after 000#810A"], "100 ms", "5000 ms"),
    (StoreIn3S, &["200", "after 60A#2310100173617665"], "21 ms", "3001 ms"),
    (StoresByItself, &["200", "w 1017:00 E803", RESET, "200", "r 1017:00"], "=00000000", "=E8030000"),
    (StoresBothWays, &["200", "r 1010:01"], "=01000000", "=03000000"),
    (VariablesKept, &["200", "w 2041:00 2200", RESET, "200", "r 2041:00"], "=64000000", "=22000000"),
    (SelfStart, &["200", "70A#R"], "70A#7F", "70A#05"),
    (SelfStartByObject, &["200", "70A#R"], "70A#7F", "70A#05"),
    (NodeIdRestored, &["200", "w 1011:01 6C6F6164", RESET, "300"], "70A#00", ""),
    (NamesEndInNul, &["200", "60A#40091000"], "58A#47091000312E3000", "58A#43091000312E3000"),
    (NoNames, &["200", "r 1008:00"], "=15000000", "06020000"),
    (VendorIdAlone, &["200", "r 1018:02"], "=01030000", "06090011"),
    (NoEmcy, &["200", START, "20A#"], "08A#1082110100000000", ""),
    (NoEmcyInhibitTime, &["200", "r 1015:00"], "=00000000", "06020000"),
    (InhibitFromWrite, &["200", START, "w 1015:00 FFFF", "20A#"], "08A#1082110100000000", ""),
    (NoErrorHistory, &["200", "r 1003:00"], "=00000000", "06020000"),
    (ShortErrorHistory, &["200", "r 1003:02"], "08000024", "06090011"),
    (GenericErrorCodes, &["200", START, "20A#"], "08A#1082110100000000", "08A#0010110100000000"),
    (GenericErrorBit, &["200", START, "20A#", "r 1001:00"], "=11000000", "=01000000"),
    (NoErrorBehaviour, &["200", "r 1029:01"], "=00000000", "06020000"),
    (SyncLengthUnreported, &["200", START, "080#0102"], "08A#4082110000000000", ""),
    (LongRpdoUnreported, &["200", START, "20A#0000000000000000"], "08A#2082110100000000", ""),
    (
        StoppedEmcyNewest,
        &["200", "w 1016:01 96000B00", "w 1016:02 96000C00", "70B#05", "70C#05", STOP, "200", "000#800A"],
        "08A#3081110000000000 08A#3081110000000000",
        "08A#3081110000000000",
    ),
    (StoppedEmcyDropped, &["200", "w 1016:01 64000B00", "70B#05", STOP, "100", "000#800A"], "08A#3081110000000000", ""),
    (LostHeartbeatUnreported, &["200", "w 1016:01 C8000B00", "70B#05", "300"], "08A#3081110000000000", ""),
    (NoHeartbeatConsumer, &["200", "r 1016:01"], "=00000000", "06020000"),
    (OneHeartbeatConsumer, &["200", "r 1016:02"], "=00000000", "06090011"),
    (NoGuarding, &["200", "70A#R"], "70A#7F", ""),
    (NoSyncCounter, &["200", "r 1019:00"], "=00000000", "06020000"),
    (NoSyncWindow, &["200", "r 1007:00"], "=00000000", "06020000"),
    (NoSyncProducer, &["200", "w 1005:00 80000040"], "ok", "06090030"),
    (NoTime, &["200", "r 1012:00"], "=00010080", "06020000"),
    (NoStore, &["200", "r 1010:01"], "=01000000", "06020000"),
    (NoConfigurationDate, &["200", "r 1020:01"], "=00000000", "06020000"),
    (NoFurtherSdo, &["200", "r 1201:01"], "=00000080", "06020000"),
    (NoEmcyConsumer, &["200", "r 1028:01"], "=00000080", "06020000"),
    (PdosInvalid, &["200", START], "18A#00000000 28A#00000000", ""),
    (OnePdo, &["200", "r 1801:01"], "=8A020000", "06020000"),
    (NoApplicationObjects, &["200", "r 6000:01"], "=00000000", "06020000"),
    (NoLongObjects, &["200", "r 2010:00"], "=5A000000", "06020000"),
    (SyncCountFromMiddle, &["200", "w 1802:01 8A030080", "w 1800:02 03", START, "080#", "080#"], "", "18A#00000000"),
    (SyncTpdoIn40Ms, &["200", "w 1802:01 8A030080", "w 1800:02 01", START, "after 080#"], "0 ms", "40 ms"),
    (OwnEvents, &["200", START, "20A#01020304"], "18A#01020304", ""),
    (NoSynchronousPdos, &["200", "w 1800:01 8A010080", "w 1800:02 01"], "ok", "06090030"),
    (NoRtr, &["200", START, "18A#R"], "18A#00000000", ""),
    (NoDummies, &["200", "w 1400:01 0A020080", "w 1600:00 00", "w 1600:01 08000500"], "ok", "06040041"),
    (MappingInBytes, &["200", "w 1400:01 0A020080", "w 1600:00 00", "w 1600:01 01000100"], "ok", "06040041"),
    (
        MappingLengthAtEntry,
        &["200", "w 1800:01 8A010080", "w 1A00:00 00", "w 1A00:01 40002120", "w 1A00:02 40002120"],
        "ok",
        "06040042",
    ),
    (MappingFixed, &["200", "w 1800:01 8A010080", "w 1A00:00 00"], "ok", "06010002"),
    (NoInhibitTime, &["200", "r 1800:03"], "=00000000", "06090011"),
    (NoEventTimer, &["200", "r 1800:05"], "=00000000", "06090011"),
    (NoRpdoDeadline, &["200", "r 1400:05"], "=00000000", "06090011"),
    (LongInhibitTime, &["200", "r 1800:03"], "=00000000", "=D0070000"),
    (ValidAndEmpty, &["200", "r 1A00:00"], "=04000000", "=00000000"),
    (
        NoFastscan,
        &[
            "200",
            "7E5#0401000000000000",
            "7E5#11FF000000000000",
            "7E5#0400000000000000",
            "000#820A",
            "200",
            "7E5#5100000000800000",
        ],
        "7E4#4F00000000000000",
        "",
    ),
    (NoLssInquiry, &["200", "7E5#0401000000000000", "7E5#5E00000000000000"], "7E4#5E0A000000000000", ""),
    (NoLss, &["200", "7E5#0401000000000000", "7E5#5E00000000000000"], "7E4#5E0A000000000000", ""),
    (
        BitRateTakenLate,
        &["200", "7E5#0401000000000000", "7E5#1300030000000000", "7E5#1564000000000000", "250", "r 1000:00"],
        "=91010F00",
        "silence",
    ),
    (LssStoreIn2S, &["200", "7E5#0401000000000000", "after 7E5#1700000000000000"], "0 ms", "2000 ms"),
    (OwnSdoClient, &["200", "count 67F 2000"], "0", "4"),
    (OwnTraffic, &["200", "count 6D0 1000"], "0", "80"),
];

/// A PDO that is delivered valid and empty can be switched off and on again. Another PDO can't be switched on while it
/// is empty.
#[test]
fn what_is_delivered_empty_can_be_restored() {
    let off_and_on = ["200", "w 1800:01 8A010080", "w 1A00:00 00", "w 1800:01 8A010000"];
    assert_eq!(result("reference-301", ValidAndEmpty, &off_and_on), "ok");
    assert_eq!(result("reference-301", Firmware::PLAIN, &off_and_on), "06090030");
}

/// Each liberty shows: the results without and with the liberty differ as its row says.
#[test]
fn each_liberty_shows_in_its_own_way() {
    for &(liberty, steps, plain, taken) in SHOWN {
        assert_ne!(plain, taken, "{liberty}");
        assert_eq!(result(liberty.model(), Firmware::PLAIN, steps), plain, "without {liberty}");
        assert_eq!(result(liberty.model(), liberty, steps), taken, "with {liberty}");
    }
}

#[test]
fn no_liberty_is_left_out() {
    let shown: BTreeSet<Liberty> = SHOWN.iter().map(|row| row.0).chain(crate::descriptions::SHOWN).collect();
    assert_eq!(shown.len(), SHOWN.len() + crate::descriptions::SHOWN.len(), "one row each");
    // `DirtyPadding` shows only in the frames of a socket: tests of the bus crate and on vcan cover it.
    let here = |liberty: &&Liberty| **liberty != Liberty::DirtyPadding;
    let missing: Vec<&Liberty> = Liberty::ALL.iter().filter(here).filter(|liberty| !shown.contains(liberty)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    assert!(Liberty::ALL.len() >= 60);
}
