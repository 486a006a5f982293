//! What tells that a node is of a model, where the defaults of its EDS do not.

use super::sheet::address;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::network::{Candidate, Fact};
use serde::Deserialize;

/// The table `[recognition]` of a sheet.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recognition {
    /// Objects of which a node of this model has one of these values: in place of the default of the EDS, or beside it.
    #[serde(default, rename = "number")]
    pub numbers: Vec<Number>,
    /// Objects of which a node of this model has a text that begins so.
    #[serde(default, rename = "text")]
    pub texts: Vec<Text>,
}

/// The values of an object.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Number {
    /// The object.
    #[serde(deserialize_with = "address")]
    pub at: Multiplexer,
    /// Its values.
    pub any: Vec<u32>,
}

/// The text of an object.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// The object.
    #[serde(deserialize_with = "address")]
    pub at: Multiplexer,
    /// How it begins.
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
