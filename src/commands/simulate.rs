//! `canvass simulate`: a simulated device on a live bus.

use crate::devices::parse_node;
use crate::files::Files;
use crate::interrupt::Interrupt;
use crate::kept_device::KeptDevice;
use crate::live::{open_bus, parse_span};
use crate::output::diagnostic;
use crate::status::{Failure, Status};
use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::NodeId;
use canvass_bus::Machine;
use canvass_bus::{Bus, participate};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Firmware, Liberty, Motion, MotionSpec};
use canvass_traces::small_file::{self, OF_HAND};
use canvass_traces::{Direction, Duration, Timestamp};
use std::path::{Path, PathBuf};

/// Simulate a device on a bus, in real time
///
/// The device takes part in the bus: it boots, answers, and sends heartbeats and PDOs, until Ctrl-C.
/// slcan:listen://PORT waits for programs on this machine, slcan:listen://HOST:PORT also for those on other machines.
/// The protocol has no passwords: anyone who connects can read and send frames.
#[derive(clap::Args)]
pub struct Args {
    /// The device: a built-in model, or a device description (EDS, DCF, XDD, XDC)
    #[arg(value_name = "MODEL|FILE")]
    device: String,
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The device's node-ID, or none to start without node-ID, for LSS (default: that of the model or DCF)
    #[arg(long, value_name = "NODE|none", value_parser = parse_configured)]
    node: Option<Configured>,
    /// Faults of the firmware (`canvass list faults`)
    #[arg(long, value_delimiter = ',', value_name = "FAULT")]
    fault: Vec<Fault>,
    /// Liberties: unusual behaviour that the standard allows (`canvass list liberties`)
    #[arg(long, value_delimiter = ',', value_name = "LIBERTY")]
    liberty: Vec<Liberty>,
    /// Motion of the shaft: revolutions per minute, or still, mm/s=N, sine=AMPLITUDE,PERIOD, ramp=RPM,SECONDS,
    /// csv=FILE
    #[arg(long, value_name = "MOTION", allow_hyphen_values = true, value_parser = parse_motion)]
    motion: Option<MotionSpec>,
    /// The file that holds the device's non-volatile memory; read at the start if it exists
    #[arg(long, value_name = "FILE")]
    memory: Option<PathBuf>,
    /// The seed of all random choices
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Switch the device off after this time, such as 10, 500ms or 1h
    #[arg(long = "for", value_name = "SPAN", value_parser = parse_span)]
    span: Option<Duration>,
}

#[derive(Clone, Copy)]
struct Configured(Option<NodeId>);

fn parse_configured(text: &str) -> Result<Configured> {
    if text == "none" { Ok(Configured(None)) } else { parse_node(text).map(Some).map(Configured) }
}

/// Parses a motion; a plain number is revolutions per minute.
fn parse_motion(text: &str) -> Result<MotionSpec> {
    let number = text.strip_suffix("rpm").unwrap_or(text).trim_end();
    match number.parse::<f64>() {
        Ok(_) => Ok(format!("rpm={number}").parse()?),
        Err(_) => Ok(text.parse()?),
    }
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let motion = match &self.motion {
            Some(MotionSpec::File(path)) => Some(path),
            _ => None,
        };
        let files = Files::new().bus(&self.bus).describes([&*self.device]).reads(motion);
        files.writes(&self.memory)?;
        let model = model(&self.device)?;
        let node = self.node.map_or(model.default_node(), |node| node.0);
        let firmware = Firmware {
            faults: self.fault.iter().copied().collect(),
            liberties: self.liberty.iter().copied().collect(),
        };
        let mut bus = open_bus(&self.bus, self.seed)?.bus;
        if !bus.is_live() && self.span.is_none() {
            return Err(anyhow!("on a simulated bus time is virtual: set the duration with --for").into());
        }
        if firmware.liberties.has(Liberty::DirtyPadding) {
            bus.dirty_padding();
        }
        let device = match self.motion()? {
            Some(motion) => Device::with_motion(&model, node, firmware, self.seed, &motion),
            None => Device::new(&model, node, firmware, self.seed),
        };
        let mut device = KeptDevice::new(device, self.memory.as_deref())?;
        // The stored node-ID may differ from the typed node-ID.
        let node = device.node();
        let name = node.map_or_else(|| "without node-ID".to_owned(), |node| format!("as node {node}"));
        diagnostic(&format!("canvass: {} {name} on {}", model.id(), self.bus));
        let status = self.take_part(bus.as_mut(), &mut device)?;
        device.keep()?;
        Ok(status)
    }

    fn motion(&self) -> Result<Option<Motion>> {
        Ok(match &self.motion {
            None => None,
            Some(MotionSpec::Known(motion)) => Some(motion.clone()),
            Some(MotionSpec::File(path)) => {
                let text =
                    small_file::read_text(Path::new(path), OF_HAND).with_context(|| format!("can't read {path}"))?;
                Some(MotionSpec::from_csv(&text).with_context(|| format!("{path} describes no motion"))?)
            }
        })
    }

    fn take_part(&self, bus: &mut dyn Bus, device: &mut dyn Machine) -> Result<Status, Failure> {
        let interrupt = Interrupt::watch()?;
        let end = self.span.map_or(Timestamp::MAX, |span| Timestamp::ZERO + span);
        let (mut received, mut told) = (0_u64, None);
        let done = participate(
            bus,
            device,
            &mut |done, now| {
                if told != done.trouble {
                    told.clone_from(&done.trouble);
                    diagnostic(&format!("canvass: {}", done.trouble.as_deref().unwrap_or_default()));
                }
                !interrupt.came() && now < end
            },
            &mut |record| received += u64::from(record.direction != Direction::Tx),
        )
        .map_err(Failure::unreachable)?;
        let health = bus.health();
        let unsent = if done.unsent > 0 { format!(", {} not accepted by the bus", done.unsent) } else { String::new() };
        let lost = if health.lost > 0 { format!(", {} lost", health.lost) } else { String::new() };
        let plural = if done.sent == 1 { "" } else { "s" };
        diagnostic(&format!("canvass: {} frame{plural} sent{unsent}, {received} received{lost}", done.sent));
        Ok(Status::Good)
    }
}

/// A built-in model, or a model made from a description alone.
fn model(device: &str) -> Result<Model> {
    if let Some(model) = Model::by_id(device) {
        return Ok(model.clone());
    }
    let path = Path::new(device);
    if !path.exists() {
        bail!("\"{device}\" is neither a built-in model (`canvass list models`) nor a file");
    }
    let bytes = small_file::read(Path::new(path), OF_HAND).with_context(|| format!("can't read {device}"))?;
    Model::generic(device, &bytes).with_context(|| format!("{device} is no device description"))
}
