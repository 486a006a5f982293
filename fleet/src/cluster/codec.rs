//! Tables and plans as bytes. Tables and plans of canvass-fleet are encoded as a mark and JSON; all others have
//! Ballista's encoding.

use crate::capture::{CaptureFile, is_url};
use crate::devices::Devices;
use crate::lake::{IngestScan, IngestSpec, IngestTable, LakeSpec, LakeTable};
use crate::scan::{CaptureScan, CaptureTable, Files, ScanSpec, files};
use crate::table::{SCHEMA_VERSION, Table};
use ballista_core::serde::{BallistaLogicalExtensionCodec, BallistaPhysicalExtensionCodec};
use datafusion::arrow::datatypes::SchemaRef;
use datafusion::catalog::TableProvider;
use datafusion::common::TableReference;
use datafusion::datasource::file_format::FileFormatFactory;
use datafusion::error::{DataFusionError, Result};
use datafusion::execution::TaskContext;
use datafusion::logical_expr::{Extension, LogicalPlan};
use datafusion::physical_plan::ExecutionPlan;
use datafusion_proto::logical_plan::LogicalExtensionCodec;
use datafusion_proto::physical_plan::{PhysicalExtensionCodec, PhysicalProtoConverterExtension};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The first bytes of our encoding. No message of Ballista begins with them: the first byte would be a protobuf field
/// of an invalid type.
const MARK: &[u8] = b"\x07canvass\n";

/// A message with the version of the tables. A receiver of another version refuses the message, because it may have
/// other columns.
#[derive(Serialize, Deserialize)]
struct Sent<T> {
    schema: u32,
    what: T,
}

/// A table on its way to the scheduler.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub enum SentTable {
    /// A table of captures.
    Captures {
        /// The kind of the table.
        table: Table,
        /// The files of the table.
        files: Files,
        /// The rules of devices.
        devices: Devices,
        /// Whether filters are applied before rows are made.
        push_down: bool,
    },
    /// A table of a lake.
    Lake(LakeSpec),
    /// An ingest.
    Ingest {
        /// The parameters of the ingest.
        spec: IngestSpec,
        /// The files of each partition.
        partitions: Vec<Vec<CaptureFile>>,
    },
}

/// A plan on its way to an executor; the files that the plan reads are its input.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub enum SentPlan {
    /// A plan that reads captures.
    Scan(ScanSpec),
    /// A plan that puts captures into a lake.
    Ingest(IngestSpec),
}

impl SentTable {
    /// The description of a table for another computer; `None` if the table is not ours.
    ///
    /// Paths become absolute, as the other computer has another current folder.
    ///
    /// # Errors
    /// If the current folder is not known.
    pub fn of(table: &dyn TableProvider) -> Result<Option<Self>> {
        if let Some(table) = table.downcast_ref::<CaptureTable>() {
            let (files, devices) = (absolute_files(table.files())?, table.devices().clone());
            return Ok(Some(Self::Captures { table: table.table(), files, devices, push_down: table.pushes_down() }));
        }
        if let Some(table) = table.downcast_ref::<LakeTable>() {
            return Ok(Some(Self::Lake(table.spec())));
        }
        let ingest = table.downcast_ref::<IngestTable>();
        Ok(ingest.map(|table| Self::Ingest { spec: table.spec().clone(), partitions: table.partitions().to_vec() }))
    }

    fn table(self, context: &TaskContext) -> Result<Arc<dyn TableProvider>> {
        Ok(match self {
            Self::Captures { table, files, devices, push_down } => {
                Arc::new(CaptureTable::of_devices(table, files, devices, push_down))
            }
            Self::Lake(spec) => Arc::new(LakeTable::of_spec(spec, &context.runtime_env())?),
            Self::Ingest { spec, partitions } => Arc::new(IngestTable::new(spec, partitions)),
        })
    }
}

/// A path or pattern that means the same in every folder.
///
/// # Errors
/// If the current folder is not known.
pub fn absolute(name: &str) -> Result<String> {
    if is_url(name) {
        return Ok(name.to_owned());
    }
    let path = std::path::absolute(name)?;
    path.into_os_string().into_string().map_err(|path| {
        DataFusionError::Plan(format!("{}: paths that are no UTF-8 can't be sent to a cluster", path.to_string_lossy()))
    })
}

fn absolute_files(files: &Files) -> Result<Files> {
    let of_file = |file: &CaptureFile| {
        // A file whose place is told has a name that is no path.
        let name = if file.path.is_some() { file.name.clone() } else { absolute(&file.name)? };
        Ok(CaptureFile { name, ..file.clone() })
    };
    Ok(match files {
        Files::Patterns(patterns) => {
            Files::Patterns(patterns.iter().map(|name| absolute(name)).collect::<Result<_>>()?)
        }
        Files::Known(files) => Files::Known(files.iter().map(of_file).collect::<Result<_>>()?),
    })
}

