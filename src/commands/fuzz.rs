//! `canvass fuzz`: sends sequences of frames to a device and checks the properties.

mod corpus;
mod device;
mod earlier;
mod progress;
mod regressions;
mod reproducers;

use super::test::reports::{ReportArg, ReportFormat, Shown, print, write_file};
use crate::allow::{Allow, touches};
use crate::devices::parse_node;
use crate::files::Files;
use crate::interrupt::Interrupt;
use crate::live::parse_span;
use crate::output::diagnostic;
use crate::provenance::{Collected, Remarks, Subject, Typed};
use crate::reconnect::ReconnectArg;
use crate::status::{Failure, Status};
use crate::whole_file::WholeFile;
use anyhow::anyhow;
use canvass_analyzer::NodeId;
use canvass_fuzzer::campaign::{self, Found, Outcome, Plan};
use canvass_fuzzer::coverage::{LssReach, SdoReach};
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Knowledge, Targets};
use canvass_reports::fuzz::{Run, Words};
use canvass_reports::provenance::Provenance;
use canvass_suite::identity;
use canvass_suite::touch::Touch;
use canvass_traces::Duration;
use device::Device;
use earlier::Earlier;
use progress::Progress;
use std::path::PathBuf;
use std::time::Instant;

/// Fuzz a device: send it unexpected sequences of frames, and judge every frame that comes back
///
/// Reference models of SDO, NMT, LSS, PDO, EMCY and error control say what the device must, may and must not send.
/// Each violation is repeated to confirm it, and its sequence of frames is shortened as far as possible. Without
/// --allow, the fuzzer never writes the device's non-volatile memory, moves its zero point, changes its node-ID or
/// bit rate, or commands other nodes, neither on a simulated bus nor on a live one.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The device's node-ID (default: the model's node-ID as delivered)
    #[arg(long, value_parser = parse_node)]
    node: Option<NodeId>,
    /// The device: a built-in model, or an EDS or DCF file
    #[arg(long, value_name = "[NODE=]MODEL|FILE")]
    device: Option<String>,
    /// The services to fuzz: sdo, lss, nmt, pdo, sync-emcy or all, separated by commas
    #[arg(long, value_name = "SERVICES", default_value_t)]
    target: Targets,
    /// Time limit, such as 30s, 10m or 1h (default without --runs: 10s on a simulated bus, 60s on a live one)
    #[arg(long = "for", value_name = "SPAN", value_parser = parse_span)]
    span: Option<Duration>,
    /// Number of sequences; a run with the same number and seed is identical
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    runs: Option<u64>,
    /// The seed of all random choices (default: from the clock; the result names it)
    #[arg(long)]
    seed: Option<u64>,
    /// End with the first violation
    #[arg(long)]
    stop_at_first: bool,
    /// Number of tries for shortening a sequence (default: 2000 on a simulated bus, 100 on a live one)
    #[arg(long, value_name = "N")]
    shrink_budget: Option<u32>,
    /// Changes that the sequences may make: nvm, node-id, bit-rate, other-nodes, factory-defaults, preset, or all
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    allow: Vec<Allow>,
    /// Only send the frames of this log or reproducer again, and judge the answers
    #[arg(long, value_name = "FILE", conflicts_with_all = ["span", "runs", "regressions"])]
    replay: Option<PathBuf>,
    /// A file of sequences that showed violations: it is replayed first, and new ones are appended
    #[arg(long, value_name = "FILE")]
    regressions: Option<PathBuf>,
    /// A folder of sequences that is kept between runs: they are tried first, after those that showed violations, and
    /// new ones are added. Takes the place of --regressions
    #[arg(long, value_name = "DIR", conflicts_with_all = ["replay", "regressions"])]
    corpus_dir: Option<PathBuf>,
    /// Exit with status 1 also for violations that did not come back
    #[arg(long)]
    unconfirmed: bool,
    /// A folder for a candump log and a pytest of each violation; it is created if it does not exist
    #[arg(long, value_name = "DIR")]
    reproducers: Option<PathBuf>,
    #[command(flatten)]
    reconnect: ReconnectArg,
    #[command(flatten)]
    shown: Shown,
    #[command(flatten)]
    remarks: Remarks,
}

