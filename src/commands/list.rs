//! `canvass list`: what there is.

use crate::output::print;
use crate::status::{Failure, Status};
use canvass_traces::Format;
use serde_json::{Value, json};
use std::fmt::Write;

/// List cases, models, faults or formats
#[derive(clap::Args)]
pub struct Args {
    /// What to list
    #[arg(value_enum)]
    what: What,
    /// How to print them
    #[arg(long, value_enum, default_value_t)]
    format: ListFormat,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum What {
    /// Capture formats
    Formats,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum ListFormat {
    /// Aligned text
    #[default]
    Text,
    /// An array of objects with `id` and `summary`
    Json,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let rows = match self.what {
            What::Formats => formats(),
        };
        match self.format {
            ListFormat::Text => print(&text(&rows))?,
            ListFormat::Json => print(&format!("{:#}\n", Value::Array(rows)))?,
        }
        Ok(Status::Good)
    }
}

fn formats() -> Vec<Value> {
    let row = |format: Format| {
        json!({
            "id": format.id(),
            "summary": format.summary(),
            "extensions": format.extensions(),
            "written": format.is_written(),
        })
    };
    Format::all().map(row).collect()
}

/// The ids and summaries in two columns.
fn text(rows: &[Value]) -> String {
    let of = |row: &Value, key: &str| row[key].as_str().unwrap_or_default().to_owned();
    let width = rows.iter().map(|row| of(row, "id").len()).max().unwrap_or(0);
    rows.iter().fold(String::new(), |mut text, row| {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{:width$}  {}", of(row, "id"), of(row, "summary"));
        text
    })
}
