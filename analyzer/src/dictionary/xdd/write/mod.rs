//! Writes an XDD, or an XDC if the description is of a configured device.

mod markup;
mod objects;
mod profile;

use crate::dictionary::description::DeviceDescription;
use crate::dictionary::loss::{Loss, LossKind, Losses};
use crate::object;
use markup::Markup;

/// The text of a file that reads as this description, and the parts of the description that the file can't hold.
pub fn write(description: &DeviceDescription) -> (String, Vec<Loss>) {
    let mut sheet = Sheet { markup: Markup::new(), losses: Losses::default() };
    lost(&mut sheet.losses, description);
    let container = [
        ("xmlns", Some("http://www.canopen.org/xml/1.0".to_owned())),
        ("xmlns:xsi", Some("http://www.w3.org/2001/XMLSchema-instance".to_owned())),
    ];
    sheet.markup.open("ISO15745ProfileContainer", &container);
    profile::device(&mut sheet, description);
    profile::communication(&mut sheet, description);
    sheet.markup.close();
    (sheet.markup.into_text(), sheet.losses.0)
}

/// The part of the file written so far.
struct Sheet {
    markup: Markup,
    losses: Losses,
}

impl Sheet {
    /// A text of the description for an attribute or element; `None` if it is empty.
    fn text(&mut self, line: u32, place: &str, text: &str) -> Option<String> {
        Some(self.losses.line(line, place, text)).filter(|text| !text.is_empty())
    }
}

/// Reports the parts of the description for which CiA 311, as far as canvass reads it, has no place.
fn lost(losses: &mut Losses, description: &DeviceDescription) {
    let file = &description.file;
    losses.no_place(0, "[FileInfo] FileRevision", &file.revision);
    losses.no_place(0, "[FileInfo] Description", &file.description);
    losses.no_place(0, "[FileInfo] LastEDS", file.last_eds.as_deref().unwrap_or_default());
    let identity = description.dictionary.entry(crate::Multiplexer::new(object::IDENTITY, 3)).ok();
    let identity = identity.and_then(|entry| entry.default.as_ref()?.fixed()?.to_raw());
    if let Some(revision) = description.device.revision_number
        && identity != Some(revision.into())
    {
        losses.no_place(0, "[DeviceInfo] RevisionNumber", &format!("0x{revision:X}"));
    }
    if let Some(first) = description.comments.iter().find(|line| !line.is_empty()) {
        losses.no_place(0, format!("[Comments] of {} lines", description.comments.len()), first);
    }
    for module in &description.modules {
        losses.add(0, format!("module {}", module.number), &module.product_name, LossKind::NoPlace);
    }
    if !description.connected_modules.is_empty() {
        losses.no_place(0, "[ConnectedModules]", &format!("{} modules", description.connected_modules.len()));
    }
    if let Some(number) = description.commissioning.as_ref().and_then(|it| it.lss_serial_number) {
        losses.no_place(0, "[DeviceComissioning] LSS_SerialNumber", &format!("0x{number:X}"));
    }
}
