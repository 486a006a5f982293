//! Conversion between formats of descriptions: EDS and XDD for a type of device, DCF and XDC for a configured device.

mod prepare;

#[cfg(test)]
mod tests;

use super::description::DeviceDescription;
use super::eds;
use super::loss::Loss;
use super::source::{DescriptionError, Source};
use super::xdd;
use std::fmt;

/// A format of device descriptions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// EDS: CiA 306, a type of device.
    Eds,
    /// DCF: CiA 306, a configured device.
    Dcf,
    /// XDD: CiA 311, a type of device.
    Xdd,
    /// XDC: CiA 311, a configured device.
    Xdc,
}

impl Form {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Eds, Self::Dcf, Self::Xdd, Self::Xdc];

    /// The name of the format, which is also the extension of its files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Eds => "eds",
            Self::Dcf => "dcf",
            Self::Xdd => "xdd",
            Self::Xdc => "xdc",
        }
    }

    /// Whether the format describes one configured device.
    pub const fn is_configuration(self) -> bool {
        matches!(self, Self::Dcf | Self::Xdc)
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Eds => "EDS",
            Self::Dcf => "DCF",
            Self::Xdd => "XDD",
            Self::Xdc => "XDC",
        })
    }
}

/// Why a description can't be converted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConvertError {
    /// The description can't be read.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The description of a type of device has no configuration to write.
    #[error("the description is of a device type, but {0} is for a configured device: write EDS or XDD")]
    NotConfigured(Form),
}

/// A converted description.
#[derive(Clone, Debug)]
pub struct Converted {
    /// The text; the file is UTF-8.
    pub text: String,
    /// The parts of the original file that the new format can't hold.
    pub losses: Vec<Loss>,
}

/// Converts a description to another format. `file_name` is the name of the new file.
pub fn convert(bytes: &[u8], form: Form, file_name: Option<&str>) -> Result<Converted, ConvertError> {
    let source = Source::read(bytes)?;
    let mut description = DeviceDescription::of(&source)?;
    let mut losses = description.unkept(&source);
    if let Some(name) = file_name {
        name.clone_into(&mut description.file.name);
    }
    let (text, lost) = write(description, form)?;
    losses.extend(lost);
    Ok(Converted { text, losses })
}

/// Writes a description in a format; returns also the parts that the format can't hold.
pub fn write(mut description: DeviceDescription, form: Form) -> Result<(String, Vec<Loss>), ConvertError> {
    if form.is_configuration() && !description.is_configuration() {
        return Err(ConvertError::NotConfigured(form));
    }
    let mut losses = prepare::expand(&mut description);
    if !form.is_configuration() && description.is_configuration() {
        losses.extend(prepare::without_configuration(&mut description));
    }
    let (text, lost) = match form {
        Form::Eds | Form::Dcf => eds::write(&description),
        Form::Xdd | Form::Xdc => xdd::write(&description),
    };
    losses.extend(lost);
    Ok((text, losses))
}
