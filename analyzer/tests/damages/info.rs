//! Damage of FileInfo, DeviceInfo, DummyUsage, Comments and the commissioning of a DCF.

use super::{ANOTHER_EDS, Damage, Lines, Place};
use crate::dice::Dice;
use crate::eds::Eds;

pub const DAMAGES: &[(&str, Damage)] = &[
    ("eds/file/date", Lines(date)),
    ("eds/file/time", Lines(time)),
    ("eds/file/eds-version", Lines(version)),
    ("eds/file/name", Lines(|eds, dice| set(eds, "FileInfo", "FileName", &format!("{}.eds", dice.word())))),
    ("eds/file/last-eds", Lines(last_eds)),
    ("eds/file/field-missing", Lines(field_missing)),
    ("eds/file/comment-count", Lines(comment_count)),
    ("eds/device/bit-rate-missing", Lines(bit_rate_missing)),
    ("eds/device/pdo-count", Lines(pdo_count)),
    ("eds/device/identity", Lines(identity)),
    ("eds/device/lss-identity", Lines(lss)),
    ("eds/device/error-control", Lines(error_control)),
    ("eds/device/dummy-name", Lines(dummy)),
    ("eds/dcf/node-id", Lines(node_id)),
    ("eds/dcf/bit-rate", Lines(bit_rate)),
    ("eds/dcf/section-name", Lines(commissioning)),
    ("eds/dcf/open", Lines(open)),
    ("eds/dcf/download-file", Lines(download)),
    ("eds/dcf/other-eds", Lines(other_eds)),
];

fn set(eds: &mut Eds, section: &str, field: &str, value: &str) -> Option<Place> {
    let line = eds.field(eds.header(section)?, field)?;
    eds.set(line, value);
    Some(Place::Line(line))
}

fn date(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (year, month, day) = (dice.between(1990, 2099), dice.between(1, 12), dice.between(13, 31));
    let forms = [
        format!("{year}-{month:02}-{day:02}"),
        format!("{day:02}.{month:02}.{year}"),
        format!("{month:02}/{day:02}/{year}"),
        format!("{day:02}-{month:02}-{year}"),
        format!("{month:02}-{day:02}-{:02}", year % 100),
        format!("{month:02}-32-{year}"),
        format!("00-{day:02}-{year}"),
        dice.word(),
    ];
    set(eds, "FileInfo", dice.of(&["CreationDate", "ModificationDate"]), &dice.of(&forms))
}

fn time(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (hour, minute) = (dice.between(0, 23), dice.between(0, 59));
    let forms = [
        format!("{hour:02}:{minute:02}"),
        format!("{hour:02}:{minute:02}:00"),
        format!("{:02}:{minute:02}PM", hour % 10 + 13),
        format!("09:{}AM", minute + 60),
        format!("09.{minute:02}AM"),
        dice.word(),
    ];
    set(eds, "FileInfo", dice.of(&["CreationTime", "ModificationTime"]), &dice.of(&forms))
}

fn version(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let other = format!("{}.{}", dice.of(&[1, 2, 5, 9, 30, 43]), dice.below(10));
    let word = dice.word();
    let version = dice.of(&[other, word, "V4.0".to_owned()]);
    set(eds, "FileInfo", "EDSVersion", &version)
}

fn is_configuration(eds: &Eds) -> bool {
    eds.header("DeviceComissioning").is_some()
}

fn last_eds(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    if is_configuration(eds) {
        return None;
    }
    let name = format!("{}.eds", dice.word());
    let line = eds.put(eds.header("FileInfo")?, "LastEDS", name);
    Some(Place::Line(line))
}

fn field_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (section, field) = dice.of(&[
        ("FileInfo", "FileName"),
        ("FileInfo", "FileVersion"),
        ("FileInfo", "FileRevision"),
        ("FileInfo", "Description"),
        ("FileInfo", "CreationDate"),
        ("FileInfo", "CreatedBy"),
        ("DeviceInfo", "VendorName"),
        ("DeviceInfo", "VendorNumber"),
        ("DeviceInfo", "ProductName"),
        ("DeviceInfo", "ProductNumber"),
        ("DeviceInfo", "RevisionNumber"),
        ("DeviceInfo", "Granularity"),
        ("DeviceInfo", "NrOfRXPDO"),
        ("DeviceInfo", "NrOfTXPDO"),
        ("DeviceInfo", "LSS_Supported"),
    ]);
    let header = eds.header(section)?;
    let line = eds.field(header, field)?;
    eds.lines.remove(line);
    Some(Place::Line(header))
}

