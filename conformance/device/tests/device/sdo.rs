//! The SDO server.

use crate::rig::Rig;
use canvass_device::Motion;
use canvass_device::models::Model;

#[test]
fn segmented_upload() {
    Rig::new().dialogue(&[
        ("4008100000000000", "4108100016000000"),
        ("6000000000000000", "004B7565626C6572"),
        ("7000000000000000", "102053656E646978"),
        ("6000000000000000", "0020456E636F6465"),
        ("7000000000000000", "1D72000000000000"),
        ("6000000000000000", "8000000001000405"),
    ]);
}

#[test]
fn wrong_toggles_end_the_transfer() {
    let mut rig = Rig::new();
    rig.dialogue(&[
        ("4008100000000000", "4108100016000000"),
        ("7000000000000000", "8008100000000305"),
        ("6000000000000000", "8000000001000405"),
        ("2117100002000000", "6017100000000000"),
        ("1B01020000000000", "8017100000000305"),
        ("4017100000000000", "4B17100000000000"),
    ]);
}

#[test]
fn segmented_download() {
    let mut rig = Rig::new();
    rig.dialogue(&[
        // 2140h:01 is downloaded in two segments, with and without an announced size.
        ("2140210104000000", "6040210100000000"),
        ("0A11220000000000", "2000000000000000"),
        ("1B33440000000000", "3000000000000000"),
        ("4040210100000000", "4340210111223344"),
        ("2040210100000000", "6040210100000000"),
        ("07AABBCCDD000000", "2000000000000000"),
    ]);
    assert_eq!(rig.read(0x2140, 1), Ok(0xDDCC_BBAA));
    rig.dialogue(&[
        // The data is longer or shorter than announced: the object keeps its value.
        ("2100600002000000", "6000600000000000"),
        ("0900000000000000", "8000600012000706"),
        ("2101600004000000", "6001600000000000"),
        ("0B11000000000000", "8001600013000706"),
        // A wrong length, a read-only object and an absent object are refused at once.
        ("2100600003000000", "8000600012000706"),
        ("2100100004000000", "8000100002000106"),
        ("2100500004000000", "8000500000000206"),
    ]);
    assert_eq!(rig.read(0x6000, 0), Ok(4));
}

#[test]
fn a_new_transfer_ends_the_old_one_and_an_abort_has_no_answer() {
    let mut rig = Rig::new();
    rig.dialogue(&[("2140210104000000", "6040210100000000"), ("4000600000000000", "4B00600004000000")]);
    rig.dialogue(&[("0B11000000000000", "8000000001000405"), ("2140210104000000", "6040210100000000")]);
    assert!(rig.ask("63F#8040210100000008").is_empty());
    assert_eq!(rig.read(0x2140, 1), Ok(0));
}

#[test]
fn a_client_that_falls_silent_is_told_once() {
    let mut rig = Rig::new();
    rig.dialogue(&[("4008100000000000", "4108100016000000")]);
    assert_eq!(rig.run(2000), ["5BF#8008100000000405"]);
}

#[test]
fn abort_codes() {
    let mut rig = Rig::new();
    assert_eq!(rig.read(0x1004, 0), Err("06020000".to_owned()));
    assert_eq!(rig.read(0x1000, 1), Err("06090011".to_owned()));
    assert_eq!(rig.read(0x1003, 1), Err("08000024".to_owned()));
    for (index, sub, value, len, expected) in [
        (0x1000, 0, 0, 4, "06010002"),
        (0x1017, 0, 0, 4, "06070012"),
        (0x1017, 0, 0, 1, "06070013"),
        (0x2100, 0, 9, 1, "06090031"),
        (0x2101, 0, 0, 1, "06090032"),
        (0x1003, 0, 1, 1, "06090030"),
        (0x1010, 1, 0x7361_7665, 4, "08000020"),
        (0x1011, 1, 0, 4, "08000020"),
        (0x1005, 0, 0x4000_0080, 4, "06090030"),
        (0x1005, 0, 0x181 - 1, 4, "06090030"),
        (0x1800, 1, 0x1C0, 4, "06090030"),
        (0x1800, 1, 0x6BF, 4, "06090030"),
        (0x1800, 2, 241, 1, "06090030"),
        (0x1800, 3, 100, 2, "06090030"),
        (0x1A00, 0, 0, 1, "06010000"),
        (0x6000, 0, 0x0010, 2, "06090030"),
        (0x6003, 0, 0x0200_0000, 4, "06090031"),
    ] {
        assert_eq!(rig.write(index, sub, value, len), expected, "{index:04X}h:{sub:02X} = {value:X}h");
    }
}

#[test]
fn mapping_rules() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x1800, 1, 0x8000_01BF, 4), "ok");
    assert_eq!(rig.write(0x1A00, 1, 0x6004_0020, 4), "06010000", "while sub-index 0 is not 0");
    assert_eq!(rig.write(0x1A00, 0, 0, 1), "ok");
    for (entry, expected) in [
        (0x5000_0020, "06020000"),
        (0x6000_0010, "06040041"),
        (0x6004_0010, "06040041"),
        (0x0005_0008, "06040041"),
        (0x6004_0020, "ok"),
    ] {
        assert_eq!(rig.write(0x1A00, 1, entry, 4), expected, "{entry:08X}");
    }
    assert_eq!(rig.write(0x1800, 1, 0x0000_01BF, 4), "06090030", "not valid without mapping");
    assert_eq!(rig.write(0x1A00, 2, 0x6004_0020, 4), "ok");
    assert_eq!(rig.write(0x1A00, 3, 0x6030_0110, 4), "ok");
    assert_eq!(rig.write(0x1A00, 0, 9, 1), "06040042");
    assert_eq!(rig.write(0x1A00, 0, 3, 1), "06040042", "80 bits");
    assert_eq!(rig.write(0x1A00, 0, 4, 1), "06020000", "an entry that is empty");
    assert_eq!(rig.write(0x1A00, 0, 2, 1), "ok");
    assert_eq!(rig.write(0x1800, 1, 0x0000_01BF, 4), "ok");
    assert!(rig.ask("000#013F").contains(&"1BF#BA4C0000BA4C0000".to_owned()));
}

