//! `canvass-fleet schema`: the tables and their columns.

use crate::output::print;
use crate::status::{Failure, Status};
use canvass_fleet::table::{SCHEMA_VERSION, Table};

/// Show the tables and their columns
#[derive(clap::Args)]
pub struct Args {
    /// Only this table
    #[arg(value_name = "TABLE", value_parser = parse_table)]
    table: Option<Table>,
    /// As Markdown, for docs/fleet.md
    #[arg(long)]
    markdown: bool,
}

fn parse_table(name: &str) -> Result<Table, String> {
    Table::by_name(name).ok_or_else(|| {
        let names: Vec<&str> = Table::ALL.into_iter().map(Table::name).collect();
        format!("expected one of {}", names.join(", "))
    })
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        if self.markdown {
            print(canvass_fleet::table::markdown().trim_end())?;
            return Ok(Status::Good);
        }
        let tables = self.table.map_or_else(|| Table::ALL.to_vec(), |table| vec![table]);
        let texts: Vec<String> = tables.into_iter().map(text).collect();
        print(&format!("schema version {SCHEMA_VERSION}\n\n{}", texts.join("\n\n")))?;
        Ok(Status::Good)
    }
}

/// A table with its columns, aligned.
pub fn text(table: Table) -> String {
    let columns = table.columns();
    let width = columns.iter().map(|column| column.field.name().len()).max().unwrap_or(0);
    let line = |column: &canvass_fleet::table::Described| {
        let (name, kind) = (column.field.name(), canvass_fleet::table::type_name(column.field.data_type()));
        format!("  {name:width$}  {kind:9}  {}", column.doc)
    };
    let lines: Vec<String> = columns.iter().map(line).collect();
    format!("{}: {}\n{}", table.name(), table.doc(), lines.join("\n"))
}
