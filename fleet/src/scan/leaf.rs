//! What the plans that read files have in common: no input, partitions, and work where waiting is allowed.

use datafusion::arrow::array::RecordBatch;
use datafusion::arrow::datatypes::SchemaRef;
use datafusion::error::{DataFusionError, Result};
use datafusion::execution::SendableRecordBatchStream;
use datafusion::physical_expr::EquivalenceProperties;
use datafusion::physical_plan::execution_plan::{Boundedness, EmissionType, SchedulingType};
use datafusion::physical_plan::stream::{RecordBatchReceiverStreamBuilder, RecordBatchStreamAdapter};
use datafusion::physical_plan::{Partitioning, PlanProperties};
use futures::TryStreamExt;
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::sync::mpsc::Sender;

/// So many batches wait for whoever takes them: memory is bounded.
const AHEAD: usize = 2;

/// The properties of a plan that reads so many partitions.
pub fn properties(schema: &SchemaRef, partitions: usize) -> Arc<PlanProperties> {
    let properties = PlanProperties::new(
        EquivalenceProperties::new(SchemaRef::clone(schema)),
        Partitioning::UnknownPartitioning(partitions),
        EmissionType::Incremental,
        Boundedness::Bounded,
    );
    Arc::new(properties.with_scheduling_type(SchedulingType::Cooperative))
}

/// The stream of a partition whose batches `work` sends. It begins when somebody asks for rows, and is told to end by its
/// channel being closed when nobody does any more.
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
