//! Downloads.

use super::{Answer, Page, error, progress};
use crate::export::{Export, Wish};
use canvass_traces::Format;
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Page {
    /// Begins an export; `wish` is JSON.
    ///
    /// # Errors
    /// If the export can't be made.
    pub fn export(&mut self, wish: &str) -> Answer<()> {
        let wish: Wish = serde_json::from_str(wish).map_err(error)?;
        self.export = Some(Export::begin(&self.files, &self.options, &self.described, &wish).map_err(error)?);
        Ok(())
    }

    /// The next piece of the export; `None` at its end.
    ///
    /// # Errors
    /// If the export can't be made.
    #[wasm_bindgen(js_name = exportOn)]
    pub fn export_on(&mut self, records: u32) -> Answer<Option<Vec<u8>>> {
        let Some(export) = &mut self.export else { return Ok(None) };
        let mut piece = Vec::new();
        let more = export.step(records as usize, &mut piece).map_err(error)?;
        if !more {
            self.export = None;
        }
        Ok((more || !piece.is_empty()).then_some(piece))
    }

    /// The progress of the export, as JSON.
    #[wasm_bindgen(js_name = exportProgress)]
    pub fn export_progress(&self) -> String {
        self.export.as_ref().map_or(Value::Null, |export| progress(export.input(), true)).to_string()
    }

    /// The formats of captures, as JSON.
    pub fn formats() -> String {
        let told =
            |format: Format| json!({ "id": format.id(), "name": format.summary(), "written": format.is_written() });
        Value::from(Format::all().map(told).collect::<Vec<_>>()).to_string()
    }
}
