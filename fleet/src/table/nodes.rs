//! `nodes`: the nodes on the bus, and their statistics.

use super::column::{Column, Rows, write_str};
use canvass_analyzer::statistics::{BusStatistics, NodeStatistics};
use canvass_analyzer::{NodeId, Service};
use canvass_tables::columns;

/// The rows of `nodes`.
pub struct Nodes;

/// A node of a capture.
pub struct NodeRow<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The channel's name.
    pub channel: &'a str,
    /// The node.
    pub id: NodeId,
    /// The statistics of the node.
    pub node: &'a NodeStatistics,
    /// The statistics of its bus.
    pub bus: &'a BusStatistics,
}

impl Rows for Nodes {
    type Row<'a> = NodeRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "capture" name "the file" = |row, out| write_str(out, Some(row.capture));
        "channel" name "the channel's name" = |row, out| write_str(out, Some(row.channel));
        "node" u8 "the node" = |row| Some(u64::from(row.id.raw()));
        "present" flag "whether it has sent anything itself; else it was only addressed" = |row| Some(row.node.present);
        "t" time "its first frame, or the first to it" = |row| Some(row.node.first);
        "t_last" time "the last one" = |row| Some(row.node.last);
        "device_type" u32 "1000h, as it was read" = |row| row.node.identity.device_type.map(u64::from);
        "vendor_id" u32 "1018h:01" = |row| row.number(0);
        "product_code" u32 "1018h:02" = |row| row.number(1);
        "revision_number" u32 "1018h:03" = |row| row.number(2);
        "serial_number" u32 "1018h:04" = |row| row.number(3);
        "name" name "1008h" = |row, out| write_str(out, row.text(0));
        "hardware_version" name "1009h" = |row, out| write_str(out, row.text(1));
        "software_version" name "100Ah" = |row, out| write_str(out, row.text(2));
        "frames" u64 "its frames, and those to it" = |row| Some(row.node.total());
        "heartbeats" u64 "of these the heartbeats" = |row| row.of(Service::Heartbeat);
        "emcys" u64 "of these the EMCY messages, those that clear errors too" = |row| row.of(Service::Emcy);
        "pdos" u64 "of these the PDOs" = |row| row.of(Service::Pdo);
        "bits" u64 "the bits of these frames on the bus" = |row| Some(row.node.bits);
        "load_percent" f64 "the bus load that they make, where the bit rate is known" = |row| row.bus.share_of_load(row.node.bits);
        "boot_ups" u64 "its boot-ups" = |row| Some(row.node.boot_ups);
        "errors" u64 "errors from the first EMCY to their end" = |row| Some(row.node.errors.len() as u64 + row.node.errors_omitted);
        "sdo_completed" u64 "SDO transfers that were completed" = |row| Some(row.node.completed);
        "sdo_aborted" u64 "SDO transfers that were aborted" = |row| Some(row.node.aborted);
        "sdo_responses" u64 "answers of its SDO servers whose time is known" = |row| Some(row.node.responses.count());
        "sdo_response_min_ns" i64 "the quickest of them" = |row| row.node.responses.min().map(|time| time.nanos() as i64);
        "sdo_response_p50_ns" i64 "half are not slower" = |row| row.quantile(50);
        "sdo_response_p95_ns" i64 "95 of 100 are not slower" = |row| row.quantile(95);
        "sdo_response_p99_ns" i64 "99 of 100 are not slower" = |row| row.quantile(99);
        "sdo_response_max_ns" i64 "the slowest" = |row| row.node.responses.max().map(|time| time.nanos() as i64);
    ];
}

impl NodeRow<'_> {
    fn number(&self, at: usize) -> Option<u64> {
        self.node.identity.numbers.get(at).copied().flatten().map(u64::from)
    }

    fn text(&self, at: usize) -> Option<&str> {
        self.node.identity.names.get(at).and_then(Option::as_deref)
    }

    fn of(&self, service: Service) -> Option<u64> {
        self.node.frames.get(service as usize).copied()
    }

    fn quantile(&self, percent: u64) -> Option<i64> {
        self.node.responses.quantile(percent).map(|time| time.nanos() as i64)
    }
}
