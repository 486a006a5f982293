//! The built-in device models. Each model has two files: an EDS with the object dictionary, and a TOML sheet with facts
//! that an EDS cannot express.

mod annotations;
mod deviations;
#[cfg(test)]
pub(crate) mod documentation;
mod emergency;
mod generic;
mod network;
mod profile;
mod quirks;
mod recognition;
mod rules;
mod sheet;

pub use deviations::Deviation;
pub use emergency::{Emergency, Field};
pub(crate) use generic::{is_writable, written};
pub use network::{Network, StartUp, Trigger};
pub use profile::{ApplicationSheet, ProfileSheet, RegisteredSheet};
pub use quirks::Quirks;
pub use rules::{Check, Link, LinkKind, Rule};
pub use sheet::{BitRate, LmtAddress, Sheet, Storage, Timing, Value};

use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice, eds};
use canvass_analyzer::network::{Candidate, Candidates};
use canvass_analyzer::object;
use canvass_analyzer::{Multiplexer, NodeId};
use deviations::DeviationTables;
use std::sync::{Arc, LazyLock};

/// Hands the names and ids of the built-in models to a macro: `each_model!(row)` is `row! { name = "id", … }`. A model
/// is a line here, and its EDS and sheet in `models`; tests have one function for each line.
#[macro_export]
macro_rules! each_model {
    ($row:ident) => {
        $row! {
            kuebler_sendix_58x8 = "kuebler-sendix-58x8",
            kuebler_sendix_f58 = "kuebler-sendix-f58",
            kuebler_sendix_m58 = "kuebler-sendix-m58",
            kuebler_sendix_f58m = "kuebler-sendix-f58m",
            kuebler_c100 = "kuebler-c100",
            kuebler_d125 = "kuebler-d125",
            lika_ax58 = "lika-ax58",
            tr_c65 = "tr-c65",
            tr_lmp30 = "tr-lmp30",
            reference_301 = "reference-301",
            reference_406 = "reference-406",
        }
    };
}

macro_rules! files {
    ($($name:ident = $id:literal,)*) => {
        /// The ids of the models, in the order of the files.
        const IDS: &[&str] = &[$($id),*];
        /// The EDS and the sheet of each built-in model.
        const FILES: &[(&str, &str)] = &[$((include_str!(concat!("../../models/", $id, ".eds")), include_str!(concat!("../../models/", $id, ".toml")))),*];
    };
}

each_model!(files);

static MODELS: LazyLock<Result<Vec<Model>, UnreadableModel>> = LazyLock::new(|| {
    let read = |(id, (eds, sheet)): (&&'static str, &(&str, &str))| {
        Model::read(eds, sheet).map_err(|error| UnreadableModel { id, error })
    };
    IDS.iter().zip(FILES).map(read).collect()
});

/// A built-in model whose files can't be read. The program then has no built-in models.
#[derive(Debug, thiserror::Error)]
#[error("the built-in model {id} can't be read: {error}")]
pub struct UnreadableModel {
    id: &'static str,
    error: ModelError,
}

/// The built-in models.
///
/// # Errors
/// [`UnreadableModel`] if the files of a model can't be read.
pub fn built_in() -> Result<&'static [Model], &'static UnreadableModel> {
    MODELS.as_deref()
}

/// A device type: its description, and the facts that a simulated device of this type needs.
#[derive(Clone, Debug)]
pub struct Model {
    device: Arc<KnownDevice>,
    sheet: Arc<Sheet>,
    deviations: Arc<[Deviation]>,
    described_alone: bool,
}

