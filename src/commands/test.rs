//! `canvass test`: runs the conformance cases against one device.

mod budget;
mod bundled;
mod choice;
mod course;
mod forecast;
pub mod journal;
mod recorder;
pub mod reports;

use crate::allow::{Allow, touches};
use crate::destination::refuse_existing;
use crate::devices::{describe, named, parse_node};
use crate::files::Files;
use crate::interrupt::Interrupt;
use crate::live::{CLIENT, limited, open_device_bus_at, parse_span};
use crate::output::{Color, diagnostic};
use crate::provenance::{Collected, Remarks, Subject, Typed};
use crate::status::{Failure, Status};
use crate::timing::{self, Timeout};
use anyhow::{Context, anyhow};
use budget::{Affordable, Profile, affordable};
use bundled::Bundle;
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_bus::{Endurance, PatientBus};
use canvass_device::address::Opened;
use canvass_device::models::Model;
use canvass_suite::bench::{Options, Target, Timing};
use canvass_suite::runner::RunEvent;
use canvass_suite::verdict::Deviation;
use canvass_suite::waiver::Waivers;
use canvass_traces::Duration;
use canvass_traces::small_file::{self, OF_HAND};
use choice::CaseChoice;
use course::Course;
use recorder::Recorder;
use reports::{Reports, Shown};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Test a device against CiA 301, CiA 305, CiA 406 and its own description
///
/// The device is left as it was found, also after a failure or Ctrl-C. Without --allow, no case writes its
/// non-volatile memory, moves its zero point, or changes its node-ID or bit rate.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The device's node-ID (default: that of the model as delivered or of the DCF)
    #[arg(long, value_parser = parse_node)]
    node: Option<NodeId>,
    /// The device: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    #[command(flatten)]
    choice: CaseChoice,
    /// Changes that the cases may make: nvm, node-id, bit-rate, other-nodes, factory-defaults, preset, other-clients,
    /// or all
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    allow: Vec<Allow>,
    #[command(flatten)]
    shown: Shown,
    /// A file of accepted or quarantined failures, each with its reason (TOML, see `docs/waivers.md`)
    #[arg(long, value_name = "FILE")]
    waivers: Option<PathBuf>,
    /// Write a waiver file with an entry for each failure that nothing excuses, for you to add the reasons
    #[arg(long, value_name = "FILE")]
    write_waivers: Option<PathBuf>,
    /// Run each case this many times; a case with different verdicts is flaky
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Repeat a failed case up to this many times; a case that then passes counts as passed and is marked as flaky
    #[arg(long, default_value_t = 0, value_name = "N", conflicts_with = "repeat", value_parser = clap::value_parser!(u32).range(0..=1000))]
    retries: u32,
    /// Stop after the first case that fails
    #[arg(long)]
    fail_fast: bool,
    /// Record all frames in a capture, with marks for the cases; the extension gives the format
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Add the marks of CiA's test tool to the capture: frames of CAN-ID 7FFh, which were not on the bus
    #[arg(long, requires = "record")]
    cct_markers: bool,
    /// Write report, result, recording, description and waivers of the run into one file, for `canvass verify`
    #[arg(long, value_name = "FILE.zip")]
    bundle: Option<PathBuf>,
    /// The journal of a run on a live bus, for `canvass restore`: each change is recorded before it is made; none: no
    /// journal
    ///
    /// The default is canvass-BUS-nodeN.journal in this folder. canvass removes the journal when the device is
    /// restored.
    #[arg(long, value_name = "FILE|none")]
    journal: Option<PathBuf>,
    /// If an earlier run was interrupted and has left its journal, restore the device first
    #[arg(long)]
    restore: bool,
    /// Overwrite the files of --record, --bundle and --write-waivers if they exist
    #[arg(long)]
    force: bool,
    /// Timeouts, such as sdo=500ms: sdo, store, lss, boot-up, reaction, silence, client (for a client of
    /// slcan:listen:// to connect, default 10s), reconnect (for an interrupted bus to come back, default 2min)
    #[arg(long, value_name = "WHAT=SPAN", value_delimiter = ',')]
    timeout: Vec<Timeout>,
    /// Permitted deviation of the mean of a period, in percent
    #[arg(long, default_value_t = 5, value_name = "PERCENT", value_parser = clap::value_parser!(u32).range(0..=100))]
    tolerance: u32,
    /// A shell command that switches the supply of the device off and on, for a device that stops answering
    #[arg(long, value_name = "COMMAND")]
    power_cycle: Option<String>,
    /// The zero point of the encoder is stored, so that a reset does not lose it (default: an encoder whose 6509h is
    /// not 0 is not tested)
    #[arg(long)]
    zero_point_stored: bool,
    /// The seed of all random choices
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Try all values where cases try samples: every index, every restricted CAN-ID (takes minutes on a live bus)
    #[arg(long)]
    exhaustive: bool,
    /// Run the cases that find most in this time, such as 5min, and end after it (default on a live bus: all cases, at
    /// most one minute and five seconds for each case)
    #[arg(long = "for", value_name = "SPAN", value_parser = parse_span)]
    span: Option<Duration>,
    /// full: all chosen cases; quick: those that together catch 90 % of the known faults in the least time
    #[arg(long, value_enum, default_value_t = Profile::Full)]
    profile: Profile,
    /// Only print which cases would run, and for how long
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    remarks: Remarks,
}

