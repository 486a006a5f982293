//! Common parts of the plans that read files: their input is a row for each file, and they read in blocking tasks.
//!
//! The files are a plan of their own, as rows in memory: Ballista gives each task only its own partitions of such a
//! plan. If Ballista did not know the kind of the plan, each task would get all partitions.

use crate::capture::CaptureFile;
use datafusion::arrow::array::{Array as _, ArrayRef, AsArray as _, Int64Array, RecordBatch, StringArray, UInt64Array};
use datafusion::arrow::datatypes::{DataType, Field, Int64Type, Schema, SchemaRef, UInt64Type};
use datafusion::datasource::memory::MemorySourceConfig;
use datafusion::datasource::source::DataSourceExec;
use datafusion::error::{DataFusionError, Result};
use datafusion::execution::SendableRecordBatchStream;
use datafusion::physical_expr::EquivalenceProperties;
use datafusion::physical_plan::execution_plan::{Boundedness, EmissionType, SchedulingType};
use datafusion::physical_plan::stream::{RecordBatchReceiverStreamBuilder, RecordBatchStreamAdapter};
use datafusion::physical_plan::{ExecutionPlan, Partitioning, PlanProperties};
use futures::TryStreamExt;
use std::any::Any;
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::sync::mpsc::Sender;

/// Maximum number of batches that wait for the reader; it limits the memory.
const AHEAD: usize = 2;

/// Methods that all plans which read files have in common.
macro_rules! reads_files {
    () => {
        fn properties(&self) -> &Arc<PlanProperties> {
            &self.properties
        }

        fn children(&self) -> Vec<&Arc<dyn ExecutionPlan>> {
            vec![&self.input]
        }

        /// The files are already distributed over the partitions.
        fn benefits_from_input_partitioning(&self) -> Vec<bool> {
            vec![false]
        }

        fn apply_expressions(
            &self,
            _: &mut dyn FnMut(
                &Arc<dyn datafusion::physical_expr::PhysicalExpr>,
            ) -> Result<datafusion::common::tree_node::TreeNodeRecursion>,
        ) -> Result<datafusion::common::tree_node::TreeNodeRecursion> {
            Ok(datafusion::common::tree_node::TreeNodeRecursion::Continue)
        }

        fn with_new_children(self: Arc<Self>, children: Vec<Arc<dyn ExecutionPlan>>) -> Result<Arc<dyn ExecutionPlan>> {
            let mode = datafusion::physical_plan::execution_plan::ChildrenPropertiesMode::Recompute;
            self.replace_children(children, ReplaceChildrenOptions::new(mode))
        }
    };
}
pub(crate) use reads_files;

fn schema() -> SchemaRef {
    let columns = [
        Field::new("name", DataType::Utf8, false),
        Field::new("path", DataType::Utf8, true),
        Field::new("size", DataType::UInt64, false),
        Field::new("modified", DataType::Int64, false),
    ];
    Arc::new(Schema::new(columns.to_vec()))
}

/// Files as a plan: a partition for each list.
///
/// # Errors
/// If Arrow refuses the rows, which would be a bug of this module.
pub fn plan(partitions: &[Vec<CaptureFile>]) -> Result<Arc<dyn ExecutionPlan>> {
    let mut batches = partitions.iter().map(|files| Ok(vec![batch(files)?])).collect::<Result<Vec<_>>>()?;
    // The engine needs at least one partition.
    if batches.is_empty() {
        batches.push(Vec::new());
    }
    Ok(DataSourceExec::from_data_source(MemorySourceConfig::try_new(&batches, schema(), None)?))
}

fn batch(files: &[CaptureFile]) -> Result<RecordBatch> {
    let names: ArrayRef = Arc::new(files.iter().map(|file| Some(&*file.name)).collect::<StringArray>());
    let paths: ArrayRef = Arc::new(files.iter().map(|file| file.path.as_deref()).collect::<StringArray>());
    let sizes: ArrayRef = Arc::new(files.iter().map(|file| file.size).collect::<UInt64Array>());
    let modified: ArrayRef = Arc::new(files.iter().map(|file| file.modified).collect::<Int64Array>());
    Ok(RecordBatch::try_new(schema(), vec![names, paths, sizes, modified])?)
}

