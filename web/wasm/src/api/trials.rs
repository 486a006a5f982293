//! Simulated devices, and results of earlier runs.

use super::{Answer, Page, error};
use crate::results::{self, ChosenResult};
use crate::trial;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Page {
    /// The models and faults that can be tried, as JSON.
    pub fn choices() -> String {
        trial::choices().to_string()
    }

    /// Runs cases on a simulated device; `wish` is JSON. `triedPage` and `triedJson` return the result.
    ///
    /// # Errors
    /// If no case could be run.
    pub fn test(&mut self, wish: &str) -> Answer<()> {
        let wish = serde_json::from_str(wish).map_err(error)?;
        self.tried = Some(trial::test(&wish, &self.surroundings).map_err(error)?);
        Ok(())
    }

    /// Fuzzes a simulated device; `wish` is JSON. `triedPage` and `triedJson` return the result.
    ///
    /// # Errors
    /// If no sequence could be run.
    pub fn fuzz(&mut self, wish: &str) -> Answer<()> {
        let wish = serde_json::from_str(wish).map_err(error)?;
        self.tried = Some(trial::fuzz(&wish, &self.surroundings).map_err(error)?);
        Ok(())
    }

    /// The page of the last trial.
    #[wasm_bindgen(js_name = triedPage)]
    pub fn tried_page(&self) -> Vec<u8> {
        self.tried.as_ref().map_or_else(Vec::new, |tried| tried.html.clone())
    }

    /// The JSON result of the last trial.
    #[wasm_bindgen(js_name = triedJson)]
    pub fn tried_json(&self) -> Vec<u8> {
        self.tried.as_ref().map_or_else(Vec::new, |tried| tried.json.clone())
    }

    /// Adds a result for a comparison or history.
    #[wasm_bindgen(js_name = addResult)]
    pub fn add_result(&mut self, name: &str, bytes: Vec<u8>) {
        self.results.push(ChosenResult { name: name.to_owned(), bytes });
    }

    /// The page that compares the two added results of `canvass test`, the older result first; removes the results.
    ///
    /// # Errors
    /// If there are not exactly two results.
    pub fn compare(&mut self) -> Answer<Vec<u8>> {
        let results = std::mem::take(&mut self.results);
        let [old, new] = &results[..] else { return Err(error("expected two results")) };
        results::comparison(old, new, &self.surroundings).map_err(error)
    }

    /// The page of all added results, the oldest first; removes the results.
    ///
    /// # Errors
    /// If one of the files is no result.
    pub fn history(&mut self) -> Answer<Vec<u8>> {
        let results = std::mem::take(&mut self.results);
        results::history(&results, &self.surroundings).map_err(error)
    }
}
