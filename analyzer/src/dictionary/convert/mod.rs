//! From one format of descriptions to another: EDS and XDD for a type of device, DCF and XDC for a configured one.

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
    /// CiA 306, for a type of device.
    Eds,
    /// CiA 306, for a configured device.
    Dcf,
    /// CiA 311, for a type of device.
    Xdd,
    /// CiA 311, for a configured device.
    Xdc,
}

impl Form {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Eds, Self::Dcf, Self::Xdd, Self::Xdc];

    /// Its name, and how its files end.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Eds => "eds",
            Self::Dcf => "dcf",
            Self::Xdd => "xdd",
            Self::Xdc => "xdc",
        }
    }

    /// The format of that name, in any case.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|form| name.eq_ignore_ascii_case(form.name()))
    }

    /// Whether it is for one configured device.
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
    /// It can't be read.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// A type of device has no configuration that could be written.
    #[error("it describes a type of device, and {0} is for one that is configured: write EDS or XDD")]
    NotConfigured(Form),
}

/// A file in the other format.
#[derive(Clone, Debug)]
pub struct Converted {
    /// Its text; the file is UTF-8.
    pub text: String,
    /// What of the first file is not in it.
    pub losses: Vec<Loss>,
}

/// The description in that file as one of another format. `file_name` is what the new file is called.
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

/// A description in that format, and what of it is not in the text.
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
