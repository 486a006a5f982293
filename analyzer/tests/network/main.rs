//! The knowledge of a network about its nodes, and the events that frames cause.

#[cfg(test)]
mod blocks;
#[cfg(test)]
mod channels;
#[cfg(test)]
mod described;
#[cfg(test)]
mod devices;
#[cfg(test)]
mod dialogues;
#[cfg(test)]
mod events;
#[cfg(test)]
mod kept;
#[cfg(test)]
mod layer_setting;
#[cfg(test)]
mod learned;
#[cfg(test)]
mod mapped;
#[cfg(test)]
mod places;
#[cfg(test)]
mod scaling;
#[cfg(test)]
mod services;
#[cfg(test)]
mod steady;
#[cfg(test)]
#[path = "../trace/mod.rs"]
mod trace;
#[cfg(test)]
mod transfers;

#[cfg(test)]
use {
    canvass_analyzer::{NodeId, network::Event},
    canvass_traces::ChannelId,
    trace::Trace,
};

#[cfg(test)]
fn node(raw: u8) -> NodeId {
    NodeId::new(raw).unwrap()
}

/// The events that the frame causes.
#[cfg(test)]
fn events(trace: &mut Trace, frame: &str) -> Vec<Event> {
    trace.say(frame);
    trace.network.bus(ChannelId(0)).unwrap().events().to_vec()
}

/// Node 63 shows its identity by SDO, and is then selected by its LSS address.
#[cfg(test)]
fn select_node_63(trace: &mut Trace) {
    const IDENTITY: [&str; 4] = ["13", "F1", "66", "A5"];
    for (sub, value) in (1..).zip(IDENTITY) {
        trace.say(&format!("63F#40 18 10 0{sub} 00 00 00 00"));
        trace.say(&format!("5BF#43 18 10 0{sub} {value} 00 00 00"));
    }
    for (command, value) in (0x40..).zip(IDENTITY) {
        trace.say(&format!("7E5#{command:02X} {value} 00 00 00 00 00 00"));
    }
}
