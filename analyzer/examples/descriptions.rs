//! Writes device descriptions for measurements: `descriptions FOLDER FILES OBJECTS [findings]` writes FILES files of
//! OBJECTS objects each. A quarter of the objects have four sub-indexes. With `findings` each object with a single
//! value has one finding.

#![allow(clippy::print_stderr)]

use std::fmt::Write;
use std::path::Path;

/// The first index; the other objects follow it without a gap.
const FIRST: u32 = 0x2001;

/// A description of `objects` objects; each file has another vendor.
fn description(file: u32, objects: u32, has_findings: bool) -> String {
    let mut text = format!(
        "[FileInfo]\nFileName={file:04}.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\nDescription=measured\n\
         CreationTime=09:00AM\nCreationDate=11-21-2026\nCreatedBy=canvass\n[DeviceInfo]\nVendorName=Vendor\n\
         VendorNumber={file}\nProductName=Product\nProductNumber=1\nRevisionNumber=1\nOrderCode=1\nBaudRate_250=1\n\
         Granularity=8\nNrOfRXPDO=0\nNrOfTXPDO=0\nLSS_Supported=0\n[DummyUsage]\nDummy0005=0\n[Comments]\nLines=0\n\
         [MandatoryObjects]\nSupportedObjects=0\n[OptionalObjects]\nSupportedObjects=0\n\
         [ManufacturerObjects]\nSupportedObjects={objects}\n"
    );
    // Writing to a string can't fail.
    for number in 1..=objects {
        let _ = writeln!(text, "{number}=0x{:04X}", FIRST - 1 + number);
    }
    for number in 1..=objects {
        let index = FIRST - 1 + number;
        if number % 4 == 0 {
            let _ = writeln!(text, "[{index:04X}]\nParameterName=Settings {number}\nObjectType=0x8\nSubNumber=4");
            let _ = writeln!(
                text,
                "[{index:04X}sub0]\nParameterName=Highest sub-index\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\n\
                 DefaultValue=3\nPDOMapping=0"
            );
            for sub in 1..=3 {
                let _ = writeln!(text, "[{index:04X}sub{sub}]\nParameterName=Setting {sub}\n{}", variable(5));
            }
        } else {
            let default = if has_findings { 2000 } else { 5 };
            let _ = writeln!(text, "[{index:04X}]\nParameterName=Setting {number}\n{}", variable(default));
        }
    }
    text
}

/// The fields of a single value; 0 to 1000 are allowed.
fn variable(default: u32) -> String {
    format!(
        "ObjectType=0x7\nDataType=0x0006\nAccessType=rw\nLowLimit=0\nHighLimit=1000\nDefaultValue={default}\n\
         PDOMapping=0"
    )
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Vec<u32> = words.iter().skip(1).map_while(|word| word.parse().ok()).collect();
    let (Some(folder), &[files, objects]) = (words.first(), &numbers[..]) else {
        eprintln!("usage: descriptions FOLDER FILES OBJECTS [findings]");
        std::process::exit(2);
    };
    let has_findings = words.last().is_some_and(|word| word == "findings");
    for file in 0..files {
        let path = Path::new(folder).join(format!("{file:04}.eds"));
        let written = std::fs::write(&path, description(file, objects, has_findings));
        if let Err(error) = written {
            eprintln!("{}: {error}", path.display());
            std::process::exit(1);
        }
    }
}
