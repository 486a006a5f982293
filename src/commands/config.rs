//! `canvass config`: the settings in force, and their sources.

use crate::live::CLIENT;
use crate::output::print;
use crate::reconnect::RECONNECT;
use crate::settings::{BUS_VARIABLE, Setting, Settings};
use crate::status::{Failure, Status};
use crate::timing;
use canvass_reports::escape::Printable;
use canvass_suite::bench::Timing;
use serde_json::json;
use std::fmt::Write;

/// Show bus, node, device, waivers, timeouts and thresholds in force, and where each comes from
///
/// The settings come from the nearest canvass.toml, in this folder or one above it. The environment variable
/// `CANVASS_BUS` overrides its bus. Options on the command line override both.
#[derive(clap::Args)]
pub struct Args {
    /// How to print the settings
    #[arg(long, value_enum, default_value_t)]
    format: ConfigFormat,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum ConfigFormat {
    /// For people, on a terminal
    #[default]
    Table,
    /// The documented JSON contract
    Json,
}

/// A setting with its value and source.
struct SettingRow {
    key: String,
    /// The value; `None` if nothing sets it.
    value: Option<String>,
    from: String,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let rows = rows(Settings::find()?.as_ref());
        match self.format {
            ConfigFormat::Table => print(&Printable::document(&table(&rows)))?,
            ConfigFormat::Json => print(&Printable::pretty_json(&document(&rows)))?,
        }
        Ok(Status::Good)
    }
}

fn rows(settings: Option<&Settings>) -> Vec<SettingRow> {
    let none = || SettingRow { key: String::new(), value: None, from: "not set".to_owned() };
    let mut rows: Vec<SettingRow> =
        ["bus", "node", "device", "waivers"].map(|key| SettingRow { key: key.to_owned(), ..none() }).into();
    let usual = timing::told(&Timing::default(), CLIENT, RECONNECT);
    rows.extend(usual.iter().filter_map(|told| told.split_once('=')).map(|(what, span)| SettingRow {
        key: format!("timeouts.{what}"),
        value: Some(span.to_owned()),
        from: "default".to_owned(),
    }));
    if let Some(Settings { path, settings }) = settings {
        for Setting { key, value, line } in settings {
            let row =
                SettingRow { key: key.clone(), value: Some(value.clone()), from: format!("{}:{line}", path.display()) };
            match rows.iter_mut().find(|known| known.key == *key) {
                Some(known) => *known = row,
                None => rows.push(row),
            }
        }
    }
    if let (Some(bus), Ok(value)) = (rows.first_mut(), std::env::var(BUS_VARIABLE)) {
        (bus.value, bus.from) = (Some(value), format!("the environment ({BUS_VARIABLE})"));
    }
    rows
}

fn table(rows: &[SettingRow]) -> String {
    let width = |of: fn(&SettingRow) -> usize| rows.iter().map(of).max().unwrap_or_default();
    let keys = width(|row| row.key.chars().count());
    let values = width(|row| row.value.as_deref().unwrap_or("-").chars().count());
    let mut text = String::new();
    for SettingRow { key, value, from } in rows {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{key:keys$}  {:values$}  {from}", value.as_deref().unwrap_or("-"));
    }
    text
}

fn document(rows: &[SettingRow]) -> serde_json::Value {
    let rows: Vec<_> = rows
        .iter()
        .map(|SettingRow { key, value, from }| json!({ "key": key, "value": value, "from": from }))
        .collect();
    json!({ "schema": "canvass/config/1", "settings": rows })
}
