//! `canvass selftest`: whether the cases detect what they are for.

use crate::output::print;
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_conformance::Fault;
use canvass_conformance::catalogue::{Selector, select};
use canvass_conformance::models::Model;
use canvass_conformance::selftest::{self, Extent};
use canvass_reports::selftest::{json, text};

/// Test the tester: run the cases against firmware with known faults
///
/// Every fault is put into the firmware of a simulated device, and every case runs against it. A fault is detected if a
/// case that names it fails. Every model without fault must pass.
#[derive(clap::Args)]
pub struct Args {
    /// Which cases, as for `canvass test`; without it all, and all faults
    #[arg(long, value_name = "SELECTOR", value_delimiter = ',')]
    select: Vec<Selector>,
    /// Which faults; without it those that the cases name
    #[arg(long, value_name = "FAULT", value_delimiter = ',')]
    fault: Vec<Fault>,
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
    pub fn run(self) -> Result<Status, Failure> {
        let cases = select(&self.select)
            .map_err(|idle| Failure::unreachable(anyhow!("no case was executed: --select {idle} selects none")))?;
        let faults = match (self.fault.is_empty(), self.select.is_empty()) {
            (false, _) => self.fault,
            (true, true) => Fault::ALL.to_vec(),
            (true, false) => selftest::named_by(&cases),
        };
        let models: Vec<&'static Model> = Model::all().iter().collect();
        let matrix = selftest::run(&cases, &faults, &models, Extent::Whole);
        match self.format {
            MatrixFormat::Table => print(&text(&matrix))?,
            MatrixFormat::Json => json(&matrix, &mut std::io::stdout().lock())?,
        }
        Ok(if matrix.is_good() { Status::Good } else { Status::Findings })
    }
}
