//! `zencan-node` 0.0.5.

use super::{Expected, Outcome, PDO_PARAMETERS_UNCHECKED, Peer, expect, judge, passed, trace};
use canvass_stacks::zencan::{EDS, NODE, Zencan};
use canvass_suite::verdict::Kind::{Fail, Inconclusive};

/// Defects of the stack, explained in `docs/peers.md`; PDO parameters are stored with few checks or none.
const EXPECTED: &Expected = &[
    ("301/boot-up/every-time", Fail, BOOT_UP),
    ("301/boot-up/no-sdo-before", Fail, BOOT_UP),
    ("301/boot-up/reset-communication", Fail, BOOT_UP),
    ("301/boot-up/reset-node", Fail, BOOT_UP),
    ("301/boot-up/silent-before", Fail, BOOT_UP),
    ("301/nmt/broadcast/reset-communication", Fail, BOOT_UP),
    ("301/nmt/broadcast/reset-node", Fail, BOOT_UP),
    ("301/nmt/operational/reset-communication", Fail, BOOT_UP),
    ("301/nmt/operational/reset-node", Fail, BOOT_UP),
    ("301/nmt/pre-operational/reset-communication", Fail, BOOT_UP),
    ("301/nmt/pre-operational/reset-node", Fail, BOOT_UP),
    ("301/nmt/stopped/reset-communication", Fail, BOOT_UP),
    ("301/nmt/stopped/reset-node", Fail, BOOT_UP),
    ("305/unconfigured/boots", Fail, BOOT_UP),
    ("301/dictionary/described", Fail, "1010h:00 can't be read"),
    ("301/tpdo/remote-triggered", Fail, "transmission type 253 is taken, and remote frames not answered"),
    ("301/sdo/abort/unanswered", Fail, ANSWERED_ABORT),
    ("301/sdo/block-upload/missing", Fail, LATE),
    ("301/sdo/block-download/client-abort", Fail, "an abort in a block of a block download is answered by an abort"),
    ("301/sdo/block-download/segment-lost", Fail, REPEATED),
    ("301/sdo/block-download/segments-swapped", Fail, REPEATED),
    ("301/sdo/block-download/sequence-zero", Fail, "a segment with sequence number 0 is passed over"),
    ("301/sdo/block-upload/all-lost", Fail, CRC),
    ("301/sdo/block-upload/part-lost", Fail, CRC),
    ("301/sdo/block-upload/complete", Fail, NAMELESS),
    ("301/sdo/block-upload/next-request", Fail, NAMELESS),
    ("301/sdo/transfer/block-combinations", Fail, NAMELESS),
    ("301/sync/object", Fail, "1005h is missing, although TPDO 2 is synchronous"),
    ("301/sdo/block-upload/crc", Fail, NAMELESS),
    ("301/sdo/block-upload/lengths", Fail, NAMELESS),
    ("301/sdo/block-upload/too-much-confirmed", Fail, "segments may be confirmed that were never sent"),
    ("301/sdo/block-upload/wrong-block-size", Fail, BLOCK_SIZE),
    ("301/sdo/block-upload/wrong-next-size", Fail, BLOCK_SIZE),
    ("301/sdo/command/unknown", Fail, UNKNOWN),
    ("301/sdo/command/unknown-first", Fail, UNKNOWN),
    ("301/sdo/download/confirmation-toggle", Fail, "every segment but the last is taken for 7 bytes"),
    ("301/boot-up/running-download", Fail, ANSWERED_ABORT),
    ("301/sdo/block-download/wrong-crc", Fail, ANSWERED_ABORT),
    ("301/sdo/transfer/abandoned-download", Fail, BUSY),
    ("301/sdo/transfer/block-pairs", Inconclusive, BUSY),
    ("301/sdo/transfer/pairs", Fail, BUSY),
    ("301/sdo/transfer/restart", Fail, BUSY),
    ("301/store/start", Inconclusive, SIGNATURE),
    ("301/state/stopped/running-upload", Fail, "SDOs are answered in stopped"),
    ("301/state/stopped/sdo", Fail, "SDOs are answered in stopped"),
    ("301/store/wrong-signature", Fail, SIGNATURE),
    ("301/store/operational", Fail, SIGNATURE),
    ("301/store/persists", Inconclusive, SIGNATURE),
    ("301/store/every-capability", Inconclusive, NONE_COUNTED),
    ("301/store/every-signature", Inconclusive, NONE_COUNTED),
    ("305/fastscan/out-of-range", Fail, "bit check 32 is a panic"),
    ("305/identify/at-bounds", Fail, IDENTIFY),
    ("305/identify/halving", Fail, IDENTIFY),
    ("305/identify/within", Fail, IDENTIFY),
    ("305/identify/outside", Inconclusive, IDENTIFY),
    ("305/unconfigured/identify", Fail, "the search for slaves without node-ID (4Ch) is not answered"),
    ("305/unconfigured/silent", Fail, "a node without node-ID still answers SDOs at its old one"),
    ("305/node-id/inquired-pending", Fail, NODE_ID),
    ("305/node-id/not-stored", Fail, "reset node keeps a node-ID that was not stored"),
    ("305/node-id/pending", Fail, NODE_ID),
    ("305/node-id/invalid", Fail, "node-IDs 0 and 128 to 254 are taken"),
    ("305/switch-selective/order", Fail, "the parts of the address may come in any order"),
];

const BOOT_UP: &str = "the first message is 7Fh, not the boot-up message";
const LATE: &str = "the start of the transfer is confirmed, and only its end refused";
const REPEATED: &str = "what is sent again after a lost segment goes to the wrong place";
const NAMELESS: &str = "an abort in a block upload names object 0000h:00";
const CRC: &str = "the CRC counts what is sent again";
const BLOCK_SIZE: &str = "block sizes 0 and above 127 are taken";
const UNKNOWN: &str = "unknown command specifiers are not answered";
const ANSWERED_ABORT: &str = "an abort without a transfer is answered by an abort, which names 0000h:00";
const BUSY: &str = "a new transfer is refused while another one is open";
const SIGNATURE: &str = "the signature of 1010h is expected the wrong way round";
const NONE_COUNTED: &str = "sub-index 0 of 1010h counts no sub-index";
const IDENTIFY: &str = "identify remote slave (46h to 4Bh) is not answered";
const NODE_ID: &str = "a new node-ID is in force at once";

fn peer() -> Peer {
    Peer::new(Zencan::new(), EDS, NODE)
}

#[test]
fn fails_what_is_documented() {
    let outcome = judge(peer(), true, "");
    expect(&outcome, EXPECTED, &PDO_PARAMETERS_UNCHECKED);
    assert!(passed(&outcome) >= 153, "{} passed", passed(&outcome));
    assert_eq!(outcome.notices, Vec::<String>::new());
    let deaths: Vec<_> = outcome.memorial.deaths().into_iter().map(|death| death.reason).collect();
    assert_eq!(deaths, ["attempt to shift left with overflow"]);
}

fn half(begin: &str) -> Outcome {
    judge(peer(), true, begin)
}

#[test]
fn runs_the_same_each_time() {
    for begin in ["301/sdo/", "305/"] {
        assert_eq!(trace(&half(begin)), trace(&half(begin)), "{begin}");
    }
}
