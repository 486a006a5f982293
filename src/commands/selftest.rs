//! `canvass selftest`: checks that the cases detect the known faults.

use crate::live::parse_span;
use crate::output::{document, print, unless_closed};
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_device::Fault;
use canvass_device::models::Model;
use canvass_fuzzer::detection::{FuzzedFault, Limit, Table, detect};
use canvass_fuzzer::liberties;
use canvass_reports::escape::Printable;
use canvass_reports::fuzz::detection;
use canvass_reports::selftest::{alone, json, null, text, wire};
use canvass_suite::case::Case;
use canvass_suite::catalogue::{Selector, select};
use canvass_suite::selftest::{self, Chance, Extent};
use canvass_traces::Duration;

/// Number of exchanges within which the fuzzer has to find each fault: how many it takes does not depend on the speed of
/// this computer.
const MOST_EXCHANGES: u64 = 10_000_000;

/// Test the tester: run the cases against firmware with known faults
///
/// The selftest puts every fault into the firmware of a simulated device, and runs every case against it. A fault is
/// detected if a case that names it fails. Every model without fault must pass, and so must every firmware with
/// liberties (unusual behaviour that the standard allows). Faults must also be detected together with liberties. The
/// fuzzer must find no violation on firmware without faults.
#[derive(clap::Args)]
pub struct Args {
    /// Cases to run, as for `canvass test` (default: all cases and all faults)
    #[arg(long, value_name = "SELECTOR", value_delimiter = ',')]
    select: Vec<Selector>,
    /// Faults to run, each with the cases that name it (default: all faults that the cases name)
    #[arg(long, value_name = "FAULT", value_delimiter = ',')]
    fault: Vec<Fault>,
    /// The seed for random combinations of liberties
    #[arg(long, default_value_t = Chance::WHOLE.seed)]
    seed: u64,
    /// Instead run the cases on devices that implement no service: show which cases pass, and whether each pass was
    /// reviewed
    #[arg(long, conflicts_with_all = ["fuzz", "fault"])]
    null: bool,
    /// Instead run the cases on devices with one wrong field of one message: show which of these devices fail
    #[arg(long, conflicts_with_all = ["fuzz", "fault", "null"])]
    wire: bool,
    /// With --wire: the devices to run, such as `sdo/*` or `*/frame/lost/*` (default: all)
    #[arg(long, value_name = "PATTERN", value_delimiter = ',', requires = "wire")]
    mutant: Vec<String>,
    /// Instead run each case alone and together with all others, in two orders: show which verdicts differ, and whether
    /// each difference was reviewed
    #[arg(long, conflicts_with_all = ["fuzz", "fault", "null", "wire"])]
    alone: bool,
    /// With --wire: number of these devices, drawn by --seed (default: all); with --alone: number of faults, and of
    /// pairs of faults (default: 40)
    #[arg(long, value_name = "N", conflicts_with_all = ["fuzz", "null"])]
    count: Option<usize>,
    /// Instead test the fuzzer: show how fast it finds each fault that it claims to find
    #[arg(long, conflicts_with = "select")]
    fuzz: bool,
    /// With --fuzz: number of seeds
    #[arg(long, value_name = "N", default_value_t = 5, requires = "fuzz")]
    seeds: u64,
    /// With --fuzz: time limit of each seed for finding a fault (default: ten million exchanges in place of a time)
    #[arg(long = "within", value_name = "SPAN", value_parser = parse_span, requires = "fuzz")]
    within: Option<Duration>,
    /// How to print the matrix
    #[arg(long, value_enum, default_value_t)]
    format: MatrixFormat,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum MatrixFormat {
    /// Text
    #[default]
    Table,
    /// The contract for programs
    Json,
}

impl Args {
    /// The selected cases and faults that belong together.
    fn chosen(&self) -> Result<(Vec<&'static Case>, Vec<Fault>), Failure> {
        let mut cases = select(&self.select)
            .map_err(|idle| Failure::unreachable(anyhow!("no case was executed: --select {idle} selects none")))?;
        if self.fault.is_empty() {
            let faults = if self.select.is_empty() { Fault::ALL.to_vec() } else { selftest::named_by(&cases) };
            return Ok((cases, faults));
        }
        cases.retain(|case| self.fault.iter().any(|fault| case.catches.contains(fault)));
        match self.fault.iter().find(|fault| !cases.iter().any(|case| case.catches.contains(fault))) {
            Some(idle) => Err(Failure::unreachable(anyhow!(
                "no case was executed: no selected case has to find the fault {idle}"
            ))),
            None => Ok((cases, self.fault.clone())),
        }
    }