impl Args {
    pub fn run(self, color: Color, typed: &Typed) -> Result<Status, Failure> {
        let mut options = self.options();
        self.name_files()?;
        let Affordable { cases, told } = affordable(&self, self.choice.cases()?, &options)?;
        let mut provenance = self.provenance(typed, &options)?;
        let (waivers, today) = (self.waivers()?, provenance.day());
        if self.dry_run {
            told.iter().for_each(|told| diagnostic(&format!("canvass: {told}")));
            return forecast::dry_run(&self, &cases, &options, waivers.deviations(&today));
        }
        let mut opened = self.open()?;
        options.limit = self.span.or_else(|| opened.bus.is_live().then(|| self.usual_limit(cases.len())));
        let quarantines = waivers.quarantines(&today);
        let target = Target { quarantines, ..self.target(&opened, waivers.deviations(&today))? };
        options.journal = opened.bus.is_live().then(|| self.journal_path(target.node)).flatten();
        if let Some(path) = &options.journal {
            let endurance =
                Endurance { patience: timing::reconnect(&self.timeout), ends: None, cancelled: Arc::default() };
            let mut bus = PatientBus::new(opened.bus.as_mut(), endurance);
            journal::settle(path, self.restore, &self.bus, &mut bus, &target, options.timing)?;
        }
        self.resolve(&mut provenance, &target, &options, opened.bus.bit_rate());
        let recorder =
            self.record.as_deref().map(|path| Recorder::create(path, self.force, self.cct_markers)).transpose()?;
        let mut reports = Reports::open(&self.shown, color)?;
        told.iter().for_each(|told| reports.event(&RunEvent::Noticed(told)));
        let bundle = self.bundle.as_deref().map(|path| Bundle::begin(path, self.force, &mut reports)).transpose()?;
        let cancel =
            Interrupt::watch_saying("canvass: interrupted, the device is being restored (again: at once)")?.flag();
        let ends = options.limit.map(|limit| Instant::now() + std::time::Duration::from(limit));
        let mut course = Course {
            args: &self,
            cases: &cases,
            options: &options,
            target: &target,
            waivers,
            today,
            provenance,
            reports,
        };
        let endurance = Endurance { patience: timing::reconnect(&self.timeout), ends, cancelled: Arc::clone(&cancel) };
        let mut bus = PatientBus::new(opened.bus.as_mut(), endurance);
        match bundle {
            None => course.run(&mut bus, recorder.as_ref(), &cancel)?.finish(course.reports),
            Some(bundle) => bundle.run(course, &mut bus, recorder.as_ref(), &cancel),
        }
    }

    /// Checks that no output file is also an input or another output.
    fn name_files(&self) -> Result<(), Failure> {
        for (option, path) in [
            ("record", &self.record),
            ("bundle", &self.bundle),
            ("journal", &self.journal),
            ("write-waivers", &self.write_waivers),
        ] {
            if path.as_deref().is_some_and(|path| path.as_os_str() == "-") {
                return Err(anyhow!("standard output is for the result: --{option} takes a file").into());
            }
        }
        let files = Files::new().bus(&self.bus).describes(self.device.as_deref()).reads(&self.waivers);
        let files = files.reads(self.choice.result());
        let files = files.writes(self.shown.files())?.writes(&self.record)?;
        files.writes(&self.journal)?.writes(&self.bundle)?.writes(&self.write_waivers)?;
        if let Some(path) = self.write_waivers.as_deref().filter(|_| !self.force) {
            refuse_existing(path)?;
        }
        Ok(())
    }

    /// The provenance, as far as it is known before the device is touched.
    fn provenance(&self, typed: &Typed, options: &Options) -> Result<Collected, Failure> {
        let mut provenance = Collected::begin(&self.remarks, typed, Subject::bus(&self.bus))?;
        provenance.seed(self.seed);
        provenance.descriptions(Some(&self.bus), self.device.as_deref());
        self.waivers.iter().for_each(|path| provenance.file("waivers", path));
        self.choice.result().into_iter().for_each(|path| provenance.file("failed from", path));
        let client = self.timeout.iter().rev().find_map(|timeout| timeout.of_client()).unwrap_or(CLIENT);
        provenance.resolve("timeout", timing::told(&options.timing, client, timing::reconnect(&self.timeout)));
        Ok(provenance)
    }

