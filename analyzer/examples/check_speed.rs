//! How long it takes to check a thousand descriptions of five hundred objects: `cargo run --release -p canvass-analyzer
//! --example check_speed`.

#![allow(clippy::print_stdout)]

use canvass_analyzer::dictionary::check::check;
use std::fmt::Write;
use std::time::Instant;

const FILES: u32 = 1000;
const OBJECTS: u32 = 500;

/// A description of that many objects, a quarter of them with four sub-indexes; each file has another vendor.
fn description(file: u32) -> String {
    let mut text = format!(
        "[FileInfo]\nFileName=speed.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\nDescription=speed\n\
         CreationTime=09:00AM\nCreationDate=11-21-2026\nCreatedBy=canvass\n[DeviceInfo]\nVendorName=Vendor\n\
         VendorNumber={file}\nProductName=Product\nProductNumber=1\nRevisionNumber=1\nOrderCode=1\nBaudRate_250=1\n\
         Granularity=8\nNrOfRXPDO=0\nNrOfTXPDO=0\nLSS_Supported=0\n[DummyUsage]\nDummy0005=0\n[Comments]\nLines=0\n\
         [MandatoryObjects]\nSupportedObjects=0\n[OptionalObjects]\nSupportedObjects=0\n\
         [ManufacturerObjects]\nSupportedObjects={OBJECTS}\n"
    );
    // Writing to a string can't fail.
    for number in 1..=OBJECTS {
        let _ = writeln!(text, "{number}=0x{:04X}", 0x2000 + number);
    }
    for number in 1..=OBJECTS {
        let index = 0x2000 + number;
        let variable =
            "ObjectType=0x7\nDataType=0x0006\nAccessType=rw\nLowLimit=0\nHighLimit=1000\nDefaultValue=5\nPDOMapping=0";
        if number % 4 == 0 {
            let _ = writeln!(text, "[{index:04X}]\nParameterName=Settings {number}\nObjectType=0x8\nSubNumber=4");
            let _ = writeln!(
                text,
                "[{index:04X}sub0]\nParameterName=Highest sub-index\nObjectType=0x7\nDataType=0x0005\nAccessType=ro\n\
                 DefaultValue=3\nPDOMapping=0"
            );
            for sub in 1..=3 {
                let _ = writeln!(text, "[{index:04X}sub{sub}]\nParameterName=Setting {sub}\n{variable}");
            }
        } else {
            let _ = writeln!(text, "[{index:04X}]\nParameterName=Setting {number}\n{variable}");
        }
    }
    text
}

fn main() {
    let files: Vec<String> = (0..FILES).map(description).collect();
    let bytes: usize = files.iter().map(String::len).sum();
    let mut best = f64::MAX;
    for _ in 0..3 {
        let start = Instant::now();
        let found: usize = files
            .iter()
            .filter_map(|text| check(text.as_bytes(), Some("speed.eds")).ok())
            .map(|checked| checked.findings.len())
            .sum();
        best = best.min(start.elapsed().as_secs_f64());
        println!("{FILES} files of {OBJECTS} objects, {:.0} MB: {best:.2} s, {found} findings", bytes as f64 / 1e6);
    }
}
