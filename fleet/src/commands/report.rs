//! `canvass-fleet report`: the contents of a lake as a page.

use crate::cli::Engine;
use crate::output::WholeFile;
use crate::status::{Failure, Status};
use canvass_fleet::{lake, report, views};
use std::path::PathBuf;
use std::str::FromStr;

/// Report the content of a lake: plots over time and the usual queries, as one self-contained page
#[derive(clap::Args)]
pub struct Args {
    /// The lake: a folder, or s3://BUCKET/PREFIX
    #[arg(value_name = "LAKE")]
    lake: String,
    /// The file for the page, such as html=fleet.html
    #[arg(long, required = true, value_name = "FORMAT=FILE")]
    report: Vec<Destination>,
    /// Maximum number of rows of an answer on the page
    #[arg(long, value_name = "N", default_value_t = 200)]
    max_rows: usize,
    #[command(flatten)]
    engine: Engine,
}

/// The file that gets the HTML page.
#[derive(Clone, Debug)]
struct Destination(PathBuf);

impl FromStr for Destination {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some(("html", file)) if !file.is_empty() => Ok(Self(PathBuf::from(file))),
            _ => Err("expected html=FILE, such as html=fleet.html".to_owned()),
        }
    }
}

impl Args {
    pub async fn run(self) -> Result<Status, Failure> {
        let session = self.engine.session().await?;
        lake::register(&session, &self.lake).await?;
        views::register(&session).await?;
        let fleet = report::ask(&session, &self.lake, self.max_rows).await?;
        for Destination(path) in &self.report {
            let file = WholeFile::create(path)?;
            canvass_reports::fleet::render(&fleet, &mut file.writer()?)?;
            file.complete()?;
        }
        Ok(Status::Good)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn destinations_as_typed() {
        assert_eq!("html=a=b.html".parse::<Destination>().unwrap().0, PathBuf::from("a=b.html"));
        for wrong in ["", "html", "html=", "json=a.json", "a.html"] {
            assert!(wrong.parse::<Destination>().is_err(), "{wrong}");
        }
    }
}
