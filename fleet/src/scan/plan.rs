//! The execution plan of a scan: a partition for each capture, or for several where there are very many.

use super::emit::{Outlet, Wanted};
use super::{Source, leaf, produce};
use crate::capture::{Access, CaptureFile};
use crate::devices::Devices;
use crate::filter::Test;
use crate::table::Table;
use datafusion::arrow::array::RecordBatch;
use datafusion::arrow::datatypes::SchemaRef;
use datafusion::common::tree_node::TreeNodeRecursion;
use datafusion::common::{Statistics, stats::Precision};
use datafusion::error::{DataFusionError, Result};
use datafusion::execution::{SendableRecordBatchStream, TaskContext};
use datafusion::physical_expr::PhysicalExpr;
use datafusion::physical_plan::execution_plan::{ChildrenPropertiesMode, ReplaceChildrenOptions};
use datafusion::physical_plan::metrics::{BaselineMetrics, Count, ExecutionPlanMetricsSet, MetricBuilder, MetricsSet};
use datafusion::physical_plan::{DisplayAs, DisplayFormatType, ExecutionPlan, PlanProperties};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::sync::mpsc::Sender;

/// What a scan does: plain data, which can be sent to another computer.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct ScanSpec {
    /// The table.
    pub table: Table,
    /// The files of each partition.
    pub partitions: Vec<Vec<CaptureFile>>,
    /// The columns, by their places in the table.
    pub columns: Vec<usize>,
    /// What must hold of a row.
    pub tests: Vec<Test>,
    /// How many rows of each partition, at most.
    pub fetch: Option<usize>,
    /// What is known of the devices.
    pub devices: Devices,
}

/// Reads captures.
#[derive(Debug)]
pub struct CaptureScan {
    spec: Arc<ScanSpec>,
    schema: SchemaRef,
    properties: Arc<PlanProperties>,
    metrics: ExecutionPlanMetricsSet,
    /// Where it runs, where that is another computer than the one that asks.
    host: Option<Arc<str>>,
}

impl CaptureScan {
    /// The name of the counter of files that are no captures.
    pub const UNREADABLE: &'static str = "unreadable_files";

    /// A scan that does this.
    ///
    /// # Errors
    /// If a column is asked for that the table has not.
    pub fn new(spec: ScanSpec) -> Result<Self> {
        let schema: SchemaRef = Arc::new(spec.table.schema().project(&spec.columns)?);
        let properties = leaf::properties(&schema, spec.partitions.len());
        Ok(Self { spec: Arc::new(spec), schema, properties, metrics: ExecutionPlanMetricsSet::new(), host: None })
    }

    /// The same on a computer, whose name is told with every error.
    #[must_use]
    pub fn at(self, host: Option<Arc<str>>) -> Self {
        Self { host, ..self }
    }

    /// What it does.
    pub fn spec(&self) -> &ScanSpec {
        &self.spec
    }

    fn task(&self, partition: usize, context: &TaskContext) -> Task {
        Task {
            spec: Arc::clone(&self.spec),
            schema: SchemaRef::clone(&self.schema),
            partition,
            batch_rows: context.session_config().batch_size(),
            runtime: context.runtime_env(),
            metrics: BaselineMetrics::new(&self.metrics, partition),
            unreadable: MetricBuilder::new(&self.metrics).counter(Self::UNREADABLE, partition),
        }
    }
}

/// One partition under way.
struct Task {
    spec: Arc<ScanSpec>,
    schema: SchemaRef,
    partition: usize,
    batch_rows: usize,
    runtime: Arc<datafusion::execution::runtime_env::RuntimeEnv>,
    metrics: BaselineMetrics,
    unreadable: Count,
}

impl Task {
    /// Reads the files of the partition; runs where waiting is allowed.
    fn run(self, handle: &Handle, sender: Sender<Result<RecordBatch>>) -> Result<()> {
        let access = Access::new(self.runtime, handle.clone());
        let source = Source { access: &access, devices: &self.spec.devices };
        let mut outlet = Channel { sender, metrics: self.metrics, left: self.spec.fetch };
        for file in self.spec.partitions.get(self.partition).into_iter().flatten() {
            if outlet.left == Some(0) || !outlet.is_wanted() {
                break;
            }
            let wanted = Wanted {
                columns: &self.spec.columns,
                schema: &self.schema,
                tests: &self.spec.tests,
                fetch: outlet.left,
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

/// Sends batches to whoever polls the partition.
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
        let ScanSpec { table, partitions, tests, fetch, .. } = &*self.spec;
        let files: usize = partitions.iter().map(Vec::len).sum();
        let columns: Vec<&str> = self.schema.fields().iter().map(|field| field.name().as_str()).collect();
        write!(f, "CaptureScan: table={}, files={files}, columns=[{}]", table.name(), columns.join(", "))?;
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

    fn properties(&self) -> &Arc<PlanProperties> {
        &self.properties
    }

    fn children(&self) -> Vec<&Arc<dyn ExecutionPlan>> {
        Vec::new()
    }

    fn apply_expressions(
        &self,
        _: &mut dyn FnMut(&Arc<dyn PhysicalExpr>) -> Result<TreeNodeRecursion>,
    ) -> Result<TreeNodeRecursion> {
        Ok(TreeNodeRecursion::Continue)
    }

    fn replace_children(
        self: Arc<Self>,
        _: Vec<Arc<dyn ExecutionPlan>>,
        _: ReplaceChildrenOptions,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        Ok(self)
    }

    fn with_new_children(self: Arc<Self>, children: Vec<Arc<dyn ExecutionPlan>>) -> Result<Arc<dyn ExecutionPlan>> {
        self.replace_children(children, ReplaceChildrenOptions::new(ChildrenPropertiesMode::Recompute))
    }

    fn execute(&self, partition: usize, context: Arc<TaskContext>) -> Result<SendableRecordBatchStream> {
        let (task, host) = (self.task(partition, &context), self.host.clone());
        let on_host = move |error| match host {
            Some(host) => DataFusionError::Execution(format!("{host}: {error}")),
            None => error,
        };
        let work = move |handle: &Handle, sender| task.run(handle, sender).map_err(on_host);
        Ok(leaf::stream(SchemaRef::clone(&self.schema), work))
    }

    fn metrics(&self) -> Option<MetricsSet> {
        Some(self.metrics.clone_inner())
    }

    fn partition_statistics(&self, partition: Option<usize>) -> Result<Arc<Statistics>> {
        let mut statistics = Statistics::new_unknown(&self.schema);
        let files = match partition {
            Some(partition) => self.spec.partitions.get(partition).map_or(0, Vec::len),
            None => self.spec.partitions.iter().map(Vec::len).sum(),
        };
        // Each file is one row, read or not.
        if self.spec.table == Table::Captures && self.spec.tests.is_empty() && self.spec.fetch.is_none() {
            statistics.num_rows = Precision::Exact(files);
        }
        Ok(Arc::new(statistics))
    }

    fn supports_limit_pushdown(&self) -> bool {
        false
    }

    fn with_fetch(&self, limit: Option<usize>) -> Option<Arc<dyn ExecutionPlan>> {
        let spec = ScanSpec { fetch: limit, ..ScanSpec::clone(&self.spec) };
        Some(Arc::new(Self::new(spec).ok()?.at(self.host.clone())))
    }

    fn fetch(&self) -> Option<usize> {
        self.spec.fetch
    }
}
