//! Facts by which a node is recognised as a model, besides the defaults of the EDS.

use super::sheet::address;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::network::{Candidate, Fact};
use serde::Deserialize;

/// The table `[recognition]` of a sheet.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recognition {
    /// Objects with the values by which a node of this model is recognised, in place of the default of the EDS or in
    /// addition to it.
    #[serde(default, rename = "number")]
    pub numbers: Vec<Number>,
    /// Objects with the beginning of the text by which a node of this model is recognised.
    #[serde(default, rename = "text")]
    pub texts: Vec<Text>,
}

/// The possible values of an object in nodes of the model.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// The object.
    #[serde(deserialize_with = "address")]
    pub at: Multiplexer,
    /// The possible values: a node of the model has one of them.
    pub any: Vec<u32>,
}

/// The beginning of the text of an object in nodes of the model.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// The object.
    #[serde(deserialize_with = "address")]
    pub at: Multiplexer,
    /// The text with which the object's value begins.
    pub begins: String,
}

impl Recognition {
    /// Sets these facts in place of the defaults of the EDS.
    pub(super) fn refine(&self, candidate: &mut Candidate) {
        for number in &self.numbers {
            candidate.set(number.at, Fact::Number(number.any.clone()));
        }
        for text in &self.texts {
            candidate.set(text.at, Fact::Begins(text.begins.clone()));
        }
    }
}