/// The abort of an unknown or unsupported command names the object in the client's request.
#[test]
fn command_specifiers() {
    Rig::new().dialogue(&[
        ("E000600000000000", "8000600001000405"),
        ("0000000000000000", "8000000001000405"),
        ("6000000000000000", "8000000001000405"),
        ("A000100014000000", "8000100001000405"),
        ("C217100002000000", "8017100001000405"),
        ("A200000000000000", "8000000001000405"),
    ]);
    let mut rig = Rig::new();
    for frame in ["63F#", "63F#40", "63F#40006000", "63F#R8", "0000063F#4000600000000000"] {
        assert!(rig.ask(frame).is_empty(), "{frame}");
    }
}

/// An unsupported block transfer interrupts another transfer: the abort names the object of the client's request, and
/// the interrupted transfer has ended.
#[test]
fn a_refused_block_transfer_names_its_own_object() {
    let mut rig = Rig::new();
    rig.dialogue(&[
        // A segmented upload is open.
        ("4008100000000000", "4108100016000000"),
        ("A000600014000000", "8000600001000405"),
        ("6000000000000000", "8000000001000405"),
        // A segmented download is open.
        ("2140210104000000", "6040210100000000"),
        ("C217100002000000", "8017100001000405"),
        ("0B11000000000000", "8000000001000405"),
    ]);
    assert_eq!(rig.read(0x2140, 1), Ok(0));
    // The abort of a request without an object names the object of the open transfer.
    rig.dialogue(&[("4008100000000000", "4108100016000000"), ("A300000000000000", "8008100001000405")]);
}

/// The simulated device with an SDO server that supports block transfers.
fn with_blocks() -> Rig {
    let eds = include_str!("../../models/kuebler-sendix-58x8.eds");
    let sheet = include_str!("../../models/kuebler-sendix-58x8.toml");
    let sheet = sheet.replace("sdo_block_transfer = false", "sdo_block_transfer = true");
    let model = Model::read(eds, &sheet).unwrap();
    let mut rig = Rig::powered(&model, Some(63), Default::default(), &Motion::default());
    rig.run(300);
    assert!(model.sheet().network.sdo_block_transfer, "the sheet has another wording now");
    rig
}

#[test]
fn block_upload() {
    let mut rig = with_blocks();
    rig.dialogue(&[("A408100002000000", "C608100016000000")]);
    assert_eq!(rig.ask("63F#A300000000000000"), ["5BF#014B7565626C6572", "5BF#022053656E646978"]);
    // The second segment was lost; blocks have three segments from now on.
    assert_eq!(
        rig.ask("63F#A201030000000000"),
        ["5BF#012053656E646978", "5BF#0220456E636F6465", "5BF#8372000000000000"]
    );
    // CRC-16/XMODEM of "Kuebler Sendix Encoder"; six bytes of the last segment are unused.
    assert_eq!(rig.ask("63F#A203030000000000"), [format!("5BF#D9{}0000000000", crc(b"Kuebler Sendix Encoder"))]);
    assert!(rig.ask("63F#A100000000000000").is_empty());
    rig.dialogue(&[
        ("A000100000000000", "8000100002000405"),
        ("A000100080000000", "8000100002000405"),
        // A value up to the threshold is sent by a normal upload.
        ("A000100014040000", "4300100096010200"),
        ("A408100002000000", "C608100016000000"),
        ("6000000000000000", "8008100001000405"),
    ]);
}

#[test]
fn block_download() {
    let mut rig = with_blocks();
    let good = format!("CD{}0000000000", crc(&[0x11, 0x22, 0x33, 0x44]));
    rig.dialogue(&[
        ("C640210104000000", "A44021017F000000"),
        ("8111223344000000", "A2017F0000000000"),
        (&good, "A100000000000000"),
    ]);
    assert_eq!(rig.read(0x2140, 1), Ok(0x4433_2211));
    rig.dialogue(&[
        ("C640210104000000", "A44021017F000000"),
        ("8155667788000000", "A2017F0000000000"),
        ("CD00000000000000", "8040210104000405"),
        ("C640210103000000", "8040210113000706"),
        ("C600100004000000", "8000100002000106"),
        ("C640210104000000", "A44021017F000000"),
        ("0011223344000000", "8040210103000405"),
    ]);
    // The first segment was lost: the confirmation of the block says so.
    rig.dialogue(&[
        ("C640210104000000", "A44021017F000000"),
        ("8211223344000000", "A2007F0000000000"),
        ("8155667788000000", "A2017F0000000000"),
    ]);
    assert!(rig.ask("63F#8040210100000008").is_empty());
    assert_eq!(rig.read(0x2140, 1), Ok(0x4433_2211), "the old value");
}

/// Calculates the CRC bit by bit, as CiA 301 describes it.
fn crc(data: &[u8]) -> String {
    let mut crc = 0_u16;
    for &byte in data {
        crc ^= u16::from(byte) << 8;
        for _ in 0..8 {
            crc = if crc & 0x8000 != 0 { crc << 1 ^ 0x1021 } else { crc << 1 };
        }
    }
    let [low, high] = crc.to_le_bytes();
    format!("{low:02X}{high:02X}")
}
