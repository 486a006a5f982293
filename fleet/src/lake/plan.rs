//! Ingesting as a plan: partitions of files, and a result row for each file put into the lake. So an ingest runs in one
//! process or on a cluster.

use super::one_file::Ingester;
use super::{Location, rules};
use crate::capture::{Access, CaptureFile};
use crate::devices::Devices;
use crate::scan::{Source, files};
use async_trait::async_trait;
use datafusion::arrow::array::{ArrayRef, RecordBatch, StringArray};
use datafusion::arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use datafusion::catalog::{Session, TableProvider};
use datafusion::error::{DataFusionError, Result};
use datafusion::execution::runtime_env::RuntimeEnv;
use datafusion::execution::{SendableRecordBatchStream, TaskContext};
use datafusion::logical_expr::{Expr, TableType};
use datafusion::physical_plan::execution_plan::ReplaceChildrenOptions;
use datafusion::physical_plan::{DisplayAs, DisplayFormatType, ExecutionPlan, PlanProperties};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::sync::mpsc::Sender;

/// The parameters of an ingest: plain data, which can be sent to another computer.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct IngestSpec {
    /// The lake: a path or a URL.
    pub lake: String,
    /// The rules of devices.
    pub devices: Devices,
}

/// The only column: the entry of a file, as JSON.
fn schema() -> SchemaRef {
    Arc::new(Schema::new(vec![Field::new("entry", DataType::Utf8, false)]))
}

/// Puts the files that its input names into a lake, and outputs their entries. The caller commits the entries; only
/// then the files belong to the lake.
#[derive(Debug)]
pub struct IngestScan {
    spec: Arc<IngestSpec>,
    input: Arc<dyn ExecutionPlan>,
    properties: Arc<PlanProperties>,
}

impl IngestScan {
    /// An ingest of the files of a [`files::plan`].
    pub fn new(spec: IngestSpec, input: Arc<dyn ExecutionPlan>) -> Self {
        let properties = files::properties(&schema(), &input);
        Self { spec: Arc::new(spec), input, properties }
    }

    /// The parameters of the ingest.
    pub fn spec(&self) -> &IngestSpec {
        &self.spec
    }
}

/// Puts the files of a partition into the lake, one after the other.
fn run(
    spec: &IngestSpec,
    input: SendableRecordBatchStream,
    runtime: Arc<RuntimeEnv>,
    handle: &Handle,
    sender: &Sender<Result<RecordBatch>>,
) -> Result<()> {
    let location = Location::of(&spec.lake, &runtime)?;
    let access = Access::new(runtime, handle.clone());
    let source = Source { access: &access, devices: &spec.devices };
    let ingester = Ingester { source, location: &location, rules: &rules(&spec.devices), handle: handle.clone() };
    for file in &files::listed(input, handle)? {
        if sender.is_closed() {
            break;
        }
        let entry = ingester.ingest(file)?;
        let json = serde_json::to_string(&entry).map_err(|error| DataFusionError::External(Box::new(error)))?;
        let column: ArrayRef = Arc::new(StringArray::from(vec![json]));
        // The channel is closed: the run was stopped.
        if sender.blocking_send(Ok(RecordBatch::try_new(schema(), vec![column])?)).is_err() {
            break;
        }
    }
    Ok(())
}

impl DisplayAs for IngestScan {
    fn fmt_as(&self, _: DisplayFormatType, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "IngestScan: lake={}", self.spec.lake)
    }
}

impl ExecutionPlan for IngestScan {
    fn name(&self) -> &'static str {
        "IngestScan"
    }

    files::reads_files!();

    fn replace_children(
        self: Arc<Self>,
        children: Vec<Arc<dyn ExecutionPlan>>,
        _: ReplaceChildrenOptions,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        Ok(Arc::new(Self::new(IngestSpec::clone(&self.spec), files::only(children)?)))
    }

    fn execute(&self, partition: usize, context: Arc<TaskContext>) -> Result<SendableRecordBatchStream> {
        let (spec, runtime) = (Arc::clone(&self.spec), context.runtime_env());
        let input = self.input.execute(partition, context)?;
        Ok(files::stream(schema(), move |handle, sender| run(&spec, input, runtime, handle, &sender)))
    }
}

/// An ingest as a table; a query of all its rows runs the ingest.
#[derive(Debug)]
pub struct IngestTable {
    spec: IngestSpec,
    partitions: Vec<Vec<CaptureFile>>,
}

impl IngestTable {
    /// An ingest of these files.
    pub const fn new(spec: IngestSpec, partitions: Vec<Vec<CaptureFile>>) -> Self {
        Self { spec, partitions }
    }

    /// The files of each partition.
    pub fn partitions(&self) -> &[Vec<CaptureFile>] {
        &self.partitions
    }

    /// The parameters of the ingest.
    pub const fn spec(&self) -> &IngestSpec {
        &self.spec
    }
}

#[async_trait]
impl TableProvider for IngestTable {
    fn schema(&self) -> SchemaRef {
        schema()
    }

    fn table_type(&self) -> TableType {
        TableType::Temporary
    }

    async fn scan(
        &self,
        _: &dyn Session,
        _: Option<&Vec<usize>>,
        _: &[Expr],
        _: Option<usize>,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        Ok(Arc::new(IngestScan::new(self.spec.clone(), files::plan(&self.partitions)?)))
    }
}