    pub fn run(self) -> Result<Status, Failure> {
        if self.fuzz {
            return self.fuzz();
        }
        if self.null {
            return self.null();
        }
        if self.wire {
            return self.wire();
        }
        if self.alone {
            return self.alone();
        }
        let of_faults = !self.fault.is_empty();
        let (cases, faults) = self.chosen()?;
        let mut chance = Chance { seed: self.seed, ..Chance::WHOLE };
        let mut models: Vec<&'static Model> = Model::all().iter().collect();
        if of_faults {
            (chance.combinations, chance.starts) = (0, 0);
            models.retain(|model| faults.iter().any(|fault| fault.model() == model.id()));
        }
        let matrix = selftest::run(&cases, &faults, &models, Extent::Whole, chance);
        // With a selection, the parts that do not depend on it are left out, to be quick.
        let whole = self.select.is_empty() && !of_faults;
        let chance = if whole { liberties::Chance::WHOLE } else { liberties::Chance::NONE };
        let fuzzed = liberties::run(liberties::Chance { seed: self.seed, ..chance }).map_err(Failure::unreachable)?;
        match self.format {
            MatrixFormat::Table => print(&Printable::document(&text(&matrix, &fuzzed)))?,
            MatrixFormat::Json => unless_closed(json(&matrix, &fuzzed, &mut document(false)))?,
        }
        Ok(if matrix.is_good() && fuzzed.is_good() { Status::Good } else { Status::Findings })
    }

    fn null(self) -> Result<Status, Failure> {
        let (cases, _) = self.chosen()?;
        let rows = selftest::null::run(&cases).map_err(|error| Failure::unreachable(anyhow!(error)))?;
        match self.format {
            MatrixFormat::Table => print(&Printable::document(&null::text(&rows)))?,
            MatrixFormat::Json => unless_closed(null::json(&rows, &mut document(false)))?,
        }
        let good = rows.iter().all(selftest::null::NullRow::is_good);
        Ok(if good { Status::Good } else { Status::Findings })
    }

    fn wire(self) -> Result<Status, Failure> {
        let (cases, _) = self.chosen()?;
        let sample = selftest::wire::Sample { only: self.mutant, seed: self.seed, count: self.count };
        let matrix =
            selftest::wire::run(&cases, Model::all(), &sample).map_err(|error| Failure::unreachable(anyhow!(error)))?;
        if matrix.rows.is_empty() {
            return Err(Failure::unreachable(anyhow!("no device was tested: no id matches --mutant")));
        }
        match self.format {
            MatrixFormat::Table => print(&Printable::document(&wire::text(&matrix)))?,
            MatrixFormat::Json => unless_closed(wire::json(&matrix, &mut document(false)))?,
        }
        Ok(if matrix.survivors().next().is_none() { Status::Good } else { Status::Findings })
    }

    fn alone(self) -> Result<Status, Failure> {
        let (cases, _) = self.chosen()?;
        let count = self.count.unwrap_or(selftest::alone::Sample::USUAL);
        let sample = selftest::alone::Sample { seed: self.seed, count: Some(count) };
        let rows = selftest::alone::run(&cases, sample).map_err(|error| Failure::unreachable(anyhow!(error)))?;
        match self.format {
            MatrixFormat::Table => print(&Printable::document(&alone::text(&rows)))?,
            MatrixFormat::Json => unless_closed(alone::json(&rows, &mut document(false)))?,
        }
        let good = rows.iter().all(selftest::alone::AloneRow::is_good);
        Ok(if good { Status::Good } else { Status::Findings })
    }

    /// Runs each claimed fault with each seed, one after the other: parallel runs would distort the times.
    fn fuzz(self) -> Result<Status, Failure> {
        let claimed = || Fault::ALL.iter().copied().filter(|fault| fault.unfuzzed().is_none()).collect();
        let faults: Vec<Fault> = if self.fault.is_empty() { claimed() } else { self.fault };
        let time = |within: Duration| std::time::Duration::from_nanos(within.nanos());
        let limit = match self.within {
            Some(within) => Limit { exchanges: u64::MAX, time: time(within) },
            None => Limit::of_exchanges(MOST_EXCHANGES),
        };
        let mut rows = Vec::with_capacity(faults.len());
        for fault in faults {
            let trials = (1..=self.seeds).map(|seed| detect(fault, seed, limit));
            rows.push(FuzzedFault { fault, trials: trials.collect::<Result<_, _>>().map_err(Failure::unreachable)? });
        }
        let table = Table { rows, limit: limit.time };
        match self.format {
            MatrixFormat::Table => print(&Printable::document(&detection::text(&table)))?,
            MatrixFormat::Json => unless_closed(detection::json(&table, &mut document(false)))?,
        }
        let good = table.rows.iter().all(|row| row.is_good(table.limit));
        Ok(if good { Status::Good } else { Status::Findings })
    }
}
