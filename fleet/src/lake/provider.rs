//! The tables of a lake: exactly the files that its log names, read by the engine's own Parquet reader.

use super::{Entry, LakeError, Location, Part, Snapshot};
use crate::filter::{Condition, tests_of};
use crate::table::Table;
use async_trait::async_trait;
use datafusion::arrow::datatypes::{DataType, Field, FieldRef, SchemaRef};
use datafusion::catalog::{Session, TableProvider};
use datafusion::common::ScalarValue;
use datafusion::datasource::listing::PartitionedFile;
use datafusion::datasource::physical_plan::{FileGroup, FileScanConfigBuilder, ParquetSource};
use datafusion::datasource::source::DataSourceExec;
use datafusion::datasource::table_schema::TableSchema;
use datafusion::error::Result;
use datafusion::execution::runtime_env::RuntimeEnv;
use datafusion::logical_expr::{Expr, TableProviderFilterPushDown, TableType};
use datafusion::physical_plan::ExecutionPlan;
use datafusion::prelude::SessionContext;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A table of a lake.
#[derive(Debug)]
pub struct LakeTable {
    table: Table,
    location: Location,
    files: Vec<File>,
    schema: TableSchema,
}

/// A Parquet file, with the first and last time of its rows if they are known.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
struct File {
    part: Part,
    days: i32,
    span: Option<(i64, i64)>,
}

/// A table of a lake as plain data, which can be sent to another computer.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct LakeSpec {
    table: Table,
    lake: String,
    files: Vec<File>,
}

impl LakeTable {
    /// The table of a lake at the time of the snapshot.
    pub fn new(table: Table, location: Location, snapshot: &Snapshot) -> Self {
        let of_table = |entry: &Entry| {
            let span = entry.span;
            let parts = entry.parts.clone().into_iter().filter(move |part| part.table == table);
            parts.map(move |part| File { days: days(&part.date), part, span }).collect::<Vec<_>>()
        };
        Self::of_files(table, location, snapshot.entries.values().flat_map(of_table).collect())
    }

    /// The table from data sent by another computer.
    ///
    /// # Errors
    /// [`LakeError::Place`] if this computer does not know the store of the lake.
    pub fn of_spec(spec: LakeSpec, runtime: &RuntimeEnv) -> Result<Self, LakeError> {
        Ok(Self::of_files(spec.table, Location::of(&spec.lake, runtime)?, spec.files))
    }

    /// The table as data for another computer.
    pub fn spec(&self) -> LakeSpec {
        LakeSpec { table: self.table, lake: self.location.url.to_string(), files: self.files.clone() }
    }

    fn of_files(table: Table, location: Location, files: Vec<File>) -> Self {
        let date: FieldRef = Arc::new(Field::new("date", DataType::Date32, false));
        let schema = TableSchema::builder(table.schema()).with_table_partition_cols(vec![date]).build();
        Self { table, location, files, schema }
    }

    /// The kind of the table.
    pub const fn table(&self) -> Table {
        self.table
    }

    /// The paths of the table's files in the lake.
    pub fn paths(&self) -> impl Iterator<Item = String> {
        self.files.iter().map(|file| file.part.path())
    }

    /// The files that may have rows which pass the filters.
    fn chosen(&self, filters: &[Expr]) -> Vec<File> {
        let tests: Vec<_> =
            filters.iter().filter_map(|filter| tests_of(filter, self.schema.table_schema())).flatten().collect();
        let may_pass = |file: &&File| {
            tests.iter().all(|test| match (test.column.as_str(), &test.condition) {
                ("t", Condition::Between(low, high)) => file.span.is_none_or(|(first, last)| {
                    low.is_none_or(|low| low <= i128::from(last)) && high.is_none_or(|high| i128::from(first) <= high)
                }),
                ("date", condition) => condition.of_number(Some(i128::from(file.days))),
                _ => true,
            })
        };
        self.files.iter().filter(may_pass).cloned().collect()
    }

    fn partitioned(&self, file: &File) -> PartitionedFile {
        let path = self.location.path(&file.part.path());
        let mut file_of = PartitionedFile::new(path.to_string(), file.part.bytes);
        // The path as text was encoded a second time.
        file_of.object_meta.location = path;
        file_of.with_partition_values(vec![ScalarValue::Date32(Some(file.days))])
    }
}

/// Days since 1970.
fn days(date: &str) -> i32 {
    let parsed: Option<jiff::civil::Date> = date.parse().ok();
    let epoch = jiff::civil::date(1970, 1, 1);
    parsed.and_then(|date| epoch.until(date).ok()).map_or(0, |span| span.get_days())
}

#[async_trait]
impl TableProvider for LakeTable {
    fn schema(&self) -> SchemaRef {
        SchemaRef::clone(self.schema.table_schema())
    }

    fn table_type(&self) -> TableType {
        TableType::Base
    }

    /// Filters only skip files. The engine filters the rows of the other files, and passes its filters to the Parquet
    /// reader itself.
    fn supports_filters_pushdown(&self, filters: &[&Expr]) -> Result<Vec<TableProviderFilterPushDown>> {
        Ok(vec![TableProviderFilterPushDown::Inexact; filters.len()])
    }

    async fn scan(
        &self,
        state: &dyn Session,
        projection: Option<&Vec<usize>>,
        filters: &[Expr],
        limit: Option<usize>,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        let files: Vec<PartitionedFile> =
            self.chosen(filters).into_iter().map(|file| self.partitioned(&file)).collect();
        let groups = FileGroup::new(files).split_files(state.config().target_partitions());
        let options = state.config_options().execution.parquet.clone();
        let parquet = datafusion::config::TableParquetOptions { global: options, ..Default::default() };
        let source = ParquetSource::new(self.schema.clone()).with_table_parquet_options(parquet);
        let config = FileScanConfigBuilder::new(self.location.store_url()?, Arc::new(source))
            .with_file_groups(groups)
            .with_projection_indices(projection.cloned())?
            .with_limit(limit)
            .build();
        Ok(DataSourceExec::from_data_source(config))
    }
}

/// Registers the tables of a lake in a session. `frames` is a view of `messages`: the lake stores each frame once.
///
/// # Errors
/// [`LakeError`] if there is no lake or it can't be read.
pub async fn register(session: &SessionContext, lake: &str) -> Result<Snapshot> {
    let location = Location::of(lake, &session.runtime_env())?;
    let snapshot = Snapshot::read(&location).await?;
    if snapshot.version == 0 {
        return Err(LakeError::Missing(lake.to_owned()).into());
    }
    for table in Table::ALL.into_iter().filter(|table| *table != Table::Frames) {
        let provider = LakeTable::new(table, location.clone(), &snapshot);
        session.register_table(table.name(), Arc::new(provider))?;
    }
    let names: Vec<String> =
        Table::Frames.schema().fields().iter().map(|field| format!("\"{}\"", field.name())).collect();
    session
        .sql(&format!("CREATE VIEW frames AS SELECT {}, date FROM messages", names.join(", ")))
        .await?
        .collect()
        .await?;
    Ok(snapshot)
}