/// Writes our encoding of a table or plan.
///
/// # Errors
/// If the value can't be JSON.
pub fn write<T: Serialize>(what: T, bytes: &mut Vec<u8>) -> Result<()> {
    bytes.extend_from_slice(MARK);
    let sent = Sent { schema: SCHEMA_VERSION, what };
    serde_json::to_writer(bytes, &sent).map_err(|error| DataFusionError::External(Box::new(error)))
}

/// Reads our encoding; `None` if the encoding is Ballista's.
///
/// # Errors
/// If the bytes are damaged, or come from another version of canvass-fleet.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<Option<T>> {
    /// The version alone, which can be read from a message of any version.
    #[derive(Deserialize)]
    struct Version {
        schema: u32,
    }
    let Some(json) = bytes.strip_prefix(MARK) else { return Ok(None) };
    let damaged =
        |error: serde_json::Error| DataFusionError::Plan(format!("a plan that was sent here can't be read: {error}"));
    let version: Version = serde_json::from_slice(json).map_err(damaged)?;
    if version.schema != SCHEMA_VERSION {
        return Err(DataFusionError::Plan(format!(
            "a plan was sent here for tables of version {}, and this process has version {SCHEMA_VERSION}: use the same \
             canvass-fleet on all computers",
            version.schema
        )));
    }
    let sent: Sent<T> = serde_json::from_slice(json).map_err(damaged)?;
    Ok(Some(sent.what))
}

/// Encodes tables.
#[derive(Debug, Default)]
pub struct LogicalCodec(BallistaLogicalExtensionCodec);

impl LogicalExtensionCodec for LogicalCodec {
    fn try_decode(&self, bytes: &[u8], inputs: &[LogicalPlan], context: &TaskContext) -> Result<Extension> {
        self.0.try_decode(bytes, inputs, context)
    }

    fn try_encode(&self, node: &Extension, bytes: &mut Vec<u8>) -> Result<()> {
        self.0.try_encode(node, bytes)
    }

    fn try_decode_table_provider(
        &self,
        bytes: &[u8],
        name: &TableReference,
        schema: SchemaRef,
        context: &TaskContext,
    ) -> Result<Arc<dyn TableProvider>> {
        match read::<SentTable>(bytes)? {
            Some(sent) => sent.table(context),
            None => self.0.try_decode_table_provider(bytes, name, schema, context),
        }
    }

    fn try_encode_table_provider(
        &self,
        name: &TableReference,
        table: Arc<dyn TableProvider>,
        bytes: &mut Vec<u8>,
    ) -> Result<()> {
        match SentTable::of(table.as_ref())? {
            Some(sent) => write(sent, bytes),
            None => self.0.try_encode_table_provider(name, table, bytes),
        }
    }

    fn try_decode_file_format(&self, bytes: &[u8], context: &TaskContext) -> Result<Arc<dyn FileFormatFactory>> {
        self.0.try_decode_file_format(bytes, context)
    }

    fn try_encode_file_format(&self, bytes: &mut Vec<u8>, format: Arc<dyn FileFormatFactory>) -> Result<()> {
        self.0.try_encode_file_format(bytes, format)
    }
}

/// Encodes plans.
#[derive(Debug, Default)]
pub struct PhysicalCodec {
    ballista: BallistaPhysicalExtensionCodec,
    host: Option<Arc<str>>,
}

impl PhysicalCodec {
    /// The codec of an executor, which adds the executor's name to every error.
    pub fn at(host: &str) -> Self {
        Self { host: Some(Arc::from(host)), ..Self::default() }
    }
}

impl PhysicalExtensionCodec for PhysicalCodec {
    fn try_decode(
        &self,
        bytes: &[u8],
        inputs: &[Arc<dyn ExecutionPlan>],
        context: &TaskContext,
        converter: &dyn PhysicalProtoConverterExtension,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        match read::<SentPlan>(bytes)? {
            Some(SentPlan::Scan(spec)) => {
                Ok(Arc::new(CaptureScan::new(spec, files::only(inputs.to_vec())?)?.at(self.host.clone())))
            }
            Some(SentPlan::Ingest(spec)) => Ok(Arc::new(IngestScan::new(spec, files::only(inputs.to_vec())?))),
            None => self.ballista.try_decode(bytes, inputs, context, converter),
        }
    }

    fn try_encode(
        &self,
        plan: Arc<dyn ExecutionPlan>,
        bytes: &mut Vec<u8>,
        converter: &dyn PhysicalProtoConverterExtension,
    ) -> Result<()> {
        if let Some(scan) = plan.downcast_ref::<CaptureScan>() {
            return write(SentPlan::Scan(scan.spec().clone()), bytes);
        }
        if let Some(scan) = plan.downcast_ref::<IngestScan>() {
            return write(SentPlan::Ingest(scan.spec().clone()), bytes);
        }
        self.ballista.try_encode(plan, bytes, converter)
    }
}

#[cfg(test)]
mod tests;
