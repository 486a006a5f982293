//! `canvass test`: the conformance cases against one device.

mod forecast;
mod recorder;
pub mod reports;
mod timing;

use crate::devices::{describe, parse_node};
use crate::live::open_bus;
use crate::output::Color;
use crate::status::{Failure, Status};
use anyhow::{Context, anyhow};
use canvass_analyzer::NodeId;
use canvass_device::address::Opened;
use canvass_device::models::Model;
use canvass_suite::bench::{Bench, Decoder, Deviation, Evidence, Options, Target, Timing};
use canvass_suite::case::{Case, Touch};
use canvass_suite::catalogue::{Selector, nearest, select};
use canvass_suite::runner::{CaseReport, Plan, RunEvent, run};
use canvass_suite::waiver::Waivers;
use recorder::{Recorded, Recorder};
use reports::{ReportArg, ReportFormat, Reports};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use timing::Timeout;

/// Test a device against CiA 301, CiA 305, CiA 406 and its own description
///
/// The device is left as it was found, also after a failure or Ctrl-C. Nothing is done that writes its non-volatile
/// memory or changes its node-ID or bit rate unless --allow names it.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE] or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The device's node-ID; without it the one that the model or DCF has as delivered
    #[arg(long, value_parser = parse_node)]
    node: Option<NodeId>,
    /// What the device is: a built-in model or an EDS or DCF file
    #[arg(long, value_name = "MODEL|FILE")]
    device: Option<String>,
    /// Which cases: the beginning of an id (301/sdo), a pattern (301/*/toggle) or a section (7.2.8)
    #[arg(long, value_name = "SELECTOR", value_delimiter = ',')]
    select: Vec<Selector>,
    /// What the cases may do: nvm, node-id, bit-rate, other-nodes, factory-defaults
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    allow: Vec<Touch>,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    format: ReportFormat,
    /// Write a report into a file too; can be given several times
    #[arg(long, value_name = "FORMAT=FILE")]
    report: Vec<ReportArg>,
    /// A file of failures that are put up with, each with its reason (TOML, see `docs/cases.md`)
    #[arg(long, value_name = "FILE")]
    waivers: Option<PathBuf>,
    /// Run each case so often; a case that does not always end the same way is flaky
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Write the whole traffic into a capture, in which the cases are marked; its extension tells the format
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// How long to wait, in milliseconds: sdo, boot-up, reaction, silence
    #[arg(long, value_name = "WHAT=MS", value_delimiter = ',')]
    timeout: Vec<Timeout>,
    /// How far the mean of a period may be off, in percent
    #[arg(long, default_value_t = 5, value_name = "PERCENT", value_parser = clap::value_parser!(u32).range(0..=100))]
    tolerance: u32,
    /// A shell command that switches the supply of the device off and on: tried when the device stops answering
    #[arg(long, value_name = "COMMAND")]
    power_cycle: Option<String>,
    /// The seed of everything that is left to chance
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Try everything where cases try samples: every index, every restricted CAN-ID (takes minutes on a live bus)
    #[arg(long)]
    exhaustive: bool,
    /// Only say which cases would run, and how long that would take
    #[arg(long)]
    dry_run: bool,
}

