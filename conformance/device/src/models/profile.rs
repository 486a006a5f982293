//! The seam for device profiles: what a profile reads of a model's sheet, and what it sees in a description alone.

use canvass_analyzer::dictionary::DeviceDescription;
use serde::de::{Deserialize, Deserializer, IgnoredAny};
use std::any::Any;
use std::sync::Arc;
use toml::Table;

/// What a device profile knows of its models beside their objects.
pub trait ProfileSheet: Sync {
    /// The number of the profile, as in the low word of 1000h.
    fn number(&self) -> u16;

    /// The table `[application]` of a sheet.
    ///
    /// # Errors
    /// What is wrong in the table, with its line.
    fn read(&self, sheet: &str) -> Result<ApplicationSheet, toml::de::Error>;

    /// The same for a device of which there is no sheet: what its description shows. Tables and rows that the description
    /// shows too are added to `sheet`.
    fn describe(&self, _: &DeviceDescription, _sheet: &mut Table) -> ApplicationSheet {
        ApplicationSheet::default()
    }
}

/// A profile that reads sheets.
pub struct RegisteredSheet(pub &'static dyn ProfileSheet);

inventory::collect!(RegisteredSheet);

/// What a sheet says to the application of the device, as the profile has read it.
#[derive(Clone, Debug, Default)]
pub struct ApplicationSheet(Option<Arc<dyn Any + Send + Sync>>);

impl ApplicationSheet {
    /// What a profile has read.
    pub fn new<T: Any + Send + Sync>(read: T) -> Self {
        Self(Some(Arc::new(read)))
    }

    /// What the profile has read; `None` where there is nothing, or another profile's.
    pub fn get<T: Any + Send + Sync>(&self) -> Option<&T> {
        self.0.as_ref()?.downcast_ref()
    }
}

/// The profile reads the table itself, beside the rest.
impl<'de> Deserialize<'de> for ApplicationSheet {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        IgnoredAny::deserialize(from).map(|_| Self::default())
    }
}

/// The table of the sheet of a described device.
pub(super) fn read(description: &DeviceDescription, sheet: &str) -> Result<ApplicationSheet, toml::de::Error> {
    of(description).map_or_else(|| Ok(ApplicationSheet::default()), |profile| profile.read(sheet))
}

/// What the description of a device without sheet shows.
pub(super) fn describe(description: &DeviceDescription, sheet: &mut Table) -> ApplicationSheet {
    of(description).map_or_else(ApplicationSheet::default, |profile| profile.describe(description, sheet))
}

fn of(description: &DeviceDescription) -> Option<&'static dyn ProfileSheet> {
    let number = description.device_profile()?;
    inventory::iter::<RegisteredSheet>.into_iter().map(|known| known.0).find(|profile| profile.number() == number)
}