impl Args {
    pub fn run(self, typed: &Typed) -> Result<Status, Failure> {
        let seed = self.seed.unwrap_or_else(from_the_clock);
        let files = Files::new().bus(&self.bus).describes(self.device.as_deref()).reads(&self.replay);
        files.writes(&self.regressions)?.writes(self.shown.files())?;
        let mut provenance = self.provenance(typed, seed)?;
        let (of_stdout, reports) = (self.shown.of_stdout()?, self.open_reports()?);
        let mut device = Device::open(&self.bus, self.node, self.device.as_deref(), seed)?;
        let simulated = device.is_simulated();
        let allow = touches(&self.allow);
        let knowledge = device.knowledge().clone();
        let earlier = match &self.replay {
            Some(path) => Earlier::replayed(path, &knowledge, &allow)?,
            None => Earlier::open(self.corpus_dir.clone(), self.regressions.clone(), &knowledge, &allow)?,
        };
        let (regressions, corpus) = earlier.sequences();
        let interrupt = Interrupt::watch()?;
        let span = self.span(simulated);
        let mut plan = Plan {
            targets: self.target,
            seed,
            allow,
            shrink_budget: match &self.replay {
                Some(_) => 0,
                None => self.shrink_budget.unwrap_or(if simulated { 2_000 } else { 100 }),
            },
            time: TimeLimit { ends: None, cancelled: interrupt.flag() },
            stop_at_first: self.stop_at_first,
            regressions,
            only_regressions: self.replay.is_some(),
            corpus,
        };
        self.resolve(&mut provenance, &mut device, &plan, span)?;
        let before = device.zero_point();
        // The time limit starts here, after the first questions to the device.
        plan.time.ends = self.ends(span, simulated);
        let outcome = self.fuzz(&mut device, &knowledge, &plan, span, &interrupt)?;
        let kept = earlier.keep(&outcome, seed).and(
            self.reproducers
                .as_deref()
                .map_or(Ok(()), |dir| reproducers::write(dir, &outcome.violations, knowledge.node, seed)),
        );
        let moved = before.and_then(|before| before.moved(&device.zero_point()?));
        let run = Run { zero_point: moved, ..self.result(&device, provenance.0, &plan, outcome, interrupt.came()) };
        let printed = print(&run, of_stdout);
        // All reports are written even if one of them fails.
        let reported: Vec<_> = reports.into_iter().map(|(format, file)| write_file(&run, format, file)).collect();
        printed?;
        kept?;
        reported.into_iter().collect::<Result<(), _>>()?;
        Ok(status(&run, self.unconfirmed))
    }

    /// The provenance, as far as it is known before the first frame is sent.
    fn provenance(&self, typed: &Typed, seed: u64) -> Result<Collected, Failure> {
        let mut provenance = Collected::begin(&self.remarks, typed, Subject::bus(&self.bus))?;
        provenance.seed(seed);
        provenance.resolve("seed", vec![seed.to_string()]);
        provenance.descriptions(Some(&self.bus), self.device.as_deref());
        self.replay.iter().for_each(|path| provenance.file("replay", path));
        self.regressions.iter().for_each(|path| provenance.file("regressions", path));
        Ok(provenance)
    }

    /// Adds the values of the options that were not typed to the provenance.
    fn resolve(
        &self,
        provenance: &mut Collected,
        device: &mut Device,
        plan: &Plan,
        span: Option<Duration>,
    ) -> Result<(), Failure> {
        let node = device.knowledge().node;
        provenance.bit_rate(device.bit_rate());
        provenance.resolve("node", vec![node.to_string()]);
        provenance
            .resolve("device", Some(device.name().to_owned()).filter(|name| !name.is_empty()).into_iter().collect());
        provenance.resolve("for", span.map(|span| span.to_string()).into_iter().collect());
        provenance.resolve("shrink-budget", vec![plan.shrink_budget.to_string()]);
        let endurance = self.reconnect.until(None, plan.time.cancelled.clone());
        let identity = device.on_bus(&self.bus, plan.seed, endurance, |bus| identity::ask(bus, node))?;
        // A bus failure ends the run; the report is written all the same.
        provenance.node(node, identity.unwrap_or_default());
        Ok(())
    }

    /// The time limit of the run; `None` if `--runs` limits it.
    fn span(&self, simulated: bool) -> Option<Duration> {
        let usual = if simulated { Duration::from_secs(10) } else { Duration::from_secs(60) };
        match (self.span, self.runs) {
            (None, None) => Some(usual).filter(|_| self.replay.is_none()),
            (span, _) => span,
        }
    }