fn comment_count(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let header = eds.header("Comments")?;
    let count = eds.number_of(header, "Lines")?;
    match dice.below(3) {
        0 => {
            let line = eds.field(header, "Lines")?;
            eds.lines.remove(line);
            return Some(Place::Line(header)).filter(|_| count > 0);
        }
        1 => eds.put(header, &format!("Line{}", count + 1), "One more"),
        _ => eds.put(header, "Lines", count + dice.between(1, 9)),
    };
    Some(Place::Line(eds.field(header, "Lines")?))
}

fn bit_rate_missing(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let header = eds.header("DeviceInfo")?;
    let mut rates = eds.fields(header);
    rates.retain(|&line| eds.key(line).starts_with("BaudRate"));
    for line in rates.into_iter().rev() {
        if dice.heads() {
            eds.set(line, 0);
        } else {
            eds.lines.remove(line);
        }
    }
    Some(Place::Line(header))
}

fn pdo_count(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let field = dice.of(&["NrOfRXPDO", "NrOfTXPDO"]);
    let count = eds.number_of(eds.header("DeviceInfo")?, field)?;
    set(eds, "DeviceInfo", field, &(count + dice.between(1, 99)).to_string())
}

fn identity(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (sub, field) = dice.of(&[(1, "VendorNumber"), (2, "ProductNumber"), (3, "RevisionNumber")]);
    let device = eds.header("DeviceInfo")?;
    let line = eds.field(eds.sub(0x1018, sub)?, "DefaultValue")?;
    let number = eds.number_of(device, field)?;
    let (ours, theirs) = (eds.field(device, field)?, crate::eds::number(eds.value(line))?);
    let other = if theirs == number { number / 2 } else { return None };
    eds.set(if dice.heads() { line } else { ours }, other);
    Some(Place::Line(line)).filter(|_| other != number)
}

fn lss(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    eds.number_of(eds.header("DeviceInfo")?, "LSS_Supported").filter(|&flag| flag == 1)?;
    let header = eds.sub(0x1018, dice.between(1, 4) as u8)?;
    eds.remove_section(header);
    Some(Place::Line(eds.header("1018")?))
}

fn error_control(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    eds.remove_all("1017");
    eds.remove_all(dice.of(&["100C", "100D"]));
    Some(Place::File)
}

fn dummy(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let line = dice.pick(&eds.fields(eds.header("DummyUsage")?))?;
    let name = dice.of(&["Dummy5", "Dummy00005", "Dumy0005", "Dummy000G", "0005", "Dummy+005", "Dummy 5"]);
    eds.lines[line] = format!("{name}={}", eds.value(line));
    Some(Place::Line(line))
}

fn node_id(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (byte, more) = (dice.between(128, 254), dice.between(256, 100_000));
    let number = dice.of(&[0, 128, byte, more]);
    set(eds, "DeviceComissioning", "NodeID", &number.to_string())
}

fn bit_rate(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let more = dice.between(1001, 1_000_000);
    let rate = dice.of(&[30, 83, 300, 1001, 125_000, more]);
    set(eds, "DeviceComissioning", "Baudrate", &rate.to_string())
}

/// Names a file to download that does not exist beside the DCF.
fn download(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    if !is_configuration(eds) {
        return None;
    }
    let domains: Vec<_> = eds.entries().into_iter().filter(|entry| entry.data_type == 0xF).collect();
    let header = dice.pick(&domains)?.header;
    let name = format!("{}.{}", dice.word(), dice.of(&["bin", "hex", "dat"]));
    Some(Place::Line(eds.put(header, "DownloadFile", name)))
}

fn other_eds(eds: &mut Eds, _: &mut Dice) -> Option<Place> {
    if !is_configuration(eds) {
        return None;
    }
    Some(Place::Line(eds.put(eds.header("FileInfo")?, "LastEDS", ANOTHER_EDS)))
}

fn open(eds: &mut Eds, dice: &mut Dice) -> Option<Place> {
    let (field, value) = dice.of(&[("NodeID", "255"), ("Baudrate", "0"), ("NodeID", "0xFF")]);
    set(eds, "DeviceComissioning", field, value)
}

fn commissioning(eds: &mut Eds, _: &mut Dice) -> Option<Place> {
    let header = eds.header("DeviceComissioning")?;
    eds.lines[header] = "[DeviceCommissioning]".to_owned();
    Some(Place::Line(header))
}
