//! `canvass explain`: one case, fault or format in full.

use crate::status::{Failure, Status};
use anyhow::anyhow;

/// Explain a case, a fault or a capture format in full
#[derive(clap::Args)]
pub struct Args {
    /// The id, as `canvass list` shows it
    id: String,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        Err(anyhow!(
            "nothing is called \"{}\": `canvass list cases|models|faults|formats` shows what there is",
            self.id
        )
        .into())
    }
}