/// Why a model's files could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The EDS can't be read.
    #[error("the EDS: {0}")]
    Description(#[from] eds::DescriptionError),
    #[error("the sheet: {0}")]
    Sheet(#[from] toml::de::Error),
    /// The default node-ID in the sheet is not from 1 to 127.
    #[error("the sheet: expected a default node-ID from 1 to 127, found {0}")]
    NodeId(u8),
}

impl Model {
    /// The built-in models; none if the files of one model can't be read (see [`built_in`]).
    pub fn all() -> &'static [Self] {
        built_in().unwrap_or_default()
    }

    /// The built-in model with this id.
    pub fn by_id(id: &str) -> Option<&'static Self> {
        Self::all().iter().find(|model| model.id() == id)
    }

    /// A model from the text of its two files.
    ///
    /// # Errors
    /// [`ModelError`] if one of the texts can't be read.
    pub fn read(eds: &str, text: &str) -> Result<Self, ModelError> {
        let mut sheet: Sheet = toml::from_str(text)?;
        if let Some(node) = sheet.network.default_node_id {
            NodeId::new(node).ok_or(ModelError::NodeId(node))?;
        }
        let description = eds::read(eds.as_bytes())?;
        sheet.application = profile::read(&description, text)?;
        let deviations: DeviationTables = toml::from_str(text)?;
        let deviations = deviations.deviations().into();
        let device = KnownDevice { description, manual: sheet.manual_facts() };
        Ok(Self { device: Arc::new(device), sheet: Arc::new(sheet), deviations, described_alone: false })
    }

    /// A model from an EDS, DCF, XDD or XDC alone. The device has every optional service whose parameters are in the
    /// object dictionary. `name` becomes the model's id.
    ///
    /// # Errors
    /// [`ModelError::Description`] if the bytes are no device description.
    pub fn generic(name: &str, bytes: &[u8]) -> Result<Self, ModelError> {
        let description = DeviceDescription::read(bytes)?;
        let sheet = generic::sheet(name, &description)?;
        let device = KnownDevice::described(description);
        let (device, sheet) = (Arc::new(device), Arc::new(sheet));
        Ok(Self { device, sheet, deviations: Arc::new([]), described_alone: true })
    }

    /// A copy of the model with another description and another sheet.
    pub(crate) fn with(&self, description: DeviceDescription, sheet: Sheet) -> Self {
        let deviations = Arc::clone(&self.deviations);
        let device = KnownDevice { description, manual: self.device.manual.clone() };
        Self { device: Arc::new(device), sheet: Arc::new(sheet), deviations, described_alone: self.described_alone }
    }

    /// Whether the model was made from a description alone. The device then has the behaviour and the errors of that
    /// description.
    pub const fn is_described_alone(&self) -> bool {
        self.described_alone
    }

    /// The facts by which a node is recognised as this model.
    pub fn candidate(&self) -> Candidate {
        let mut candidate = Candidate::of(self.id(), Arc::clone(&self.device));
        self.sheet.recognition.refine(&mut candidate);
        candidate
    }

    /// The facts by which a node is recognised as one of the built-in models, in the order of the models.
    pub fn candidates() -> Candidates {
        Candidates::new(|| Self::all().iter().map(Self::candidate).collect())
    }

    /// The name on the command line.
    pub fn id(&self) -> &str {
        &self.sheet.id
    }

    /// The description of the model in one line.
    pub fn summary(&self) -> &str {
        &self.sheet.summary
    }

    /// The node-ID as delivered; `None` if LSS must set it first.
    pub fn default_node(&self) -> Option<NodeId> {
        self.sheet.network.default_node_id.and_then(NodeId::new)
    }

    /// The bit rate as delivered, in bit/s.
    pub fn default_bit_rate(&self) -> u32 {
        self.sheet.network.default_bit_rate_kbit.saturating_mul(1_000)
    }

    /// The vendor-ID in the description: in 1018h, else in the head of the file.
    pub fn vendor(&self) -> Option<u32> {
        let description = self.description();
        let entry = description.dictionary.entry(Multiplexer::new(object::IDENTITY, 1)).ok();
        let number = entry.and_then(|entry| entry.default.as_ref()?.fixed()?.to_raw());
        number.and_then(|number| u32::try_from(number).ok()).or(description.device.vendor_number)
    }

    /// The device description.
    pub fn description(&self) -> &DeviceDescription {
        &self.device.description
    }

    /// The device description, together with the facts of the manual.
    pub fn device(&self) -> &Arc<KnownDevice> {
        &self.device
    }

    /// The text of the EDS; `None` if the model is not built in.
    pub fn eds_text(&self) -> Option<&'static str> {
        let position = Self::all().iter().position(|model| model.id() == self.id())?;
        FILES.get(position).map(|(eds, _)| *eds)
    }

    /// The documented differences from the standard, as far as conformance cases judge them.
    pub fn deviations(&self) -> &[Deviation] {
        &self.deviations
    }

    /// The facts about the device that the EDS does not express.
    pub fn sheet(&self) -> &Sheet {
        &self.sheet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_files_can_be_read() {
        for (eds, sheet) in FILES {
            let model = Model::read(eds, sheet).unwrap();
            assert!(Model::by_id(model.id()).is_some());
            assert!(!model.summary().is_empty());
        }
        assert_eq!(built_in().unwrap().len(), FILES.len());
    }

    /// A misspelt key would be a fact of the manual that the program ignores.
    #[test]
    fn unknown_keys_are_errors_in_every_table() {
        let (eds, sheet) = FILES[0];
        let reason = |text: String| Model::read(eds, &text).unwrap_err().to_string();
        assert!(reason(format!("bogus_key = 1\n{sheet}")).contains("bogus_key"));
        let tables = ["network", "timing", "storage", "application"].map(|table| format!("[{table}]\n"));
        let rows =
            ["bit_rate", "value", "link", "check", "signal", "bit", "emergency"].map(|row| format!("[[{row}]]\n"));
        for header in tables.iter().chain(&rows) {
            assert!(sheet.contains(header), "{header}");
            let error = reason(sheet.replacen(header, &format!("{header}bogus_key = 1\n"), 1));
            assert!(error.contains("bogus_key") && error.contains("line"), "{header}: {error}");
        }
    }
}
