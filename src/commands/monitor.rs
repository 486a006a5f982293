//! `canvass monitor`: decodes a live bus.

#[cfg(feature = "screen")]
mod screen;

use super::decode::View;
use crate::inputs::{InputOptions, Inputs};
use crate::interrupt::Interrupt;
use crate::live::{open_bus, parse_span};
use crate::live_reader::LiveReader;
use crate::output::{Color, Output, diagnostic};
use crate::reconnect::status_of_listener;
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_traces::Duration;
#[cfg(feature = "screen")]
use canvass_traces::Timestamp;

/// Decode a live bus: one annotated line per frame, or one per event
///
/// Takes the options of `canvass decode`. Receiving does not wait for the terminal. Lost frames are reported at their
/// place, and their total at the end. After an interruption of the bus, monitoring goes on when the bus is back; the
/// exit status is 3 if it does not come back. Ends by Ctrl-C or --for.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// Fill the terminal: nodes with states, rates and last values; CAN-IDs with cycles and data, changes marked
    #[cfg(feature = "screen")]
    #[arg(long)]
    screen: bool,
    /// End after this time, such as 10, 500ms or 1h
    #[arg(long = "for", value_name = "SPAN", value_parser = parse_span)]
    span: Option<Duration>,
    #[command(flatten)]
    view: View,
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let bus = open_bus(&self.bus, 0)?.bus;
        if !bus.is_live() && self.span.is_none() {
            return Err(anyhow!("on a simulated bus time is virtual: set the duration with --for").into());
        }
        let (output, interrupt) = (Output::text(color.on_stdout()), Interrupt::watch()?);
        #[cfg(feature = "screen")]
        if self.screen {
            let mut bus = bus;
            let end = self.span.map_or(Timestamp::MAX, |span| bus.now() + span);
            let shown = screen::show(bus.as_mut(), &mut self.view.network()?, &self.bus, end, &interrupt);
            // The screen has hidden the messages of the bus; they are repeated here.
            crate::live::report_health(bus.as_ref());
            shown?;
            let interruptions = crate::reconnect::interruptions(bus.as_ref());
            return Ok(status_of_listener(&self.bus, interruptions.as_ref(), Status::Good));
        }
        let reader = LiveReader::new(&self.bus, bus, self.span, &output, &interrupt);
        let interruptions = reader.interruptions();
        let options = InputOptions::default();
        let inputs = Inputs::live(reader.capture(&self.bus), &options, &output, interrupt);
        let network = self.view.network()?;
        let status = self.view.show(inputs, network, color, &output)?;
        let interruptions = interruptions.take();
        interruptions.iter().for_each(|interruptions| diagnostic(&format!("canvass: {interruptions}")));
        Ok(status_of_listener(&self.bus, interruptions.as_ref(), status))
    }
}
