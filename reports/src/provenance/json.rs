//! The provenance as JSON: the same member `provenance` in all documents.

use super::{BusUsed, Choice, FileUsed, Host, Provenance, VERSION};
use canvass_suite::runner::DeviceIdentity;
use serde_json::{Map, Value, json};

/// The member.
pub fn json(provenance: &Provenance) -> Value {
    let notes = provenance.notes.iter().map(|(key, value)| (key.clone(), Value::from(value.as_str())));
    json!({
        "version": VERSION,
        "date": provenance.date.as_ref().map(|date| &date.rfc3339),
        "zone": provenance.date.as_ref().map(|date| &date.zone),
        "host": provenance.host.as_ref().map(|Host { name, system }| json!({ "name": name, "system": system })),
        "bus": provenance.bus.as_ref().map(|BusUsed { address, adapter, bit_rate }| {
            json!({ "address": address, "adapter": adapter, "bit_rate": bit_rate })
        }),
        "devices": provenance.devices.iter().map(|(name, identity)| device(name, identity)).collect::<Vec<_>>(),
        "seed": provenance.seed,
        "files": provenance.files.iter().map(file).collect::<Vec<_>>(),
        "options": provenance.options.iter().map(choice).collect::<Vec<_>>(),
        "notes": Value::Object(notes.collect::<Map<_, _>>()),
    })
}

fn device(name: &str, identity: &DeviceIdentity) -> Value {
    let [vendor_id, product_code, revision_number, serial_number] = identity.identity;
    let [device_name, hardware_version, software_version] = &identity.names;
    json!({
        "device": name,
        "device_type": identity.device_type,
        "vendor_id": vendor_id,
        "product_code": product_code,
        "revision_number": revision_number,
        "serial_number": serial_number,
        "name": device_name,
        "hardware_version": hardware_version,
        "software_version": software_version,
    })
}

fn file(FileUsed { role, path, content }: &FileUsed) -> Value {
    let (bytes, sha256) = content.as_ref().map(|(bytes, sha256)| (bytes, sha256)).unzip();
    json!({ "role": role, "path": path, "bytes": bytes, "sha256": sha256 })
}

fn choice(Choice { name, value, default, by }: &Choice) -> Value {
    json!({ "name": name, "value": value, "default": default, "by": by.name() })
}
