//! Tables of a capture as Arrow streams (the PyCapsule interface): pandas, Polars, PyArrow and DuckDB read them.

use crate::capture::{Origin, Reading};
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{RecordBatch, RecordBatchReader};
use arrow_schema::ffi::FFI_ArrowSchema;
use arrow_schema::{ArrowError, Field, Schema, SchemaRef};
use canvass_tables::builder::BatchBuilder;
use canvass_tables::column::{Column, Rows};
use canvass_tables::decoded_frame::DecodedFrame;
use canvass_tables::event_collector::EventCollector;
use canvass_tables::events::Events;
use canvass_tables::frames::{FrameRow, Frames};
use canvass_tables::messages::Messages;
use canvass_tables::signals::{SignalRow, Signals};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::convert::Infallible;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Number of rows of a batch.
const BATCH: usize = 1 << 16;

/// The tables of a capture.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Frames,
    Messages,
    Events,
    Signals,
}

impl Kind {
    pub fn by_name(name: &str) -> Option<Self> {
        Some(match name {
            "frames" => Self::Frames,
            "messages" => Self::Messages,
            "events" => Self::Events,
            "signals" => Self::Signals,
            _ => return None,
        })
    }

    fn schema(self) -> SchemaRef {
        match self {
            Self::Frames => schema::<Frames>(),
            Self::Messages => schema::<Messages>(),
            Self::Events => schema::<Events>(),
            Self::Signals => schema::<Signals>(),
        }
    }
}

fn schema<R: Rows>() -> SchemaRef {
    let fields: Vec<Field> = R::COLUMNS.iter().map(Column::field).collect();
    Arc::new(Schema::new(fields))
}

fn builder<R: Rows>() -> BatchBuilder<R> {
    let columns: Vec<usize> = (0..R::COLUMNS.len()).collect();
    BatchBuilder::new(schema::<R>(), &columns)
}

/// A table of a capture.
///
/// Any library that knows Arrow's PyCapsule interface reads it: `pandas.DataFrame.from_arrow(table)`,
/// `polars.DataFrame(table)`, `pyarrow.table(table)`, `duckdb.sql("SELECT * FROM table")`. The capture is read while the
/// library asks for rows, each time from its beginning.
#[pyclass(frozen, module = "canvass")]
pub struct Table {
    pub kind: Kind,
    pub origin: Origin,
}

#[pymethods]
impl Table {
    /// The table as a stream of record batches.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A producer may ignore the wish for another schema.
        let _ = requested_schema;
        let rows =
            RowsOf { capture: self.origin.name(), reading: self.origin.open()?, filling: Filling::new(self.kind) };
        let stream = FFI_ArrowArrayStream::new(Box::new(rows));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }

    /// The schema of the table.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.kind.schema().as_ref())
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    /// The names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.kind.schema().fields().iter().map(|field| field.name().clone()).collect()
    }
}

/// The rows of a table while the capture is read.
struct RowsOf {
    capture: String,
    reading: Reading,
    filling: Filling,
}

/// The batch that is being filled.
enum Filling {
    Frames(BatchBuilder<Frames>),
    Messages(BatchBuilder<Messages>),
    Events(BatchBuilder<Events>, EventCollector, bool),
    Signals(BatchBuilder<Signals>),
}

impl Filling {
    fn new(kind: Kind) -> Self {
        match kind {
            Kind::Frames => Self::Frames(builder()),
            Kind::Messages => Self::Messages(builder()),
            Kind::Events => Self::Events(builder(), EventCollector::default(), false),
            Kind::Signals => Self::Signals(builder()),
        }
    }

    fn kind(&self) -> Kind {
        match self {
            Self::Frames(_) => Kind::Frames,
            Self::Messages(_) => Kind::Messages,
            Self::Events(..) => Kind::Events,
            Self::Signals(_) => Kind::Signals,
        }
    }

    fn rows(&self) -> usize {
        match self {
            Self::Frames(builder) => builder.rows(),
            Self::Messages(builder) => builder.rows(),
            Self::Events(builder, ..) => builder.rows(),
            Self::Signals(builder) => builder.rows(),
        }
    }

    fn is_full(&self) -> bool {
        match self {
            Self::Frames(builder) => builder.is_full(BATCH),
            Self::Messages(builder) => builder.is_full(BATCH),
            Self::Events(builder, ..) => builder.is_full(BATCH),
            Self::Signals(builder) => builder.is_full(BATCH),
        }
    }

    fn finish(&mut self) -> Result<RecordBatch, ArrowError> {
        match self {
            Self::Frames(builder) => builder.finish(),
            Self::Messages(builder) => builder.finish(),
            Self::Events(builder, ..) => builder.finish(),
            Self::Signals(builder) => builder.finish(),
        }
    }

    /// Adds the rows of a frame.
    fn frame(&mut self, frame: DecodedFrame<'_>) {
        match self {
            Self::Frames(_) => debug_assert!(false, "the table of frames needs no decoding"),
            Self::Messages(builder) => builder.push(&frame),
            Self::Events(builder, collector, _) => {
                let added: Result<_, Infallible> = collector.frame(frame, |row| {
                    builder.push(row);
                    Ok(ControlFlow::Continue(()))
                });
                let _: ControlFlow<()> = added.unwrap_or_else(|never| match never {});
            }
            Self::Signals(builder) => {
                for signal in frame.meaning().signals() {
                    builder.push(&SignalRow { frame, signal: &signal });
                }
            }
        }
    }

    /// Adds the rows of the end of the capture, once.
    fn end(&mut self, capture: &str, reading: &Reading) {
        if let Self::Events(builder, collector, ended) = self
            && !std::mem::replace(ended, true)
        {
            let added: Result<(), Infallible> =
                collector.finish(capture, reading.channels(), &reading.network, None, |row| {
                    builder.push(row);
                    Ok(ControlFlow::Continue(()))
                });
            added.unwrap_or_else(|never| match never {});
        }
    }
}

impl Iterator for RowsOf {
    type Item = Result<RecordBatch, ArrowError>;

    fn next(&mut self) -> Option<Self::Item> {
        let Self { capture, reading, filling } = self;
        while !filling.is_full() {
            if !reading.advance() {
                filling.end(capture, reading);
                break;
            }
            if let Filling::Frames(builder) = filling {
                builder.push(&FrameRow { capture, record: &reading.record, channels: reading.channels() });
                continue;
            }
            let decoded = &reading.network.handle(&reading.record);
            let Some(bus) = reading.network.bus(reading.record.channel) else { continue };
            filling.frame(DecodedFrame {
                capture,
                record: &reading.record,
                channels: reading.channels(),
                decoded,
                bus,
            });
        }
        (filling.rows() > 0).then(|| filling.finish())
    }
}

impl RecordBatchReader for RowsOf {
    fn schema(&self) -> SchemaRef {
        self.filling.kind().schema()
    }
}
