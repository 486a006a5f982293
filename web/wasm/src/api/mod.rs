//! The functions that the page's worker calls.

mod exports;
mod reading;
mod trace;
mod trials;

use crate::descriptions::Described;
use crate::export::Export;
use crate::file::ChosenFile;
use crate::host;
use crate::input::{Input, InputOptions};
use crate::opening::{Opened, Opening};
use crate::plots::Plots;
use crate::provenance::Surroundings;
use crate::results::ChosenResult;
use crate::trace::selection::{Search, Selection};
use crate::trial::Tried;
use canvass_analyzer::filter::{Filter, FilterError};
use canvass_reports::escape::printable;
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

type Answer<T> = Result<T, JsError>;

/// The captures and descriptions of a page, and their results.
#[wasm_bindgen]
#[derive(Default)]
pub struct Page {
    surroundings: Surroundings,
    options: InputOptions,
    files: Vec<ChosenFile>,
    described: Vec<Described>,
    opening: Option<Opening>,
    opened: Option<Opened>,
    selection: Option<Selection>,
    search: Option<Search>,
    export: Option<Export>,
    plots: Option<Plots>,
    tried: Option<Tried>,
    results: Vec<ChosenResult>,
}

fn error(text: impl std::fmt::Display) -> JsError {
    JsError::new(&printable(&text.to_string()))
}

/// The progress of reading.
fn progress(input: &Input, more: bool) -> Value {
    let size: u64 = input.files().iter().map(|(file, _)| file.length).sum();
    json!({ "more": more, "read": input.read(), "size": size })
}

fn filter(text: &str) -> Result<Option<Filter>, FilterError> {
    if text.trim().is_empty() { Ok(None) } else { text.parse().map(Some) }
}

#[wasm_bindgen]
impl Page {
    /// A page without files; `surroundings` is JSON: host, system, date, zone.
    ///
    /// # Errors
    /// If `surroundings` is malformed.
    #[wasm_bindgen(constructor)]
    pub fn new(surroundings: &str) -> Answer<Self> {
        host::tell_why_it_stops();
        let surroundings = serde_json::from_str(surroundings).map_err(error)?;
        Ok(Self { surroundings, ..Self::default() })
    }

    /// Sets the options for reading captures, as JSON.
    ///
    /// # Errors
    /// If `options` is malformed.
    pub fn options(&mut self, options: &str) -> Answer<()> {
        self.options = serde_json::from_str(options).map_err(error)?;
        Ok(())
    }

    /// Removes the captures.
    pub fn close(&mut self) {
        (self.opening, self.opened, self.selection) = (None, None, None);
        (self.search, self.export, self.plots) = (None, None, None);
        self.files.clear();
    }

    /// Adds a capture, which `canvassHost.read` reads by this number.
    #[wasm_bindgen(js_name = addCapture)]
    pub fn add_capture(&mut self, number: u32, name: &str, length: f64) {
        self.files.push(ChosenFile { number, name: name.to_owned(), length: length as u64 });
    }

    /// Adds a description, or replaces the description with this name; returns its summary as JSON.
    ///
    /// # Errors
    /// If the description can't be used.
    #[wasm_bindgen(js_name = addDescription)]
    pub fn add_description(&mut self, name: &str, nodes: &str, bytes: &[u8]) -> Answer<String> {
        let described = Described::read(name, nodes, bytes).map_err(error)?;
        self.remove_description(name);
        let summary = described.summary().to_string();
        self.described.push(described);
        Ok(summary)
    }

    /// Removes a description.
    #[wasm_bindgen(js_name = removeDescription)]
    pub fn remove_description(&mut self, name: &str) {
        self.described.retain(|known| known.name != name);
    }

    /// The HTML page of a description's dictionary.
    ///
    /// # Errors
    /// If there is no such description.
    #[wasm_bindgen(js_name = descriptionPage)]
    pub fn description_page(&self, name: &str) -> Answer<Vec<u8>> {
        self.description(name)?.page().map_err(error)
    }

    /// The findings in a description, as the JSON of `eds check`.
    ///
    /// # Errors
    /// If there is no such description.
    #[wasm_bindgen(js_name = descriptionFindings)]
    pub fn description_findings(&self, name: &str) -> Answer<String> {
        Ok(self.description(name)?.findings().to_string())
    }

    /// The findings in a description as text.
    ///
    /// # Errors
    /// If there is no such description.
    #[wasm_bindgen(js_name = descriptionFindingsText)]
    pub fn description_findings_text(&self, name: &str) -> Answer<String> {
        Ok(self.description(name)?.findings_text())
    }

    fn description(&self, name: &str) -> Answer<&Described> {
        let known = self.described.iter().find(|known| known.name == name);
        known.ok_or_else(|| error(format!("no description {name}")))
    }

    fn opened(&self) -> Answer<&Opened> {
        self.opened.as_ref().ok_or_else(|| error("no capture is open"))
    }
}
