//! Which files of the simulated devices are mutated, and which service each belongs to.
//!
//! What is not here is no firmware: faults and liberties, the models' files, the motion of the shaft, addresses.

/// Files below `conformance/device/src/device`, or folders, each with its service; the order is that of the table.
pub const COVERED: [(&str, &str); 35] = [
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

/// The service of a file, by its path below the folder of the device; `None`: it is left as it is.
pub fn service(path: &str) -> Option<&'static str> {
    let is = |pattern: &str| path == pattern || pattern.ends_with('/') && path.starts_with(pattern);
    COVERED.iter().find(|(pattern, _)| is(pattern)).map(|(_, service)| *service)
}

/// All services, in the order of the table.
pub fn services() -> Vec<&'static str> {
    let mut services: Vec<&str> = Vec::new();
    for (_, service) in COVERED {
        if !services.contains(&service) {
            services.push(service);
        }
    }
    services
}