/// A third of a second of a full bus at 1 Mbit/s. Waits that are that late say nothing of the device any more.
const BACKLOG: usize = 8_192;

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let cases = self.cases()?;
        let options = self.options();
        if self.dry_run {
            return forecast::dry_run(&self.bus, self.device.as_deref(), &cases, &options);
        }
        let (waivers, today) = (self.waivers()?, today());
        let mut opened = open_bus(&self.bus, self.seed)?;
        opened.bus.limit_backlog(BACKLOG);
        let target = self.target(&opened, waivers.deviations(&today))?;
        let recorder = self.record.as_deref().map(Recorder::create).transpose()?;
        let mut annotate = Recorded { decoder: Decoder::new(&target), recorder: recorder.as_ref() };
        let mut reports = Reports::open(self.format, &self.report, color)?;
        let cancel = cancelled_by_ctrl_c()?;
        let plan = Plan { cases: &cases, bus: &self.bus, bit_rate: opened.bus.bit_rate(), seed: self.seed };
        let mut bench = Bench::new(opened.bus.as_mut(), &target, &options, &mut annotate, &cancel);
        let mut written: io::Result<()> = Ok(());
        let mut finished: Vec<CaseReport> = Vec::new();
        let summary = run(&mut bench, &plan, &mut |event: &RunEvent<'_>| {
            if let Some(recorder) = &recorder {
                recorder.event(event);
            }
            match event {
                RunEvent::CaseFinished(report) if self.waivers.is_some() => {
                    // Whether a waiver was needed is all that is asked.
                    finished.push(CaseReport { evidence: Evidence::default(), ..(*report).clone() });
                }
                RunEvent::RunFinished(_) if written.is_ok() => {
                    let idle = waivers.idle(&today, &finished.iter().collect::<Vec<_>>());
                    written = idle.iter().try_for_each(|notice| reports.event(&RunEvent::Noticed(notice)));
                }
                _ => {}
            }
            // The device is put back in any case; a report that can't be written is told of afterwards.
            if written.is_ok() {
                written = reports.event(event);
            }
        });
        written.context("can't write the report")?;
        if let Some(recorder) = recorder {
            recorder.finish()?;
        }
        let summary = summary.map_err(Failure::unreachable)?;
        Ok(if summary.is_good() && !summary.cancelled { Status::Good } else { Status::Findings })
    }

    fn cases(&self) -> Result<Vec<&'static Case>, Failure> {
        select(&self.select).map_err(|idle| {
            let meant = nearest(&idle).map(|family| format!(" (is {family} meant?)")).unwrap_or_default();
            Failure::unreachable(anyhow!(
                "no case was executed: --select {idle} selects none{meant}, see `canvass list cases`"
            ))
        })
    }

    fn options(&self) -> Options {
        let mut timing = Timing { period_tolerance: self.tolerance, ..Timing::default() };
        for timeout in &self.timeout {
            timeout.set(&mut timing);
        }
        Options {
            allow: self.allow.iter().copied().collect(),
            timing,
            repeat: self.repeat,
            power_cycle: self.power_cycle.clone(),
            exhaustive: self.exhaustive,
        }
    }

    fn waivers(&self) -> Result<Waivers, Failure> {
        let Some(path) = &self.waivers else { return Ok(Waivers::default()) };
        let text = std::fs::read_to_string(path).with_context(|| format!("can't read {}", path.display()))?;
        Ok(Waivers::read(&text).with_context(|| format!("{}", path.display()))?)
    }

    fn target(&self, opened: &Opened, waived: Vec<Deviation>) -> Result<Target, Failure> {
        let model = opened.model;
        let named = self.device.as_deref().map(|device| device.split_once('=').map_or(device, |(_, device)| device));
        let named_node = || Model::by_id(named?).and_then(Model::default_node);
        let node = self.node.or_else(|| opened.node()).or_else(named_node);
        let node = node.ok_or_else(|| anyhow!("which node? Say --node N (canvass scan {} finds it)", self.bus))?;
        let (model, description) = match (named, model) {
            (Some(device), _) => (device.to_owned(), Some(describe(device)?)),
            (None, Some(model)) => {
                let firmware = opened.devices.first().map(|device| device.firmware).unwrap_or_default();
                (model.id().to_owned(), Some(model.description_with(firmware)))
            }
            (None, None) => (String::new(), None),
        };
        let manual = Model::by_id(&model).map(Deviation::of_model).unwrap_or_default();
        // What the user says goes before what the manual says: it is the more specific of the two.
        let deviations = waived.into_iter().chain(manual).collect();
        Ok(Target { node, model, description, deviations })
    }
}

/// The day, as waivers are dated.
fn today() -> String {
    jiff::Zoned::now().date().to_string()
}

/// Is set by the first Ctrl-C, so that the device can be put back; the second one ends the program at once.
fn cancelled_by_ctrl_c() -> Result<Arc<AtomicBool>, Failure> {
    const INTERRUPTED: i32 = 130;
    let cancel = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancel);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
        crate::output::diagnostic("canvass: interrupted, the device is being restored (again: at once)");
    })?;
    Ok(cancel)
}
