//! Simulated devices, and results of earlier runs.

use super::{Answer, Page, error};
use crate::{results, trial};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Page {
    /// What can be tried: JSON.
    pub fn choices() -> String {
        trial::choices().to_string()
    }

    /// Runs cases on a simulated device; `wish` is JSON. `triedPage` and `triedJson` give the result.
    ///
    /// # Errors
    /// If nothing could be run.
    pub fn test(&mut self, wish: &str) -> Answer<()> {
        let wish = serde_json::from_str(wish).map_err(error)?;
        self.tried = Some(trial::test(&wish, &self.surroundings).map_err(error)?);
        Ok(())
    }

    /// Fuzzes a simulated device, likewise.
    ///
    /// # Errors
    /// If nothing could be run.
    pub fn fuzz(&mut self, wish: &str) -> Answer<()> {
        let wish = serde_json::from_str(wish).map_err(error)?;
        self.tried = Some(trial::fuzz(&wish, &self.surroundings).map_err(error)?);
        Ok(())
    }

    /// The page of what was tried.
    #[wasm_bindgen(js_name = triedPage)]
    pub fn tried_page(&self) -> Vec<u8> {
        self.tried.as_ref().map_or_else(Vec::new, |tried| tried.html.clone())
    }

    /// Its result for programs.
    #[wasm_bindgen(js_name = triedJson)]
    pub fn tried_json(&self) -> Vec<u8> {
        self.tried.as_ref().map_or_else(Vec::new, |tried| tried.json.clone())
    }

    /// The page that compares two results of `canvass test`; `results` is JSON: names and texts, the older first.
    ///
    /// # Errors
    /// If they are not two results.
    pub fn compare(&self, results: &str) -> Answer<Vec<u8>> {
        let read: Vec<(String, String)> = serde_json::from_str(results).map_err(error)?;
        let [(old, older), (new, newer)] = &read[..] else { return Err(error("expected two results")) };
        results::comparison((old, older), (new, newer), self.surroundings.provenance()).map_err(error)
    }

    /// The page of many results, the oldest first.
    ///
    /// # Errors
    /// If one is no result.
    pub fn history(&self, results: &str) -> Answer<Vec<u8>> {
        let read: Vec<(String, String)> = serde_json::from_str(results).map_err(error)?;
        results::history(&read, self.surroundings.provenance()).map_err(error)
    }
}
