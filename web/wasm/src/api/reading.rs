//! Reading of captures, and its results.

use super::{Answer, Page, error, progress};
use crate::descriptions::Described;
use crate::file::hexadecimal;
use crate::opening::Opening;
use canvass_reports::escape::printable;
use serde_json::json;
use sha2::{Digest, Sha256};
use wasm_bindgen::prelude::*;

/// Computes the hash of a file.
#[wasm_bindgen]
#[derive(Default)]
pub struct Hasher(Sha256);

#[wasm_bindgen]
impl Hasher {
    /// A hasher without bytes.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the next bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The hash of all bytes so far, in hexadecimal.
    pub fn digest(&self) -> String {
        hexadecimal(&self.0.clone().finalize())
    }
}

#[wasm_bindgen]
impl Page {
    /// Begins to read the captures. With `elsewhere`, another worker computes their hashes and passes them to `hashed`.
    ///
    /// # Errors
    /// If a capture can't be opened.
    pub fn open(&mut self, elsewhere: bool) -> Answer<()> {
        (self.opening, self.opened, self.selection) = (None, None, None);
        (self.search, self.plots) = (None, None);
        self.opening = Some(Opening::begin(&self.files, &self.options, &self.described, !elsewhere).map_err(error)?);
        Ok(())
    }

    /// Reads the next `records` records; returns the progress as JSON.
    ///
    /// # Errors
    /// If nothing is being opened.
    #[wasm_bindgen(js_name = openOn)]
    pub fn open_on(&mut self, records: u32) -> Answer<String> {
        let opening = self.opening.as_mut().ok_or_else(|| error("nothing is being opened"))?;
        let more = opening.step(records as usize).map_err(error)?;
        let mut told = progress(opening.input(), more);
        told["frames"] = opening.frames().into();
        if !more && let Some(opening) = self.opening.take() {
            let devices = self.described.iter().map(|known| format!("{}={}", known.nodes_text, known.name));
            let format = self.options.format.as_deref();
            let mut provenance = self.surroundings.of_diagnosis(devices.collect(), format, self.options.same_bus);
            provenance.files = self.described.iter().map(Described::used).collect();
            self.opened = Some(opening.finish(provenance).map_err(error)?);
        }
        Ok(told.to_string())
    }

    /// Sets the hashes of the captures: JSON with a hexadecimal text for each capture in their order, `null` for an
    /// unreadable capture.
    ///
    /// # Errors
    /// If no capture is open, or `hashes` is malformed.
    pub fn hashed(&mut self, hashes: &str) -> Answer<()> {
        let hashes: Vec<Option<String>> = serde_json::from_str(hashes).map_err(error)?;
        self.opened.as_mut().ok_or_else(|| error("no capture is open"))?.hashed(&hashes);
        Ok(())
    }

    /// A summary of the captures, as JSON.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn summary(&self) -> Answer<String> {
        let opened = self.opened()?;
        let captures = opened.input.captures();
        let [errors, warnings, notes] = opened.counts();
        let formats: Vec<_> = captures.iter().map(|capture| capture.format.to_string()).collect();
        let told: Vec<_> = opened.input.told().iter().map(|told| printable(told)).collect();
        Ok(json!({
            "frames": opened.store.len(),
            "leftOut": opened.store.left_out(),
            "formats": formats,
            "channels": opened.input.merge().channels().names().map(|name| printable(name).into_owned()).collect::<Vec<_>>(),
            // Seconds since 1970, or since the start of the recording where the capture does not tell it.
            "start": opened.store.start().unwrap_or_default().nanos() as f64 / 1e9,
            "damages": opened.input.damages(),
            "damage": told,
            "errors": errors, "warnings": warnings, "notes": notes,
        })
        .to_string())
    }

    /// The diagnosis as `html` (once), `table`, `json`, `markdown` or `junit`.
    ///
    /// # Errors
    /// If no capture is open, or there is no such form.
    pub fn diagnosis(&mut self, form: &str) -> Answer<Vec<u8>> {
        let opened = self.opened.as_mut().ok_or_else(|| error("no capture is open"))?;
        opened.report(form).map_err(error)
    }
}