    /// The latest time at which shortening ends: the time limit of the run and, on a simulated bus, 1 s more, as each
    /// try costs almost no time there.
    fn ends(&self, span: Option<Duration>, simulated: bool) -> Option<Instant> {
        let more = if simulated { Duration::from_secs(1) } else { Duration::ZERO };
        Some(Instant::now() + std::time::Duration::from(span? + more))
    }

    /// Runs the fuzzer, with progress on a terminal.
    fn fuzz(
        &self,
        device: &mut Device,
        knowledge: &Knowledge,
        plan: &Plan,
        span: Option<Duration>,
        interrupt: &Interrupt,
    ) -> Result<Outcome, Failure> {
        let begun = Instant::now();
        let mut progress = Progress::new(span);
        let endurance = self.reconnect.until(plan.time.ends, plan.time.cancelled.clone());
        let outcome = device.on_stand(&plan.time, endurance, |stand| {
            campaign::run(stand, knowledge.clone(), plan, &mut |state| {
                progress.show(&state);
                let in_time = span.is_none_or(|span| begun.elapsed().as_nanos() < u128::from(span.nanos()));
                in_time && self.runs.is_none_or(|runs| state.sequences < runs) && !interrupt.came()
            })
        });
        let outcome = outcome.map_err(Failure::unreachable)?;
        progress.end(&outcome);
        Ok(outcome)
    }

    fn result(&self, device: &Device, provenance: Provenance, plan: &Plan, outcome: Outcome, cancelled: bool) -> Run {
        let knowledge = device.knowledge();
        let words =
            outcome.violations.iter().map(|found| Words::of(found, &mut || Box::new(device.decoder()))).collect();
        Run {
            provenance,
            bus: self.bus.clone(),
            bit_rate: device.bit_rate(),
            node: knowledge.node,
            model: device.name().to_owned(),
            targets: self.target,
            allow: plan.allow.clone(),
            seed: plan.seed,
            repeat: self.repeat(knowledge.node, plan.seed, outcome.sequences),
            cancelled,
            sdo_reach: SdoReach::of(knowledge),
            reach: LssReach::of(&knowledge.services, device.has_unconfigured(), &plan.allow),
            outcome,
            zero_point: None,
            words,
        }
    }

    /// The command that repeats the run; on a simulated bus the frames are then identical.
    fn repeat(&self, node: NodeId, seed: u64, sequences: u64) -> String {
        let mut command = format!("canvass fuzz {} --node {node}", self.bus);
        if let Some(device) = &self.device {
            command += &format!(" --device {device}");
        }
        if let Some(replay) = &self.replay {
            return command + &format!(" --replay {}", replay.display());
        }
        command += &format!(" --target {} --seed {seed} --runs {sequences}", self.target);
        if let Some(budget) = self.shrink_budget {
            command += &format!(" --shrink-budget {budget}");
        }
        if self.stop_at_first {
            command += " --stop-at-first";
        }
        if !self.allow.is_empty() {
            let names: Vec<&str> = touches(&self.allow).into_iter().map(Touch::name).collect();
            command += &format!(" --allow {}", names.join(","));
        }
        command
    }

    /// Creates all report files before the first frame is sent, so that an unwritable path is reported at once.
    fn open_reports(&self) -> Result<Vec<(ReportFormat, WholeFile)>, Failure> {
        let open = |arg: &ReportArg| Ok((arg.format(), WholeFile::create(arg.file())?));
        self.shown.in_files().map(open).collect()
    }
}

/// The exit status. Violations take precedence over a failure of the bus: they stay true. A violation that did not come
/// back may be a disturbance, unless it could not be repeated.
fn status(run: &Run, unconfirmed: bool) -> Status {
    let is_repeated = |found: &Found| !found.is_cut_off && !found.repetitions.is_empty();
    let counts = |found: &Found| found.confirmed || !is_repeated(found) || unconfirmed;
    match &run.outcome {
        outcome if outcome.violations.iter().any(counts) || outcome.dead => Status::Findings,
        outcome if outcome.ended_by.is_some() => Status::Unreachable,
        _ if run.cancelled => Status::Findings,
        _ => Status::Good,
    }
}

/// A seed from the clock, of few digits, so that it is easily typed again.
fn from_the_clock() -> u64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    u64::from(now.subsec_nanos()) ^ now.as_secs() & 0xFFFF
}

/// The failure for a log or a file of regressions that can't be read.
fn unreadable(path: &std::path::Path, error: impl std::fmt::Display) -> anyhow::Error {
    anyhow!("{}: {error}", path.display())
}

fn notice(text: &str) {
    diagnostic(&format!("canvass: {text}"));
}
