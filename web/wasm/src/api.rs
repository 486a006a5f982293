//! What the page's worker calls.

use crate::descriptions::Described;
use crate::export::{Export, Wish};
use crate::file::ChosenFile;
use crate::host;
use crate::input::{Input, InputOptions};
use crate::opening::{Opened, Opening};
use crate::plots::Plots;
use crate::provenance::Surroundings;
use crate::results;
use crate::trace::details::details;
use crate::trace::rows::rows;
use crate::trace::selection::{Search, Selection, Wanted, row_at};
use crate::trial::{self, Tried};
use canvass_analyzer::filter::{Filter, FilterError};
use canvass_reports::escape::printable;
use canvass_traces::{Duration, Format};
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

type Answer<T> = Result<T, JsError>;

/// The captures and descriptions of a page, and what is done with them.
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
}

fn error(text: impl std::fmt::Display) -> JsError {
    JsError::new(&printable(&text.to_string()))
}

/// How far the reading is.
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
    /// If it is none.
    #[wasm_bindgen(constructor)]
    pub fn new(surroundings: &str) -> Answer<Self> {
        host::tell_why_it_stops();
        let surroundings = serde_json::from_str(surroundings).map_err(error)?;
        Ok(Self { surroundings, ..Self::default() })
    }

    /// Sets how captures are read: JSON.
    ///
    /// # Errors
    /// If it is none.
    pub fn options(&mut self, options: &str) -> Answer<()> {
        self.options = serde_json::from_str(options).map_err(error)?;
        Ok(())
    }

    /// Forgets the captures.
    pub fn close(&mut self) {
        (self.opening, self.opened, self.selection) = (None, None, None);
        (self.search, self.export, self.plots) = (None, None, None);
        self.files.clear();
    }

    /// Adds a capture, which `canvassHost.read` reads by that number.
    #[wasm_bindgen(js_name = addCapture)]
    pub fn add_capture(&mut self, number: u32, name: &str, length: f64) {
        self.files.push(ChosenFile { number, name: name.to_owned(), length: length as u64 });
    }

    /// Adds a description, or takes it in place of the one of that name; gives what it is, as JSON.
    ///
    /// # Errors
    /// If it can't be used.
    #[wasm_bindgen(js_name = addDescription)]
    pub fn add_description(&mut self, name: &str, nodes: &str, bytes: &[u8]) -> Answer<String> {
        let described = Described::read(name, nodes, bytes).map_err(error)?;
        self.remove_description(name);
        let summary = described.summary().to_string();
        self.described.push(described);
        Ok(summary)
    }

    /// Forgets a description.
    #[wasm_bindgen(js_name = removeDescription)]
    pub fn remove_description(&mut self, name: &str) {
        self.described.retain(|known| known.name != name);
    }

    /// The page of a description's dictionary.
    ///
    /// # Errors
    /// If there is no such description.
    #[wasm_bindgen(js_name = descriptionPage)]
    pub fn description_page(&self, name: &str) -> Answer<Vec<u8>> {
        self.description(name)?.page().map_err(error)
    }

    /// What is wrong in a description: JSON as of `eds check`.
    ///
    /// # Errors
    /// If there is no such description.
    #[wasm_bindgen(js_name = descriptionFindings)]
    pub fn description_findings(&self, name: &str) -> Answer<String> {
        Ok(self.description(name)?.findings().to_string())
    }

    /// The same in words.
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

    /// Begins to read the captures.
    ///
    /// # Errors
    /// If one can't be opened.
    pub fn open(&mut self) -> Answer<()> {
        (self.opening, self.opened, self.selection) = (None, None, None);
        (self.search, self.plots) = (None, None);
        self.opening = Some(Opening::begin(&self.files, &self.options, &self.described).map_err(error)?);
        Ok(())
    }

    /// Reads so many records on; JSON says how far it is.
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

    fn opened(&self) -> Answer<&Opened> {
        self.opened.as_ref().ok_or_else(|| error("no capture is open"))
    }

    /// What the captures are, in short: JSON.
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

    /// So many rows from the n-th on, of those chosen: JSON.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn rows(&self, from: u32, count: u32) -> Answer<String> {
        let (opened, from, count) = (self.opened()?, from as usize, count as usize);
        let places = match &self.selection {
            Some(selection) => selection.places(from, count),
            None => (from..opened.store.len().min(from + count)).collect(),
        };
        serde_json::to_string(&rows(&opened.store, &places, opened.input.merge().channels())).map_err(error)
    }

    /// All that is known of a frame: JSON.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn details(&self, row: u32) -> Answer<String> {
        let opened = self.opened()?;
        Ok(details(&opened.store, row as usize, opened.input.merge().channels()).to_string())
    }

    /// Says whether a text is a filter: JSON, with the place of what is wrong in it.
    #[wasm_bindgen(js_name = checkFilter)]
    pub fn check_filter(text: &str) -> String {
        match filter(text) {
            Ok(_) => json!({ "ok": true }),
            Err(FilterError { column, expected, found, .. }) => {
                json!({ "ok": false, "column": column, "expected": expected, "found": found })
            }
        }
        .to_string()
    }

    /// Chooses the rows that pass a filter and hold a text; both empty: all.
    ///
    /// # Errors
    /// If no capture is open, or the filter is none.
    pub fn choose(&mut self, expression: &str, text: &str) -> Answer<()> {
        let filter = filter(expression).map_err(error)?;
        let chosen = (filter.is_some() || !text.is_empty()).then(|| Wanted::new(filter, text));
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        self.selection = chosen.map(|wanted| Selection::new(wanted, &opened.store));
        Ok(())
    }

    /// Looks at so many records on; JSON says how far it is.
    ///
    /// # Errors
    /// If no capture is open.
    #[wasm_bindgen(js_name = chooseOn)]
    pub fn choose_on(&mut self, records: u32) -> Answer<String> {
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        let len = opened.store.len();
        let told = match &mut self.selection {
            None => json!({ "more": false, "looked": len, "rows": len, "all": len }),
            Some(selection) => {
                let more = selection.step(&opened.store, records as usize, opened.input.merge().channels());
                json!({ "more": more, "looked": selection.looked_at(), "rows": selection.len(), "all": len })
            }
        };
        Ok(told.to_string())
    }

    /// Where a frame stands among the rows chosen.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn rank(&self, row: u32) -> Answer<u32> {
        let row = (row as usize).min(self.opened()?.store.len());
        Ok(self.selection.as_ref().map_or(row, |selection| selection.rank(row)) as u32)
    }

    /// The first frame so many seconds after the start, or later.
    ///
    /// # Errors
    /// If no capture is open.
    #[wasm_bindgen(js_name = rowAt)]
    pub fn row_at(&self, seconds: f64) -> Answer<u32> {
        let store = &self.opened()?.store;
        let start = store.start().unwrap_or_default();
        Ok(row_at(store, start + Duration((seconds.max(0.0) * 1e9) as u64)) as u32)
    }

    /// Looks for a text after a row, or before it.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn find(&mut self, text: &str, from: u32, backwards: bool) -> Answer<()> {
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        self.search = Some(Search::new(Wanted::new(None, text), &opened.store, from as usize, backwards));
        Ok(())
    }

    /// Looks at so many records on: JSON.
    ///
    /// # Errors
    /// If nothing is looked for.
    #[wasm_bindgen(js_name = findOn)]
    pub fn find_on(&mut self, records: u32) -> Answer<String> {
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        let search = self.search.as_mut().ok_or_else(|| error("nothing is looked for"))?;
        let more = search.step(&opened.store, records as usize, opened.input.merge().channels());
        Ok(json!({ "more": more, "found": search.found() }).to_string())
    }

    /// Begins to gather the values of PDOs.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn plots(&mut self) -> Answer<()> {
        self.plots = Some(Plots::new(&self.opened()?.store));
        Ok(())
    }

    /// Looks at so many records on; JSON says how far it is, and at the end what there is to draw.
    ///
    /// # Errors
    /// If nothing is gathered.
    #[wasm_bindgen(js_name = plotsOn)]
    pub fn plots_on(&mut self, records: u32) -> Answer<String> {
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        let plots = self.plots.as_mut().ok_or_else(|| error("no values are gathered"))?;
        let channels = opened.input.merge().channels();
        let more = plots.step(&opened.store, records as usize, channels).map_err(error)?;
        let mut told = if more { json!({}) } else { plots.columns() };
        told["more"] = more.into();
        (told["looked"], told["all"]) = (plots.looked_at().into(), opened.store.len().into());
        Ok(told.to_string())
    }

    /// Times and values of a column between two times, thinned out to about so many.
    pub fn points(&self, column: u32, from: f64, to: f64, parts: u32) -> Vec<f64> {
        self.plots.as_ref().map_or_else(Vec::new, |plots| plots.points(column as usize, from, to, parts as usize))
    }

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

    /// Begins an export; `wish` is JSON.
    ///
    /// # Errors
    /// If it can't be made.
    pub fn export(&mut self, wish: &str) -> Answer<()> {
        let wish: Wish = serde_json::from_str(wish).map_err(error)?;
        self.export = Some(Export::begin(&self.files, &self.options, &self.described, &wish).map_err(error)?);
        Ok(())
    }

    /// The next piece of the export; nothing at its end.
    ///
    /// # Errors
    /// If it can't be made.
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

    /// How far the export is: JSON.
    #[wasm_bindgen(js_name = exportProgress)]
    pub fn export_progress(&self) -> String {
        self.export.as_ref().map_or(Value::Null, |export| progress(export.input(), true)).to_string()
    }

    /// The formats that captures can be written in: JSON.
    #[wasm_bindgen(js_name = formats)]
    pub fn formats() -> String {
        let written = Format::all().filter(|format| format.is_written());
        Value::from(written.map(|format| json!({ "id": format.id() })).collect::<Vec<_>>()).to_string()
    }
}
