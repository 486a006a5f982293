//! The execution plan of a scan: one partition for each capture, or for several captures if there are very many.

use super::emit::{Outlet, Wanted};
use super::{Source, files, produce};
use crate::capture::Access;
use crate::devices::Devices;
use crate::filter::Test;
use crate::table::Table;
use datafusion::arrow::array::RecordBatch;
use datafusion::arrow::datatypes::SchemaRef;
use datafusion::common::{Statistics, stats::Precision};
use datafusion::error::{DataFusionError, Result};
use datafusion::execution::{SendableRecordBatchStream, TaskContext};
use datafusion::physical_plan::execution_plan::ReplaceChildrenOptions;
use datafusion::physical_plan::metrics::{BaselineMetrics, Count, ExecutionPlanMetricsSet, MetricBuilder, MetricsSet};
use datafusion::physical_plan::{DisplayAs, DisplayFormatType, ExecutionPlan, PlanProperties};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::sync::mpsc::Sender;

/// The parameters of a scan: plain data, which can be sent to another computer.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct ScanSpec {
    /// The table.
    pub table: Table,
    /// The columns, by their indexes in the table.
    pub columns: Vec<usize>,
    /// The tests that a row must pass.
    pub tests: Vec<Test>,
    /// Maximum number of rows of each partition.
    pub fetch: Option<usize>,
    /// Whether the scan skips frames that give no rows and change no state.
    pub skips: bool,
    /// The rules of devices.
    pub devices: Devices,
}

/// Reads captures: the files that its input names.
#[derive(Debug)]
pub struct CaptureScan {
    spec: Arc<ScanSpec>,
    input: Arc<dyn ExecutionPlan>,
    schema: SchemaRef,
    properties: Arc<PlanProperties>,
    metrics: ExecutionPlanMetricsSet,
    /// The name of the computer on which the scan runs, if another computer made the query.
    host: Option<Arc<str>>,
}

impl CaptureScan {
    /// The name of the counter of files that are no captures.
    pub const UNREADABLE: &'static str = "unreadable_files";

    /// A scan of the files of a [`files::plan`].
    ///
    /// # Errors
    /// If the table lacks a requested column.
    pub fn new(spec: ScanSpec, input: Arc<dyn ExecutionPlan>) -> Result<Self> {
        let schema: SchemaRef = Arc::new(spec.table.schema().project(&spec.columns)?);
        let (spec, properties) = (Arc::new(spec), files::properties(&schema, &input));
        Ok(Self { spec, input, schema, properties, metrics: ExecutionPlanMetricsSet::new(), host: None })
    }

    /// Sets the name of the computer, which every error then names.
    #[must_use]
    pub fn at(self, host: Option<Arc<str>>) -> Self {
        Self { host, ..self }
    }

    /// The parameters of the scan.
    pub fn spec(&self) -> &ScanSpec {
        &self.spec
    }

    /// Number of files, if known.
    fn files(&self, partition: Option<usize>) -> Option<usize> {
        files::count(&self.input, partition)
    }

    fn task(&self, partition: usize, context: &TaskContext) -> Task {
        Task {
            spec: Arc::clone(&self.spec),
            schema: SchemaRef::clone(&self.schema),
            batch_rows: context.session_config().batch_size(),
            runtime: context.runtime_env(),
            metrics: BaselineMetrics::new(&self.metrics, partition),
            unreadable: MetricBuilder::new(&self.metrics).counter(Self::UNREADABLE, partition),
        }
    }
}

/// The work on one partition.
struct Task {
    spec: Arc<ScanSpec>,
    schema: SchemaRef,
    batch_rows: usize,
    runtime: Arc<datafusion::execution::runtime_env::RuntimeEnv>,
    metrics: BaselineMetrics,
    unreadable: Count,
}

