//! The frames of the captures, and the values in them.

use super::{Answer, Page, error, filter};
use crate::plots::Plots;
use crate::trace::details::details;
use crate::trace::rows::rows;
use crate::trace::selection::{Search, Selection, Wanted, row_at};
use canvass_analyzer::filter::{Completion, FilterError};
use canvass_traces::Duration;
use serde_json::json;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Page {
    /// `count` of the selected rows, from row `from` on, as JSON.
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

    /// The details of a frame, as JSON.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn details(&self, row: u32) -> Answer<String> {
        let opened = self.opened()?;
        Ok(details(&opened.store, row as usize, opened.input.merge().channels()).to_string())
    }

    /// Checks the syntax of a filter; returns JSON with the place and text of an error.
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

    /// The possible continuations of a partial filter, as JSON.
    pub fn completions(&self, text: &str) -> String {
        let channels = self.opened.iter().flat_map(|opened| opened.input.merge().channels().names());
        let Completion { from, words } = Completion::of(text, channels);
        // JavaScript counts positions in UTF-16 code units.
        let from = text.get(..from).unwrap_or_default().encode_utf16().count();
        json!({ "from": from, "words": words }).to_string()
    }

    /// Indexes the next `records` records for the list; returns the progress as JSON. Before the index is complete,
    /// rows far from the first take long, and `overview` is incomplete.
    ///
    /// # Errors
    /// If no capture is open.
    #[wasm_bindgen(js_name = indexOn)]
    pub fn index_on(&mut self, records: u32) -> Answer<String> {
        let opened = self.opened.as_mut().ok_or_else(|| error("no capture is open"))?;
        let more = opened.indexing.step(&mut opened.store, records as usize);
        let all = opened.store.len();
        Ok(json!({ "more": more, "looked": opened.indexing.looked_at(all), "all": all }).to_string())
    }

    /// The number of frames over time, as JSON.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn overview(&self) -> Answer<String> {
        Ok(self.opened()?.indexing.overview.told().to_string())
    }

    /// Selects the rows that pass a filter and contain a text; if both are empty, all rows.
    ///
    /// # Errors
    /// If no capture is open, or the filter is wrong.
    pub fn choose(&mut self, expression: &str, text: &str) -> Answer<()> {
        let filter = filter(expression).map_err(error)?;
        let chosen = (filter.is_some() || !text.is_empty()).then(|| Wanted::new(filter, text));
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        self.selection = chosen.map(|wanted| Selection::new(wanted, &opened.store));
        Ok(())
    }

    /// Filters the next `records` records; returns the progress as JSON.
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

    /// The position of a frame among the selected rows.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn rank(&self, row: u32) -> Answer<u32> {
        let row = (row as usize).min(self.opened()?.store.len());
        Ok(self.selection.as_ref().map_or(row, |selection| selection.rank(row)) as u32)
    }

    /// The first frame at or after `seconds` seconds from the start.
    ///
    /// # Errors
    /// If no capture is open.
    #[wasm_bindgen(js_name = rowAt)]
    pub fn row_at(&self, seconds: f64) -> Answer<u32> {
        let store = &self.opened()?.store;
        let start = store.start().unwrap_or_default();
        Ok(row_at(store, start + Duration((seconds.max(0.0) * 1e9).round() as u64)) as u32)
    }

    /// Begins to search for a text in the rows that pass a filter, after a row or before it; without a row in all of
    /// them.
    ///
    /// # Errors
    /// If no capture is open, or the filter is wrong.
    pub fn find(&mut self, expression: &str, text: &str, from: Option<u32>, backwards: bool) -> Answer<()> {
        let filter = filter(expression).map_err(error)?;
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        let from = from.map(|from| from as usize);
        self.search = Some(Search::new(Wanted::new(filter, text), &opened.store, from, backwards));
        Ok(())
    }

    /// Searches the next `records` records; returns the progress as JSON.
    ///
    /// # Errors
    /// If no search was begun.
    #[wasm_bindgen(js_name = findOn)]
    pub fn find_on(&mut self, records: u32) -> Answer<String> {
        let opened = self.opened.as_ref().ok_or_else(|| error("no capture is open"))?;
        let search = self.search.as_mut().ok_or_else(|| error("nothing is looked for"))?;
        let more = search.step(&opened.store, records as usize, opened.input.merge().channels());
        Ok(json!({ "more": more, "found": search.found() }).to_string())
    }

    /// Begins to collect the values of PDOs.
    ///
    /// # Errors
    /// If no capture is open.
    pub fn plots(&mut self) -> Answer<()> {
        self.plots = Some(Plots::new(&self.opened()?.store));
        Ok(())
    }

    /// Collects values from the next `records` records; returns the progress as JSON, and at the end the columns to
    /// draw.
    ///
    /// # Errors
    /// If no collection was begun.
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

    /// Times and values of a column between two times, reduced to the extremes of `parts` spans.
    pub fn points(&self, column: u32, from: f64, to: f64, parts: u32) -> Vec<f64> {
        self.plots.as_ref().map_or_else(Vec::new, |plots| plots.points(column as usize, from, to, parts as usize))
    }
}
