//! The mutated files, and the name under which each is counted.

/// The simulated devices, by service. Files that are not here are no firmware: faults and liberties, files of models,
/// the motion of the shaft, addresses.
pub const DEVICE: [(&str, &str); 35] = [
    ("sdo_server/", "SDO"),
    ("sdo_channels.rs", "SDO"),
    ("parameters.rs", "dictionary"),
    ("objects.rs", "dictionary"),
    ("checks.rs", "dictionary"),
    ("links.rs", "dictionary"),
    ("store.rs", "store"),
    ("storing.rs", "store"),
    ("nmt.rs", "NMT"),
    ("lifecycle.rs", "NMT"),
    ("dispatch.rs", "NMT"),
    ("routes.rs", "NMT"),
    ("context.rs", "NMT"),
    ("heartbeat.rs", "error control"),
    ("heartbeat_consumer.rs", "error control"),
    ("guarding.rs", "error control"),
    ("emcy.rs", "EMCY"),
    ("errors.rs", "EMCY"),
    ("condition.rs", "EMCY"),
    ("sync.rs", "SYNC"),
    ("time.rs", "TIME"),
    ("clock.rs", "TIME"),
    ("pdo.rs", "PDO"),
    ("rpdo.rs", "PDO"),
    ("tpdo.rs", "PDO"),
    ("lss_slave.rs", "LSS"),
    ("bit_rate.rs", "LSS"),
    ("lmt_slave.rs", "LMT"),
    ("encoder/", "encoder"),
    ("limit_switches.rs", "encoder"),
    ("shaft.rs", "encoder"),
    ("mod.rs", "NMT"),
    ("services.rs", "NMT"),
    ("service.rs", "NMT"),
    ("own_traffic.rs", "NMT"),
];

/// The parsers of frames, and the state of the network.
pub const ANALYZER: [(&str, &str); 2] = [("wire/", "wire"), ("network/", "network")];

/// The base of the cases, and the code that runs and judges them.
pub const SUITE: [(&str, &str); 9] = [
    ("bench/", "bench"),
    ("cases/cia301/needs/", "needs"),
    ("cases/cia406/needs.rs", "needs"),
    ("needs.rs", "needs"),
    ("runner/", "runner"),
    ("verdict/", "verdict"),
    ("situation.rs", "verdict"),
    ("waiver.rs", "verdict"),
    ("comparison.rs", "verdict"),
];

/// Files below those folders that contain only tests.
pub const TESTS: [&str; 5] =
    ["bench/tests/", "cases/cia301/needs/tests.rs", "runner/counts.rs", "runner/left_behind.rs", "runner/tests.rs"];
