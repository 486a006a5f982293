//! Makes a DCF from the answers of a device: its description with the values that its settings have.

use super::{DeviceSettings, Excluded, setting_of};
use crate::dictionary::description::{Commissioning, DeviceDescription};
use crate::dictionary::manual::KnownDevice;
use crate::dictionary::object::Object;
use crate::dictionary::survey::{Answer, Survey};
use crate::identity::{Multiplexer, NodeId};
use crate::object;
use std::collections::BTreeMap;

/// A configuration that was read from a device.
#[derive(Clone, Debug)]
pub struct ReadConfiguration {
    /// The description with the configured values.
    pub description: DeviceDescription,
    /// The number of settings with a value.
    pub settings: usize,
    /// The writable entries that are no settings, by reason.
    pub left_out: BTreeMap<Excluded, Vec<Multiplexer>>,
    /// The settings without a value, each with the answer of the device.
    pub unread: Vec<(Multiplexer, Option<Answer>)>,
}

/// Makes the configuration of a device from its description and its answers. `bit_rate` is in kbit/s.
pub fn from_device(known: &KnownDevice, survey: &Survey, node: NodeId, bit_rate: Option<u16>) -> ReadConfiguration {
    let mut read = ReadConfiguration {
        description: known.description.clone(),
        settings: 0,
        left_out: BTreeMap::new(),
        unread: Vec::new(),
    };
    let number = |sub| survey.number(Multiplexer::new(object::IDENTITY, sub)).and_then(|raw| u32::try_from(raw).ok());
    let settings = DeviceSettings::new(known, |at| survey.number(at));
    for object in known.description.dictionary.objects() {
        let configured = configured(object, &settings, survey, node, &mut read);
        read.description.dictionary.insert(configured);
    }
    let before = known.description.commissioning.clone().unwrap_or_default();
    read.description.commissioning =
        Some(Commissioning { node_id: Some(node), bit_rate, lss_serial_number: number(4), ..before });
    let device = &mut read.description.device;
    device.vendor_number = number(1).or(device.vendor_number);
    device.product_number = number(2).or(device.product_number);
    device.revision_number = number(3).or(device.revision_number);
    read
}

fn configured(
    object: &Object,
    settings: &DeviceSettings<'_>,
    survey: &Survey,
    node: NodeId,
    read: &mut ReadConfiguration,
) -> Object {
    let mut configured = object.clone();
    for entry in object.entries() {
        let at = Multiplexer { index: object.index, sub: entry.sub };
        let reason = settings.excluded(at, entry);
        // The identity says which device the configuration is of.
        let is_identity = object.index.0 == object::IDENTITY && entry.sub.0 > 0;
        let setting = match reason {
            Some(_) if !is_identity => None,
            _ => survey.value(at).and_then(|value| setting_of(entry, value, node)),
        };
        match (reason, &setting) {
            (None, Some(_)) => read.settings += 1,
            (None, None) => read.unread.push((at, survey.get(at).cloned())),
            (Some(reason), _) if entry.access.is_writable() => read.left_out.entry(reason).or_default().push(at),
            (Some(_), _) => {}
        }
        if let Some(kept) = configured.entry_mut(entry.sub) {
            kept.configured = setting;
        }
    }
    configured
}
