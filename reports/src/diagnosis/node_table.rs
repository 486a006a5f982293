//! The figures of each node: the table on the terminal and in Markdown.

use super::Diagnosed;
use crate::escape::printable;
use canvass_analyzer::NodeId;
use canvass_analyzer::statistics::{BusStatistics, NodeStatistics};
use canvass_traces::Duration;

/// The head of the table and its rows. Nodes that never sent a frame come last, if they are wanted. Empty if there are
/// no nodes.
pub fn rows(diagnosed: &Diagnosed<'_>, with_silent: bool) -> Vec<Vec<String>> {
    let buses = &diagnosed.results.buses;
    let several = buses.len() > 1;
    let mut rows = Vec::new();
    for (channel, bus) in buses {
        let seen = bus.nodes.iter().filter(|(_, node)| node.total() > 0);
        let (present, silent): (Vec<_>, Vec<_>) = seen.partition(|(_, node)| node.present);
        for (id, node) in present.into_iter().chain(silent.into_iter().filter(|_| with_silent)) {
            let mut row = of_node(*id, node, bus);
            if several {
                row.insert(0, printable(&diagnosed.channel(*channel)).into_owned());
            }
            rows.push(row);
        }
    }
    if rows.is_empty() {
        return rows;
    }
    let mut head: Vec<String> = HEAD.iter().map(|&name| name.to_owned()).collect();
    if several {
        head.insert(0, "channel".to_owned());
    }
    rows.insert(0, head);
    rows
}

const HEAD: [&str; 9] = [
    "node",
    "who",
    "frames",
    "load/peak %",
    "last state",
    "boots",
    "EMCY",
    "SDO done/aborted",
    "response p50/p95/p99/max",
];

fn of_node(id: NodeId, node: &NodeStatistics, bus: &BusStatistics) -> Vec<String> {
    let state = node.states.last().map(|change| change.state.to_string());
    let emcy: u64 = node.emcy.iter().filter(|row| !row.code.is_reset()).map(|row| row.count).sum();
    let times = &node.responses;
    // In a capture without time stamps all times are zero.
    let shown = [times.quantile(50), times.quantile(95), times.quantile(99), times.max()];
    let response = match times.max() {
        Some(max) if max > Duration::ZERO => {
            joined(&shown.into_iter().flatten().map(|time| rounded(time).to_string()).collect::<Vec<_>>())
        }
        _ => String::new(),
    };
    let peak = bus.bit_rate.and_then(|bit_rate| node.peak.percent(bit_rate));
    let load = match (bus.share_of_load(node.bits), peak) {
        (Some(mean), Some((_, peak))) => format!("{mean:.1} / {peak:.1}"),
        _ => String::new(),
    };
    vec![
        id.to_string(),
        printable(&who(node)).into_owned(),
        node.total().to_string(),
        load,
        state.unwrap_or_default(),
        node.boot_ups.to_string(),
        emcy.to_string(),
        format!("{}/{}", node.completed, node.aborted),
        response,
    ]
}

/// The device profile of a node, if its device type (1000h) was read.
pub fn profile(node: &NodeStatistics) -> Option<u16> {
    node.identity.device_type.map(|device| device as u16)
}

/// The identity of a node, as far as it was read.
pub fn who(node: &NodeStatistics) -> String {
    let identity = &node.identity;
    let [vendor, product, _, serial] = identity.numbers;
    let mut parts: Vec<String> = identity.names[0].iter().cloned().collect();
    parts.extend(identity.names[2].iter().map(|version| format!("software {version}")));
    parts.extend(vendor.map(|vendor| format!("vendor {vendor:X}h")));
    parts.extend(product.map(|product| format!("product {product:X}h")));
    parts.extend(serial.map(|serial| format!("serial {serial:X}h")));
    if parts.is_empty() {
        parts.extend(profile(node).map(|profile| format!("profile {profile}")));
    }
    if !node.present {
        parts.push("never sent anything".to_owned());
    }
    parts.join(", ")
}

/// The nodes of each bus that were addressed and never sent a frame. If there are several buses, the name of the bus
/// precedes its nodes: `can1: `.
pub fn silent(diagnosed: &Diagnosed<'_>) -> Vec<(String, Vec<NodeId>)> {
    let buses = &diagnosed.results.buses;
    let several = buses.len() > 1;
    let of_bus = |(channel, bus): &(_, BusStatistics)| {
        let name = if several { format!("{}: ", diagnosed.channel(*channel)) } else { String::new() };
        let silent = bus.nodes.iter().filter(|(_, node)| node.total() > 0 && !node.present);
        (name, silent.map(|(id, _)| *id).collect())
    };
    buses.iter().map(of_bus).collect()
}

/// Node-IDs in ascending order as ranges: `1 to 3, 7`.
pub fn ranges(nodes: &[NodeId]) -> String {
    let mut ranges: Vec<(u8, u8)> = Vec::new();
    for node in nodes.iter().map(|node| node.raw()) {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == node => *last = node,
            _ => ranges.push((node, node)),
        }
    }
    let text = |&(first, last): &(u8, u8)| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        _ => format!("{first} to {last}"),
    };
    ranges.iter().map(text).collect::<Vec<_>>().join(", ")
}

/// Several times in one text: `507 / 884 / 899 / 899 µs`. A common unit is written once.
fn joined(times: &[String]) -> String {
    let unit = times.last().and_then(|last| last.split_once(' ')).map(|(_, unit)| format!(" {unit}"));
    let bare: Option<Vec<&str>> =
        unit.as_ref().and_then(|unit| times.iter().map(|time| time.strip_suffix(unit)).collect());
    match (bare, unit) {
        (Some(bare), Some(unit)) => format!("{}{unit}", bare.join(" / ")),
        _ => times.join(" / "),
    }
}

/// A time rounded to three digits, as percentiles need no more.
pub fn rounded(time: Duration) -> Duration {
    let unit = match time.nanos() {
        0..1_000_000 => 1_000,
        1_000_000..1_000_000_000 => 10_000,
        _ => 1_000_000,
    };
    Duration(time.nanos() / unit * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_that_follow_each_other_are_a_range() {
        let shown = |nodes: &[u8]| ranges(&nodes.iter().filter_map(|raw| NodeId::new(*raw)).collect::<Vec<_>>());
        assert_eq!(shown(&[]), "");
        assert_eq!(shown(&[5]), "5");
        assert_eq!(shown(&[1, 2, 4, 126, 127]), "1, 2, 4, 126, 127");
        assert_eq!(shown(&[1, 2, 3, 5, 6, 7, 8]), "1 to 3, 5 to 8");
    }
}
