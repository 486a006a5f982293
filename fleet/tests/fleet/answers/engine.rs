//! The engine under test: takes statements, returns rows as JSON.

use crate::sink::Shared;
use canvass_fleet::render::{Format, answer};
use canvass_fleet::scan::Options;
use canvass_fleet::session::{self, Settings};
use datafusion::prelude::SessionContext;
use serde_json::Value;
use std::path::Path;
use tokio::runtime::Runtime;

pub struct Engine {
    runtime: Runtime,
    session: SessionContext,
}

impl Engine {
    pub fn new() -> Self {
        Self::pushing(true)
    }

    /// An engine that applies filters before rows are made, or not.
    pub fn pushing(push_down: bool) -> Self {
        let mut scan = Options::default();
        scan.push_down = push_down;
        let settings = Settings { scan, ..Settings::default() };
        let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
        Self { session: session::local(&settings).unwrap(), runtime }
    }

    /// The rows of an answer.
    pub fn rows(&self, statement: &str) -> Vec<Value> {
        let batches = self.runtime.block_on(async {
            let answered = self.session.sql(statement).await;
            answered.unwrap_or_else(|error| panic!("{statement}: {error}")).collect().await
        });
        let batches = batches.unwrap_or_else(|error| panic!("{statement}: {error}"));
        let Some(first) = batches.first() else { return Vec::new() };
        let out = Shared::default();
        let mut rendered = answer(Format::Json, &first.schema(), Box::new(out.clone())).unwrap();
        batches.iter().for_each(|batch| rendered.batch(batch).unwrap());
        rendered.finish().unwrap();
        let text = String::from_utf8(out.0.lock().unwrap().clone()).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// All rows of a table of one capture, in their order.
    pub fn table(&self, table: &str, capture: &Path) -> Vec<Value> {
        self.rows(&format!("SELECT * FROM {table}('{}')", capture.display()))
    }
}
