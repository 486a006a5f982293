//! The mutated files, and the name under which each is counted.

/// The files of the simulated devices, by service. Files that are missing here are no firmware: faults and liberties,
/// files of models, the motion of the measured quantity, addresses.
pub const DEVICE: [(&str, &str); 34] = [
    ("device/sdo_server/", "SDO"),
    ("device/sdo_channels.rs", "SDO"),
    ("device/parameters.rs", "dictionary"),
    ("device/objects.rs", "dictionary"),
    ("device/checks.rs", "dictionary"),
    ("device/links.rs", "dictionary"),
    ("device/store.rs", "store"),
    ("device/storing.rs", "store"),
    ("device/nmt.rs", "NMT"),
    ("device/lifecycle.rs", "NMT"),
    ("device/dispatch.rs", "NMT"),
    ("device/routes.rs", "NMT"),
    ("device/context.rs", "NMT"),
    ("device/heartbeat.rs", "error control"),
    ("device/heartbeat_consumer.rs", "error control"),
    ("device/guarding.rs", "error control"),
    ("device/emcy.rs", "EMCY"),
    ("device/errors.rs", "EMCY"),
    ("device/condition.rs", "EMCY"),
    ("device/sync.rs", "SYNC"),
    ("device/time.rs", "TIME"),
    ("device/clock.rs", "TIME"),
    ("device/pdo.rs", "PDO"),
    ("device/rpdo.rs", "PDO"),
    ("device/tpdo.rs", "PDO"),
    ("device/lss_slave.rs", "LSS"),
    ("device/bit_rate.rs", "LSS"),
    ("device/lmt_slave.rs", "LMT"),
    ("device/application.rs", "EMCY"),
    ("device/mod.rs", "NMT"),
    ("device/services.rs", "NMT"),
    ("device/service.rs", "NMT"),
    ("device/own_traffic.rs", "NMT"),
    ("profiles/", "profiles"),
];

/// The parsers of frames, and the state of the network.
pub const ANALYZER: [(&str, &str); 2] = [("wire/", "wire"), ("network/", "network")];

/// The base of the cases, and the code that runs and judges them.
pub const SUITE: [(&str, &str); 9] = [
    ("bench/", "bench"),
    ("cases/cia301/needs/", "needs"),
    ("profiles/cia406/needs.rs", "needs"),
    ("needs.rs", "needs"),
    ("runner/", "runner"),
    ("verdict/", "verdict"),
    ("situation.rs", "verdict"),
    ("waiver.rs", "verdict"),
    ("comparison.rs", "verdict"),
];

/// Files in these folders that contain only tests.
pub const TESTS: [&str; 5] =
    ["bench/tests/", "cases/cia301/needs/tests.rs", "runner/counts.rs", "runner/left_behind.rs", "runner/tests.rs"];