    /// Adds the values of the options that were not typed to the provenance.
    fn resolve(&self, provenance: &mut Collected, target: &Target, options: &Options, bit_rate: Option<u32>) {
        provenance.bit_rate(bit_rate);
        provenance.resolve("node", vec![target.node.to_string()]);
        provenance
            .resolve("device", Some(target.model.clone()).filter(|model| !model.is_empty()).into_iter().collect());
        provenance.resolve("for", options.limit.map(|limit| limit.to_string()).into_iter().collect());
        let journal = options.journal.as_ref().map(|path| path.display().to_string());
        provenance.resolve("journal", vec![journal.unwrap_or_else(|| "none".to_owned())]);
    }

    fn open(&self) -> Result<Opened, Failure> {
        let client = self.timeout.iter().rev().find_map(|timeout| timeout.of_client()).unwrap_or(CLIENT);
        let mut opened = open_device_bus_at(&self.bus, self.seed, client, self.node)?;
        limited(opened.bus.as_mut());
        Ok(opened)
    }

    /// The default time limit: several times the duration of the cases on a device that needs 10 s to start, as some
    /// devices do. The limit ends only runs that would never end.
    fn usual_limit(&self, cases: usize) -> Duration {
        let each = if self.exhaustive { 120 } else { 60 };
        Duration::from_secs(60 + each * cases as u64 * u64::from(self.repeat))
    }

    fn options(&self) -> Options {
        let mut timing = Timing { period_tolerance: self.tolerance, ..Timing::default() };
        for timeout in &self.timeout {
            timeout.set(&mut timing);
        }
        Options {
            allow: touches(&self.allow),
            timing,
            repeat: self.repeat,
            retries: self.retries,
            fail_fast: self.fail_fast,
            power_cycle: self.power_cycle.clone(),
            exhaustive: self.exhaustive,
            limit: self.span,
            zero_point_is_stored: self.zero_point_stored,
            journal: None,
        }
    }

    fn journal_path(&self, node: NodeId) -> Option<PathBuf> {
        match &self.journal {
            Some(none) if none.as_os_str() == "none" => None,
            Some(path) => Some(path.clone()),
            None => Some(journal::usual_path(&self.bus, node)),
        }
    }

    fn waivers(&self) -> Result<Waivers, Failure> {
        let Some(path) = &self.waivers else { return Ok(Waivers::default()) };
        let text = small_file::read_text(path, OF_HAND).with_context(|| format!("can't read {}", path.display()))?;
        Ok(Waivers::read(&text).with_context(|| format!("{}", path.display()))?)
    }

    fn target(&self, opened: &Opened, waived: Vec<Deviation>) -> Result<Target, Failure> {
        let model = opened.model;
        let named = self.device.as_deref().map(named);
        let (model, device) = match (named, model) {
            (Some(device), _) => (device.to_owned(), Some(describe(device)?)),
            (None, Some(model)) => {
                let firmware = opened.devices.first().map(|device| device.firmware).unwrap_or_default();
                let (description, manual) = (model.description_with(firmware), model.device().manual.clone());
                (model.id().to_owned(), Some(KnownDevice { description, manual }))
            }
            (None, None) => (String::new(), None),
        };
        let usual = || Model::by_id(&model).and_then(Model::default_node);
        let commissioned = || device.as_ref()?.description.commissioning.as_ref()?.node_id;
        let node = self.node.or_else(|| opened.node()).or_else(usual).or_else(commissioned);
        let node = node.ok_or_else(|| which_node(&self.bus, opened.model))?;
        let manual = Model::by_id(&model).map(Deviation::of_model).unwrap_or_default();
        // A waiver takes precedence over the manual's sheet, because the user's statement is about this very device.
        let deviations = waived.into_iter().chain(manual).collect();
        let described_alone = self.device.is_none() && opened.model.is_some_and(Model::is_described_alone);
        Ok(Target { deviations, described_alone, ..Target::known(node, model, device) })
    }
}

/// The error that asks for the device's node-ID and says how to find it.
pub fn which_node(bus: &str, model: Option<&Model>) -> anyhow::Error {
    match model {
        Some(model) => {
            anyhow!("{} has no node-ID as delivered: assign one with --node N, as commissioning does", model.id())
        }
        None => anyhow!("the node-ID of the device is not known: use --node N (canvass scan {bus} finds it)"),
    }
}
