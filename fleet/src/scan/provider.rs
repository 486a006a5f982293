//! A table of captures: its files, its columns, and the part of a filter that is applied before rows are made.

use super::{CaptureScan, Options, ScanError, ScanSpec};
use crate::capture::{CaptureFile, find};
use crate::devices::Devices;
use crate::filter::{Test, tests_of};
use crate::table::Table;
use async_trait::async_trait;
use datafusion::arrow::datatypes::SchemaRef;
use datafusion::catalog::{Session, TableProvider};
use datafusion::error::Result;
use datafusion::logical_expr::{Expr, TableProviderFilterPushDown, TableType};
use datafusion::physical_plan::ExecutionPlan;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A table of captures or results.
#[derive(Debug)]
pub struct CaptureTable {
    table: Table,
    files: Files,
    schema: SchemaRef,
    push_down: bool,
    devices: Devices,
}

/// The files of a table.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub enum Files {
    /// The files that match these patterns when a query is planned.
    Patterns(Vec<String>),
    /// A list of files.
    Known(Vec<CaptureFile>),
}

/// Number of scan partitions for each partition that the engine wants; each partition has one capture open at a time.
const PARTITIONS: usize = 4;

impl CaptureTable {
    /// A table of these files.
    ///
    /// # Errors
    /// If a rule of `canvass.devices` can't be used.
    pub fn new(table: Table, files: Files, options: &Options) -> Result<Self> {
        let devices = if table.is_of_results() { Devices::default() } else { options.devices()? };
        Ok(Self::of_devices(table, files, devices, options.push_down))
    }

    /// A table of these files, with rules of devices that were read already.
    pub fn of_devices(table: Table, files: Files, devices: Devices, push_down: bool) -> Self {
        Self { table, files, schema: table.schema(), push_down, devices }
    }

    /// The kind of the table.
    pub const fn table(&self) -> Table {
        self.table
    }

    /// The files of the table.
    pub const fn files(&self) -> &Files {
        &self.files
    }

    /// The rules of devices.
    pub const fn devices(&self) -> &Devices {
        &self.devices
    }

    /// Whether filters are applied before rows are made.
    pub const fn pushes_down(&self) -> bool {
        self.push_down
    }

    async fn find(&self, state: &dyn Session) -> Result<Vec<CaptureFile>> {
        let patterns = match &self.files {
            Files::Known(files) => return Ok(files.clone()),
            Files::Patterns(patterns) => patterns,
        };
        let mut files = Vec::new();
        for pattern in patterns {
            files.extend(find(pattern, state.runtime_env()).await.map_err(ScanError::from)?);
        }
        Ok(files)
    }
}

#[async_trait]
impl TableProvider for CaptureTable {
    fn schema(&self) -> SchemaRef {
        SchemaRef::clone(&self.schema)
    }

    fn table_type(&self) -> TableType {
        TableType::Base
    }

    fn supports_filters_pushdown(&self, filters: &[&Expr]) -> Result<Vec<TableProviderFilterPushDown>> {
        let is_test = |filter: &&Expr| self.push_down && tests_of(filter, &self.schema).is_some();
        Ok(filters
            .iter()
            .map(|filter| match is_test(filter) {
                true => TableProviderFilterPushDown::Exact,
                false => TableProviderFilterPushDown::Unsupported,
            })
            .collect())
    }

    async fn scan(
        &self,
        state: &dyn Session,
        projection: Option<&Vec<usize>>,
        filters: &[Expr],
        limit: Option<usize>,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        let tests: Vec<Test> = filters.iter().filter_map(|filter| tests_of(filter, &self.schema)).flatten().collect();
        let mut files = self.find(state).await?;
        let of_capture = |test: &&Test| test.column == self.file_column();
        files.retain(|file| tests.iter().filter(of_capture).all(|test| test.condition.of_text(Some(&file.name))));
        let columns = projection.cloned().unwrap_or_else(|| (0..self.schema.fields().len()).collect());
        let most = state.config().target_partitions().saturating_mul(PARTITIONS);
        let fetch = limit.filter(|_| self.push_down);
        let (table, devices) = (self.table, self.devices.clone());
        let spec = ScanSpec { table, columns, tests, fetch, skips: self.push_down, devices };
        Ok(Arc::new(CaptureScan::new(spec, super::files::plan(&partitions(files, most))?)?))
    }
}

impl CaptureTable {
    /// The name of the column that names the file.
    const fn file_column(&self) -> &'static str {
        if self.table.is_of_results() { "run" } else { "capture" }
    }
}

/// A partition for each file; at most `most` partitions, with about the same number of bytes in each.
pub fn partitions(files: Vec<CaptureFile>, most: usize) -> Vec<Vec<CaptureFile>> {
    if files.len() <= most {
        return files.into_iter().map(|file| vec![file]).collect();
    }
    let mut partitions = vec![(0_u64, Vec::new()); most.max(1)];
    let mut largest_first = files;
    largest_first.sort_by_key(|file| std::cmp::Reverse(file.size));
    for file in largest_first {
        if let Some(emptiest) = partitions.iter_mut().min_by_key(|partition| partition.0) {
            // Opening a file takes time, however short the file is.
            emptiest.0 += file.size + 4096;
            emptiest.1.push(file);
        }
    }
    partitions.into_iter().map(|(_, files)| files).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_in_one_partition() {
        let files: Vec<CaptureFile> = (0..100_u64)
            .map(|n| CaptureFile { name: format!("{n}.log"), path: None, size: n * 1_000_000, modified: 0 })
            .collect();
        assert_eq!(partitions(files.clone(), 100).len(), 100);
        let shared = partitions(files.clone(), 8);
        let sizes: Vec<u64> = shared.iter().map(|files| files.iter().map(|file| file.size).sum()).collect();
        assert_eq!(sizes.len(), 8);
        assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() < 100_000_000, "{sizes:?}");
        let mut all: Vec<CaptureFile> = shared.into_iter().flatten().collect();
        all.sort_by_key(|file| file.size);
        assert_eq!(all, files);
    }
}
