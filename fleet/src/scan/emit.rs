//! Collects the rows that pass the tests into batches, until no more rows are wanted.

use super::ScanError;
use crate::filter::{Filter, Test};
use crate::table::builder::BatchBuilder;
use crate::table::column::Rows;
use canvass_analyzer::network::Steady;
use datafusion::arrow::array::RecordBatch;
use datafusion::arrow::datatypes::SchemaRef;
use std::ops::ControlFlow;

/// A receiver of batches.
pub trait Outlet {
    /// Takes a batch; `Break` if no more batches are wanted.
    fn give(&mut self, batch: RecordBatch) -> ControlFlow<()>;

    /// Whether the receiver still wants batches.
    fn is_wanted(&self) -> bool;
}

/// The wanted part of a table.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// The columns, by their indexes in the table.
    pub columns: &'a [usize],
    /// The schema of the columns.
    pub schema: &'a SchemaRef,
    /// The tests that a row must pass.
    pub tests: &'a [Test],
    /// Maximum number of rows.
    pub fetch: Option<usize>,
    /// Whether the scan skips frames that give no rows and change no state.
    pub skips: bool,
    /// Maximum number of rows in a batch.
    pub batch_rows: usize,
}

impl Wanted<'_> {
    /// Whether a column's value is needed, for the output or for a test.
    pub fn asks<R: Rows>(&self, name: &str) -> bool {
        R::asks(self.columns, name) || self.tests.iter().any(|test| test.column == name)
    }
}

/// Takes the rows of a table.
pub struct Emitter<'a, R: Rows> {
    builder: BatchBuilder<R>,
    filter: Filter<R>,
    /// The tests that give the same result for all frames of the same kind: one filter for frames with 11-bit CAN-IDs,
    /// and one for frames with 29-bit CAN-IDs.
    alike: [Filter<R>; 2],
    left: Option<usize>,
    batch_rows: usize,
    /// Number of rows since the last check whether the outlet still wants rows.
    unlooked: usize,
    outlet: &'a mut dyn Outlet,
}

impl<'a, R: Rows> Emitter<'a, R> {
    /// Number of rejected rows after which the scan checks whether the outlet still wants rows.
    const LOOK: usize = 8192;

    /// Passes the wanted rows to an outlet.
    pub fn new(wanted: Wanted<'_>, outlet: &'a mut dyn Outlet) -> Self {
        Self {
            builder: BatchBuilder::new(SchemaRef::clone(wanted.schema), wanted.columns),
            filter: Filter::new(wanted.tests),
            alike: [false, true].map(|any_id| Filter::of_alike(wanted.tests, any_id)),
            left: wanted.fetch,
            batch_rows: wanted.batch_rows,
            unlooked: 0,
            outlet,
        }
    }

    /// Takes a row; `Break` if no more rows are wanted.
    ///
    /// # Errors
    /// [`ScanError::Arrow`], which would be a bug of this module.
    #[inline]
    pub fn row(&mut self, row: &R::Row<'_>) -> Result<ControlFlow<()>, ScanError> {
        if self.left == Some(0) {
            return Ok(ControlFlow::Break(()));
        }
        if !self.filter.passes(row) {
            return Ok(self.look());
        }
        self.builder.push(row);
        if let Some(left) = &mut self.left {
            *left -= 1;
        }
        if self.builder.is_full(self.batch_rows) || self.left == Some(0) {
            return self.flush();
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Whether the tests may refuse all rows of frames that are alike.
    pub fn may_refuse_alike(&self) -> bool {
        self.alike.iter().any(|filter| !filter.is_empty())
    }

    /// Whether the tests refuse the rows of all frames that are like the frame of this row.
    #[inline]
    pub fn refuses_alike(&mut self, row: &R::Row<'_>, steady: Steady) -> bool {
        let [by_id, any_id] = &mut self.alike;
        let filter = if steady == Steady::Extended { any_id } else { by_id };
        !filter.passes(row)
    }

    /// Counts `frames` skipped frames; `Break` if the outlet wants no more rows.
    #[inline]
    pub fn skipped(&mut self, frames: usize) -> ControlFlow<()> {
        self.unlooked += frames;
        if frames > 0 { self.look() } else { ControlFlow::Continue(()) }
    }

    /// Counts an item without a row; `Break` if the outlet wants no more rows.
    #[inline]
    pub fn look(&mut self) -> ControlFlow<()> {
        self.unlooked += 1;
        if self.unlooked < Self::LOOK {
            return ControlFlow::Continue(());
        }
        self.unlooked = 0;
        if self.outlet.is_wanted() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn flush(&mut self) -> Result<ControlFlow<()>, ScanError> {
        let given = self.outlet.give(self.builder.finish()?);
        Ok(if self.left == Some(0) { ControlFlow::Break(()) } else { given })
    }

    /// Passes the remaining rows to the outlet.
    ///
    /// # Errors
    /// As [`Emitter::row`].
    pub fn finish(mut self) -> Result<(), ScanError> {
        if self.builder.rows() > 0 {
            // An outlet that wants no more rows is no error.
            let _ = self.flush()?;
        }
        Ok(())
    }
}
