//! `canvass decode --events`: events instead of frames.

use crate::inputs::Inputs;
use crate::output::{Color, Output};
use crate::selection::Selection;
use crate::status::Failure;
use crate::time_range::TimeRange;
use canvass_analyzer::network::Network;
use canvass_reports::decode::TimeStyle;
use canvass_reports::events::{Events, JsonEvents, Scene, TextEvents};
use canvass_traces::{ChannelId, Timestamp};

/// One aligned line per event.
pub fn text(time: TimeStyle, color: Color) -> Box<dyn Events> {
    Box::new(TextEvents::new(time, color.on_stdout()))
}

/// One JSON object per event.
pub fn json() -> Box<dyn Events> {
    Box::new(JsonEvents::new())
}

/// Prints the selected events of the captures. Without a filter, the transfers that did not end follow.
pub fn show(
    inputs: &mut Inputs<'_>,
    network: &mut Network,
    mut range: TimeRange,
    selection: &Selection,
    events: &mut dyn Events,
    output: &Output,
) -> Result<(), Failure> {
    let (mut last, mut comment) = (None, String::new());
    while inputs.advance()?.is_some() {
        let record = inputs.record();
        if let Some(latest) = record.comment() {
            comment.clear();
            comment.push_str(latest);
        }
        let decoded = network.handle(record);
        if !range.contains(record.timestamp) || !selection.has_channel(record, inputs) {
            continue;
        }
        last = Some(record.timestamp);
        let Some(bus) = network.bus(record.channel) else { continue };
        if bus.events().is_empty() || !selection.passes(record, &decoded, inputs) {
            continue;
        }
        let channel = inputs.channels().name(record.channel);
        let scene = Scene { time: record.timestamp, channel, bus, frame: Some((record, &decoded)) };
        for event in bus.events().iter().filter(|event| selection.has_node(scene.node(event))) {
            if !comment.is_empty() {
                output.append(|buffer| events.comment(&scene, &comment, buffer))?;
                comment.clear();
            }
            output.append(|buffer| events.event(&scene, event, buffer))?;
        }
    }
    // Filters select frames; an event at the end of the capture belongs to no frame.
    match last {
        Some(last) if !selection.has_filter() => show_open(inputs, network, last, selection, events, output),
        _ => Ok(()),
    }
}

fn show_open(
    inputs: &Inputs<'_>,
    network: &Network,
    time: Timestamp,
    selection: &Selection,
    events: &mut dyn Events,
    output: &Output,
) -> Result<(), Failure> {
    for (id, channel) in (0_u16..).zip(inputs.channels().names()) {
        let Some(bus) = network.bus(ChannelId(id)) else { continue };
        if !selection.has_channel_id(ChannelId(id), inputs) {
            continue;
        }
        let scene = Scene { time, channel, bus, frame: None };
        for (server, transfer) in bus.open_transfers().filter(|(server, _)| selection.has_node(Some(*server))) {
            output.append(|buffer| events.open_transfer(&scene, server, transfer, buffer))?;
        }
    }
    Ok(())
}
