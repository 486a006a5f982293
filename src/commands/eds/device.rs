//! Options for commands that read a device.

use crate::commands::test::which_node;
use crate::devices::parse_node;
use crate::interrupt::Interrupt;
use crate::live::{ClientArg, Live, parse_span};
use crate::output::{diagnostic, is_seen, show_progress};
use crate::reconnect::ReconnectArg;
use crate::status::Failure;
use crate::upload_limit::{UploadLimitArgs, told};
use canvass_analyzer::dictionary::survey::Survey;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::PatientBus;
use canvass_bus::client::{Exchange, SurveyError, Surveyor, UploadLimit};
use canvass_reports::escape::Printable;
use canvass_traces::{Duration, Record, Timestamp};
use std::time::Instant;

/// A device on a bus, as typed.
#[derive(clap::Args)]
pub struct DeviceArgs {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    pub bus: String,
    /// The device's node-ID (default: that of the simulated device)
    #[arg(long, value_parser = parse_node)]
    pub node: Option<NodeId>,
    /// How long to wait for each response, such as 500ms
    #[arg(long, default_value = "1s", value_name = "SPAN", value_parser = parse_span)]
    timeout: Duration,
    #[command(flatten)]
    limit: UploadLimitArgs,
    #[command(flatten)]
    client: ClientArg,
    #[command(flatten)]
    reconnect: ReconnectArg,
}

/// A device on an open bus.
pub struct Opened {
    live: Live,
    /// The device's node-ID.
    pub node: NodeId,
    patience: Duration,
    limit: UploadLimit,
    reconnect: ReconnectArg,
}

/// The result of reading a device.
pub struct Surveyed<T> {
    pub survey: Survey,
    /// The result of the survey, or the error that ended it.
    pub done: Result<T, SurveyError>,
    /// The first entry that was not read, if the survey ended early.
    pub unread: Option<Multiplexer>,
}

impl DeviceArgs {
    /// Opens the bus; `usual` is the node-ID of a real device if `--node` is not given.
    pub fn open(&self, usual: Option<NodeId>) -> Result<Opened, Failure> {
        let mut live = Live::open(&self.bus, self.node, &[], self.client)?;
        let node = self.node.or(live.simulated_node()).or(usual).ok_or_else(|| which_node(&self.bus, live.model))?;
        let id = u16::from(node.raw());
        // The bus filter admits only the two COB-IDs of this SDO server, so that a busy bus does not overflow the
        // queue.
        live.bus.only(&[(0x580 + id, 0x7FF), (0x600 + id, 0x7FF)]).map_err(Failure::unreachable)?;
        let limit = self.limit.or(UploadLimit::OF_MANY);
        Ok(Opened { live, node, patience: self.timeout, limit, reconnect: self.reconnect })
    }
}

impl Opened {
    /// The bit rate of the bus in kbit/s, if it is known.
    pub fn bit_rate(&self) -> Option<u16> {
        self.live.bus.bit_rate().and_then(|rate| u16::try_from(rate / 1_000).ok())
    }

    /// Runs `read` on the device. Ctrl-C ends it. Incomplete uploads are reported.
    pub fn survey<T>(
        &mut self,
        read: impl FnOnce(&mut Surveyor<'_, '_>) -> Result<T, SurveyError>,
    ) -> Result<Surveyed<T>, Failure> {
        let interrupt = Interrupt::watch()?;
        let mut observe = |_: &Record| {};
        let mut bus = PatientBus::new(self.live.bus.as_mut(), self.reconnect.endurance(&interrupt));
        let mut exchange = Exchange { bus: &mut bus, observe: &mut observe, ends: Timestamp::MAX };
        let mut reading = Reading::begin(self.node);
        let mut watch = |at: Multiplexer| {
            reading.show(at);
            !interrupt.came()
        };
        let mut surveyor = Surveyor::new(&mut exchange, self.node, self.patience, &mut watch).within(self.limit);
        let done = read(&mut surveyor);
        let unread = surveyor.unread();
        let (survey, excesses) = surveyor.into_survey();
        reading.end();
        self.live.report_health();
        excesses.iter().for_each(|(at, excess)| diagnostic(&format!("canvass: {at}: {}", told(excess))));
        Ok(Surveyed { survey, done, unread })
    }
}

/// The line that shows which entry of a device is being read.
pub struct Reading {
    node: NodeId,
    shown: Instant,
}

/// Interval between two updates of the line.
const PAUSE: std::time::Duration = std::time::Duration::from_millis(200);

impl Reading {
    /// Nothing is shown during the first interval: most devices are read in less.
    pub fn begin(node: NodeId) -> Self {
        Self { node, shown: Instant::now() }
    }

    /// Shows the entry, if the last one has been shown for a while.
    pub fn show(&mut self, at: Multiplexer) {
        if is_seen() && self.shown.elapsed() >= PAUSE {
            self.shown = Instant::now();
            show_progress(&Printable::line(&format!("canvass: node {}: reading {at}", self.node)));
        }
    }

    /// Clears the line.
    pub fn end(self) {
        if is_seen() {
            show_progress(&Printable::line(""));
        }
    }
}