impl Task {
    /// Reads the files of the partition; blocks.
    fn run(self, input: SendableRecordBatchStream, handle: &Handle, sender: Sender<Result<RecordBatch>>) -> Result<()> {
        let access = Access::new(self.runtime, handle.clone());
        let source = Source { access: &access, devices: &self.spec.devices };
        let mut outlet = Channel { sender, metrics: self.metrics, left: self.spec.fetch };
        for file in &files::listed(input, handle)? {
            if outlet.left == Some(0) || !outlet.is_wanted() {
                break;
            }
            let wanted = Wanted {
                columns: &self.spec.columns,
                schema: &self.schema,
                tests: &self.spec.tests,
                fetch: outlet.left,
                skips: self.spec.skips,
                batch_rows: self.batch_rows,
            };
            if !produce(&source, self.spec.table, file, wanted, &mut outlet)? {
                self.unreadable.add(1);
            }
        }
        outlet.metrics.done();
        Ok(())
    }
}

/// Sends batches to the reader of the partition.
struct Channel {
    sender: Sender<Result<RecordBatch>>,
    metrics: BaselineMetrics,
    left: Option<usize>,
}

impl Outlet for Channel {
    fn give(&mut self, batch: RecordBatch) -> ControlFlow<()> {
        self.metrics.record_output(batch.num_rows());
        self.left = self.left.map(|left| left.saturating_sub(batch.num_rows()));
        match self.sender.blocking_send(Ok(batch)) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    }

    fn is_wanted(&self) -> bool {
        !self.sender.is_closed()
    }
}

impl DisplayAs for CaptureScan {
    fn fmt_as(&self, _: DisplayFormatType, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ScanSpec { table, tests, fetch, .. } = &*self.spec;
        let files = self.files(None).map_or(String::new(), |files| format!(", files={files}"));
        let columns: Vec<&str> = self.schema.fields().iter().map(|field| field.name().as_str()).collect();
        write!(f, "CaptureScan: table={}{files}, columns=[{}]", table.name(), columns.join(", "))?;
        if !tests.is_empty() {
            let tested: Vec<&str> = tests.iter().map(|test| test.column.as_str()).collect();
            write!(f, ", tests=[{}]", tested.join(", "))?;
        }
        fetch.map_or(Ok(()), |fetch| write!(f, ", fetch={fetch}"))
    }
}

impl ExecutionPlan for CaptureScan {
    fn name(&self) -> &'static str {
        "CaptureScan"
    }

    files::reads_files!();

    fn replace_children(
        self: Arc<Self>,
        children: Vec<Arc<dyn ExecutionPlan>>,
        _: ReplaceChildrenOptions,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        let input = files::only(children)?;
        Ok(Arc::new(Self::new(ScanSpec::clone(&self.spec), input)?.at(self.host.clone())))
    }

    fn execute(&self, partition: usize, context: Arc<TaskContext>) -> Result<SendableRecordBatchStream> {
        let (task, host) = (self.task(partition, &context), self.host.clone());
        let input = self.input.execute(partition, context)?;
        let on_host = move |error| match host {
            Some(host) => DataFusionError::Execution(format!("{host}: {error}")),
            None => error,
        };
        let work = move |handle: &Handle, sender| task.run(input, handle, sender).map_err(on_host);
        Ok(files::stream(SchemaRef::clone(&self.schema), work))
    }

    fn metrics(&self) -> Option<MetricsSet> {
        Some(self.metrics.clone_inner())
    }

    fn partition_statistics(&self, partition: Option<usize>) -> Result<Arc<Statistics>> {
        let mut statistics = Statistics::new_unknown(&self.schema);
        // A capture has one row, whether it is readable or not.
        if self.spec.table == Table::Captures && self.spec.tests.is_empty() && self.spec.fetch.is_none() {
            statistics.num_rows = self.files(partition).map_or(Precision::Absent, Precision::Exact);
        }
        Ok(Arc::new(statistics))
    }

    fn supports_limit_pushdown(&self) -> bool {
        false
    }

    fn with_fetch(&self, limit: Option<usize>) -> Option<Arc<dyn ExecutionPlan>> {
        let (spec, input) = (ScanSpec { fetch: limit, ..ScanSpec::clone(&self.spec) }, Arc::clone(&self.input));
        Some(Arc::new(Self::new(spec, input).ok()?.at(self.host.clone())))
    }

    fn fetch(&self) -> Option<usize> {
        self.spec.fetch
    }
}
