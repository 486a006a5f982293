//! Writes batches into the Parquet files of a lake.

use super::{Location, Part, day};
use crate::scan::ScanError;
use crate::scan::emit::Outlet;
use crate::table::Table;
use bytes::Bytes;
use canvass_traces::Timestamp;
use datafusion::arrow::array::RecordBatch;
use datafusion::parquet::arrow::ArrowWriter;
use datafusion::parquet::basic::{Compression, ZstdLevel};
use datafusion::parquet::file::properties::WriterProperties;
use object_store::buffered::BufWriter;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::sync::Arc;
use tokio::io::AsyncWriteExt as _;
use tokio::runtime::Handle;

/// The destination of the Parquet files of one capture.
#[derive(Clone)]
pub struct Folder {
    /// The lake.
    pub location: Location,
    /// The name of the files, the same for every table.
    pub name: String,
    /// The time of the first frame of the capture.
    pub begin: Option<Timestamp>,
    /// The runtime for asynchronous writes.
    pub handle: Handle,
}

/// Number of rows in a row group: large enough that columns compress well, small enough that a reader can skip some
/// groups.
const GROUP: usize = 256 * 1024;

/// The file of one table. It is not created before its first row.
pub struct ParquetFile {
    folder: Folder,
    part: Part,
    writer: Option<ArrowWriter<ObjectWriter>>,
    failure: Option<ScanError>,
}

impl ParquetFile {
    /// A file for the rows of this table.
    pub fn new(folder: &Folder, table: Table) -> Self {
        let (date, name) = (day(folder.begin), folder.name.clone());
        Self {
            folder: folder.clone(),
            part: Part { table, date, name, rows: 0, bytes: 0 },
            writer: None,
            failure: None,
        }
    }

    fn write(&mut self, batch: &RecordBatch) -> Result<(), ScanError> {
        let writer = match &mut self.writer {
            Some(writer) => writer,
            None => {
                let object = ObjectWriter::new(&self.folder, &self.part);
                self.writer.insert(ArrowWriter::try_new(object, batch.schema(), Some(properties())).map_err(failed)?)
            }
        };
        self.part.rows += batch.num_rows() as u64;
        writer.write(batch).map_err(failed)
    }

    /// Completes the file, which appears in the lake only now; `None` if it has no rows.
    ///
    /// # Errors
    /// [`ScanError`] if the file can't be written.
    pub fn finish(mut self) -> Result<Option<Part>, ScanError> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        let Some(writer) = self.writer.take() else { return Ok(None) };
        let object = writer.into_inner().map_err(failed)?;
        self.part.bytes = object.complete()?;
        Ok(Some(self.part))
    }
}

impl Outlet for ParquetFile {
    fn give(&mut self, batch: RecordBatch) -> ControlFlow<()> {
        match self.write(&batch) {
            Ok(()) => ControlFlow::Continue(()),
            Err(failure) => {
                self.failure.get_or_insert(failure);
                ControlFlow::Break(())
            }
        }
    }

    fn is_wanted(&self) -> bool {
        self.failure.is_none()
    }
}

fn failed(error: datafusion::parquet::errors::ParquetError) -> ScanError {
    ScanError::Io(io::Error::other(error))
}

fn properties() -> WriterProperties {
    WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_max_row_group_row_count(Some(GROUP))
        .set_created_by(format!("canvass-fleet {}", env!("CARGO_PKG_VERSION")))
        .build()
}

/// A blocking writer of an object. The object appears when it is complete, or not at all.
struct ObjectWriter {
    object: BufWriter,
    bytes: u64,
    handle: Handle,
}

impl ObjectWriter {
    fn new(folder: &Folder, part: &Part) -> Self {
        let path = folder.location.path(&part.path());
        let object = BufWriter::new(Arc::clone(&folder.location.store), path);
        Self { object, bytes: 0, handle: folder.handle.clone() }
    }

    fn complete(mut self) -> io::Result<u64> {
        self.handle.block_on(self.object.shutdown())?;
        Ok(self.bytes)
    }
}

impl Write for ObjectWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.handle.block_on(self.object.put(Bytes::copy_from_slice(bytes))).map_err(io::Error::other)?;
        self.bytes += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
