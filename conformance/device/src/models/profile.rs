//! The interface to device profiles: a profile reads its part of a model's sheet, or derives it from a description.

use canvass_analyzer::dictionary::DeviceDescription;
use serde::de::{Deserialize, Deserializer, IgnoredAny};
use std::any::Any;
use std::sync::Arc;
use toml::Table;

/// The knowledge of a device profile about its models, besides their objects.
pub trait ProfileSheet: Sync {
    /// The number of the profile, as in the low word of 1000h.
    fn number(&self) -> u16;

    /// Reads the table `[application]` of a sheet.
    ///
    /// # Errors
    /// The error in the table, with its line.
    fn read(&self, sheet: &str) -> Result<ApplicationSheet, toml::de::Error>;

    /// Derives the table from the description of a device without sheet. The profile adds to `sheet` the further tables
    /// and rows that follow from the description.
    fn describe(&self, _: &DeviceDescription, _sheet: &mut Table) -> ApplicationSheet {
        ApplicationSheet::default()
    }
}

/// A registered profile that reads sheets.
pub struct RegisteredSheet(pub &'static dyn ProfileSheet);

inventory::collect!(RegisteredSheet);

/// The part of a sheet that concerns the device's application, as the profile has read it.
#[derive(Clone, Debug, Default)]
pub struct ApplicationSheet(Option<Arc<dyn Any + Send + Sync>>);

impl ApplicationSheet {
    /// Wraps the data that a profile has read.
    pub fn new<T: Any + Send + Sync>(read: T) -> Self {
        Self(Some(Arc::new(read)))
    }

    /// The data that the profile has read; `None` if there is none, or if another profile has read it.
    pub fn get<T: Any + Send + Sync>(&self) -> Option<&T> {
        self.0.as_ref()?.downcast_ref()
    }
}

/// Skips the table, as the profile reads it itself.
impl<'de> Deserialize<'de> for ApplicationSheet {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        IgnoredAny::deserialize(from).map(|_| Self::default())
    }
}

/// Reads the table `[application]` of a sheet by the profile that the description names.
pub(super) fn read(description: &DeviceDescription, sheet: &str) -> Result<ApplicationSheet, toml::de::Error> {
    of(description).map_or_else(|| Ok(ApplicationSheet::default()), |profile| profile.read(sheet))
}

/// Derives the table `[application]` from the description of a device without sheet.
pub(super) fn describe(description: &DeviceDescription, sheet: &mut Table) -> ApplicationSheet {
    of(description).map_or_else(ApplicationSheet::default, |profile| profile.describe(description, sheet))
}

fn of(description: &DeviceDescription) -> Option<&'static dyn ProfileSheet> {
    let number = description.device_profile()?;
    inventory::iter::<RegisteredSheet>.into_iter().map(|known| known.0).find(|profile| profile.number() == number)
}