/// The files in one partition of a [`plan`] of files. The call blocks.
///
/// # Errors
/// If the plan has other columns.
pub fn listed(input: SendableRecordBatchStream, handle: &Handle) -> Result<Vec<CaptureFile>> {
    let batches: Vec<RecordBatch> = handle.block_on(input.try_collect())?;
    let mut files = Vec::new();
    for batch in &batches {
        let other =
            || DataFusionError::Plan("expected a plan of files: their names, paths, sizes and times".to_owned());
        let columns = (batch.num_columns() == 4).then(|| [0, 1, 2, 3].map(|at| batch.column(at))).ok_or_else(other)?;
        let names = columns[0].as_string_opt::<i32>().ok_or_else(other)?;
        let paths = columns[1].as_string_opt::<i32>().ok_or_else(other)?;
        let sizes = columns[2].as_primitive_opt::<UInt64Type>().ok_or_else(other)?;
        let modified = columns[3].as_primitive_opt::<Int64Type>().ok_or_else(other)?;
        let file = |row| CaptureFile {
            name: names.value(row).to_owned(),
            path: paths.is_valid(row).then(|| paths.value(row).to_owned()),
            size: sizes.value(row),
            modified: modified.value(row),
        };
        files.extend((0..batch.num_rows()).map(file));
    }
    Ok(files)
}

/// Number of files that a [`plan`] of files names, in all partitions or in one; `None` for another plan.
pub fn count(plan: &Arc<dyn ExecutionPlan>, partition: Option<usize>) -> Option<usize> {
    let source: &dyn Any = plan.downcast_ref::<DataSourceExec>()?.data_source().as_ref();
    let partitions = source.downcast_ref::<MemorySourceConfig>()?.partitions();
    let chosen = match partition {
        Some(partition) => std::slice::from_ref(partitions.get(partition)?),
        None => partitions,
    };
    Some(chosen.iter().flatten().map(RecordBatch::num_rows).sum())
}

/// The only input of a plan that reads files.
///
/// # Errors
/// If there is no input or more than one.
pub fn only(inputs: Vec<Arc<dyn ExecutionPlan>>) -> Result<Arc<dyn ExecutionPlan>> {
    <[_; 1]>::try_from(inputs)
        .map(|[input]| input)
        .map_err(|inputs| DataFusionError::Plan(format!("expected one plan of files, found {}", inputs.len())))
}

/// The properties of a plan that reads the files of its input.
pub fn properties(schema: &SchemaRef, input: &Arc<dyn ExecutionPlan>) -> Arc<PlanProperties> {
    let partitions = input.properties().output_partitioning().partition_count();
    let properties = PlanProperties::new(
        EquivalenceProperties::new(SchemaRef::clone(schema)),
        Partitioning::UnknownPartitioning(partitions),
        EmissionType::Incremental,
        Boundedness::Bounded,
    );
    Arc::new(properties.with_scheduling_type(SchedulingType::Cooperative))
}

/// The stream of a partition whose batches `work` sends. The work begins with the first request for rows; the channel
/// closes when nobody wants rows any more, which ends the work.
pub fn stream(
    schema: SchemaRef,
    work: impl FnOnce(&Handle, Sender<Result<RecordBatch>>) -> Result<()> + Send + 'static,
) -> SendableRecordBatchStream {
    let of_stream = SchemaRef::clone(&schema);
    let stream = futures::stream::once(async move {
        let mut builder = RecordBatchReceiverStreamBuilder::new(of_stream, AHEAD);
        let (sender, handle) = (builder.tx(), Handle::current());
        builder.spawn_blocking(move || work(&handle, sender));
        Ok::<_, DataFusionError>(builder.build())
    });
    Box::pin(RecordBatchStreamAdapter::new(schema, stream.try_flatten()))
}
