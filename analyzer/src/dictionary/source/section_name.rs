//! The meaning of a section's name.

use super::names::canonical;

/// The kinds of sections that CiA 306 defines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::dictionary) enum SectionName {
    FileInfo,
    DeviceInfo,
    DeviceCommissioning,
    DummyUsage,
    Comments,
    MandatoryObjects,
    OptionalObjects,
    ManufacturerObjects,
    SupportedModules,
    ConnectedModules,
    DynamicChannels,
    /// `Tools`, `Tool1`…: entries for configuration tools.
    Tools,
    /// `1018`: an object.
    Object(u16),
    /// `1018sub1`: an entry of an object; the sub-index is hexadecimal.
    Sub(u16, u8),
    /// `1003Name`, `1003Value`, `1003Denotation`, `1003ObjectLinks`: additions to an object.
    Beside(u16),
    /// `M1…`: a part of the description of a module.
    Module(u16, ModulePart),
    Unknown,
}

/// The sections of one module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::dictionary) enum ModulePart {
    Info,
    Comments,
    FixedObjects,
    /// `M1Fixed6000`: an object that the module adds.
    Fixed(u16),
    /// `M1Fixed6000sub1`: an entry of an object that the module adds.
    FixedSub(u16, u8),
    SubExtends,
    /// `M1SubExt6000`: sub-indexes that the module adds to an object.
    SubExtension(u16),
}

impl SectionName {
    /// The object or entry of a section name in the standard's spelling, ignoring case; most sections have this
    /// spelling.
    pub(crate) fn parse_standard(name: &str) -> Option<Self> {
        let (index, rest) = name.as_bytes().split_first_chunk::<4>()?;
        let index = index.iter().try_fold(0, |index, &digit| Some(index << 4 | u16::from(nibble(digit)?)))?;
        Some(match rest {
            [] => Self::Object(index),
            [s, u, b, digits @ ..] if [s, u, b].map(u8::to_ascii_lowercase) == *b"sub" => match digits {
                [low] => Self::Sub(index, nibble(*low)?),
                [high, low] if *high != b'0' => Self::Sub(index, nibble(*high)? << 4 | nibble(*low)?),
                _ => return None,
            },
            _ => return None,
        })
    }

    pub fn parse(name: &str) -> Self {
        if let Some(standard) = Self::parse_standard(name) {
            return standard;
        }
        match &*canonical(name) {
            "fileinfo" => Self::FileInfo,
            "deviceinfo" => Self::DeviceInfo,
            // The standard spells the name with one m; files have both spellings.
            "devicecomissioning" | "devicecommissioning" => Self::DeviceCommissioning,
            "dummyusage" => Self::DummyUsage,
            "comments" => Self::Comments,
            "mandatoryobjects" => Self::MandatoryObjects,
            "optionalobjects" => Self::OptionalObjects,
            "manufacturerobjects" => Self::ManufacturerObjects,
            "supportedmodules" => Self::SupportedModules,
            "connectedmodules" => Self::ConnectedModules,
            "dynamicchannels" => Self::DynamicChannels,
            name if is_tool(name) => Self::Tools,
            name => object(name).or_else(|| module(name)).unwrap_or(Self::Unknown),
        }
    }
}

/// The name of an object's or a sub-index's section in the form of CiA 306.
pub(in crate::dictionary) fn standard_section_name(name: &str) -> Option<String> {
    match SectionName::parse(name) {
        SectionName::Object(index) => Some(format!("{index:04X}")),
        SectionName::Sub(index, sub) => Some(format!("{index:04X}sub{sub:X}")),
        _ => None,
    }
}

fn is_tool(name: &str) -> bool {
    let number = name.strip_prefix("tool").unwrap_or("-");
    number == "s" || (!number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit()))
}

/// Parses `1018`, `1018sub1`, `1003name`; also with `0x` before it.
fn object(name: &str) -> Option<SectionName> {
    let name = name.strip_prefix("0x").unwrap_or(name);
    let (index, rest) = name.split_at_checked(4)?;
    let index = hexadecimal(index)?;
    Some(match rest {
        "" => SectionName::Object(index),
        "name" | "value" | "denotation" | "objectlinks" => SectionName::Beside(index),
        _ => SectionName::Sub(index, u8::try_from(hexadecimal(rest.strip_prefix("sub")?)?).ok()?),
    })
}

fn module(name: &str) -> Option<SectionName> {
    let rest = name.strip_prefix('m')?;
    let end = rest.find(|character: char| !character.is_ascii_digit())?;
    let (number, part) = rest.split_at_checked(end)?;
    let part = match part {
        "moduleinfo" => ModulePart::Info,
        "comments" => ModulePart::Comments,
        "fixedobjects" => ModulePart::FixedObjects,
        "subextends" => ModulePart::SubExtends,
        _ => match (part.strip_prefix("fixed"), part.strip_prefix("subext")) {
            (Some(fixed), _) => match object(fixed)? {
                SectionName::Object(index) => ModulePart::Fixed(index),
                SectionName::Sub(index, sub) => ModulePart::FixedSub(index, sub),
                _ => return None,
            },
            (_, Some(extension)) => ModulePart::SubExtension(hexadecimal(extension)?),
            _ => return None,
        },
    };
    Some(SectionName::Module(number.parse().ok()?, part))
}

/// The value of a hexadecimal digit.
const fn nibble(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        _ => None,
    }
}

fn hexadecimal(digits: &str) -> Option<u16> {
    let only_digits = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    if only_digits { u16::from_str_radix(digits, 16).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_the_same_in_any_case() {
        assert_eq!(SectionName::parse("1A00SUBa"), SectionName::Sub(0x1A00, 10));
        assert_eq!(SectionName::parse("1a00"), SectionName::Object(0x1A00));
        assert_eq!(SectionName::parse("1003sub10"), SectionName::Sub(0x1003, 16));
        assert_eq!(SectionName::parse(" 1003 Name"), SectionName::Beside(0x1003));
        assert_eq!(SectionName::parse("DeviceComissioning"), SectionName::DeviceCommissioning);
    }

    #[test]
    fn the_standard_has_no_other_spelling() {
        assert_eq!(SectionName::parse_standard("1A00SubFE"), Some(SectionName::Sub(0x1A00, 0xFE)));
        for other in ["0x1018", "1018sub01", "1018 sub1", "1018sub", "1018sub100", "1018subg", "101", "1003Name"] {
            assert_eq!(SectionName::parse_standard(other), None, "{other}");
        }
    }

    #[test]
    fn sections_of_modules() {
        assert_eq!(SectionName::parse("M12ModuleInfo"), SectionName::Module(12, ModulePart::Info));
        assert_eq!(SectionName::parse("M1Fixed6423"), SectionName::Module(1, ModulePart::Fixed(0x6423)));
        assert_eq!(SectionName::parse("M1Fixed6423sub1"), SectionName::Module(1, ModulePart::FixedSub(0x6423, 1)));
        assert_eq!(SectionName::parse("M1SubExt6000"), SectionName::Module(1, ModulePart::SubExtension(0x6000)));
    }

    #[test]
    fn everything_else_is_unknown() {
        for name in ["", "1", "100", "10000", "1018sub", "1018sub100", "1018subG", "+018", "M1", "Mx", "tool", "äöüß"]
        {
            assert_eq!(SectionName::parse(name), SectionName::Unknown, "{name}");
        }
    }
}
