//! Objects as typed: by address or by name.

use anyhow::{Result, bail};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DeviceDescription;

/// The address of an object: `1018:01`, `0x1018:1`, `1018h:01`, `1018` for sub-index 0, a name, or a part of only one
/// name.
pub fn resolve(text: &str, description: Option<&DeviceDescription>) -> Result<Multiplexer> {
    if let Some(address) = parse(text) {
        return Ok(address);
    }
    let Some(description) = description else {
        bail!("expected INDEX:SUB in hexadecimal, such as 1018:01, found \"{text}\"; names need --device");
    };
    let wanted = text.to_lowercase();
    let named = names(description);
    let exact: Vec<_> = named.iter().filter(|(name, _)| *name == wanted).collect();
    let partly: Vec<_> = named.iter().filter(|(name, _)| name.contains(&wanted)).collect();
    match (exact.as_slice(), partly.as_slice()) {
        ([(_, address), ..], _) | (_, [(_, address)]) => Ok(*address),
        (_, []) => bail!("the description has no object named \"{text}\", and it is no INDEX:SUB such as 1018:01"),
        (_, many) => {
            let first: Vec<String> = many.iter().take(8).map(|(name, at)| format!("{at} {name}")).collect();
            let more = if many.len() > first.len() { ", ..." } else { "" };
            bail!("\"{text}\" is the name of {} objects: {}{more}", many.len(), first.join(", "))
        }
    }
}

/// All entries by lower-case name: the object's name for a VAR, else object and entry.
fn names(description: &DeviceDescription) -> Vec<(String, Multiplexer)> {
    let objects = description.dictionary.objects().iter();
    let entries = objects.flat_map(|object| object.entries().iter().map(move |entry| (object, entry)));
    let named = entries.map(|(object, entry)| {
        let name =
            if object.code.is_single() { object.name.clone() } else { format!("{}, {}", object.name, entry.name) };
        (name.to_lowercase(), Multiplexer::new(object.index.0, entry.sub.0))
    });
    named.collect()
}

/// Parses a hexadecimal number: `1018`, `0x1018`, `1018h`.
pub fn hexadecimal(text: &str) -> Option<u16> {
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")).unwrap_or(text);
    let digits = digits.strip_suffix(['h', 'H']).unwrap_or(digits);
    u16::from_str_radix(digits, 16).ok()
}

fn parse(text: &str) -> Option<Multiplexer> {
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    // "Dead" is a valid hexadecimal number, but more likely a name; so an address needs a digit, a prefix or a
    // suffix.
    let is_index = index.trim_start_matches("0x").trim_end_matches('h').len() == 4;
    let sub = u8::try_from(hexadecimal(sub)?).ok()?;
    is_index.then(|| hexadecimal(index).map(|index| Multiplexer::new(index, sub)))?
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;

    #[test]
    fn addresses_as_people_write_them() {
        for text in ["1018:01", "0x1018:1", "1018h:01", "1018h:1h"] {
            assert_eq!(resolve(text, None).unwrap(), Multiplexer::new(object::IDENTITY, 1), "{text}");
        }
        assert_eq!(resolve("6004", None).unwrap(), Multiplexer::new(0x6004, 0));
        for text in ["", "1018:", "18:1", "1018:100", "Position value"] {
            assert!(resolve(text, None).is_err(), "{text}");
        }
    }

    #[test]
    fn names_of_the_description() {
        let encoder = super::super::encoder();
        let resolved = |text: &str| resolve(text, Some(&encoder));
        assert_eq!(resolved("position value").unwrap(), Multiplexer::new(0x6004, 0));
        assert_eq!(resolved("Identity object, vendor-ID").unwrap().index.0, object::IDENTITY);
        let error = resolved("identity").unwrap_err().to_string();
        assert!(error.contains("1018h:01"), "{error}");
        assert!(resolved("nonsense").unwrap_err().to_string().contains("no object named"));
    }
}
