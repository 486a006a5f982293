//! The provenance as the member `provenance` of JSON results.

use super::{BusUsed, Choice, FileUsed, Host, Provenance, VERSION};
use crate::results::provenance as results;

/// The member `provenance`.
pub fn json(provenance: &Provenance) -> results::Provenance {
    let named = |(name, identity): &(String, _)| {
        let identity = crate::results::Device::from(identity);
        results::NamedDevice { device: name.clone(), identity }
    };
    let (date, zone) = provenance.date.clone().map(|date| (date.rfc3339, date.zone)).unzip();
    results::Provenance {
        bus: provenance.bus.clone().map(|BusUsed { address, adapter, bit_rate }| results::Bus {
            adapter,
            address,
            bit_rate,
        }),
        date,
        devices: provenance.devices.iter().map(named).collect(),
        files: provenance.files.iter().map(file).collect(),
        host: provenance.host.clone().map(|Host { name, system }| results::Host { name, system }),
        notes: provenance.notes.iter().cloned().collect(),
        options: provenance.options.iter().map(choice).collect(),
        seed: provenance.seed,
        version: VERSION.into(),
        zone,
    }
}

fn file(FileUsed { role, path, content }: &FileUsed) -> results::File {
    let (bytes, sha256) = content.clone().unzip();
    results::File { bytes, path: path.clone(), role: (*role).into(), sha256 }
}

fn choice(Choice { name, value, default, by }: &Choice) -> results::Choice {
    let (name, value, default) = (name.clone(), value.clone(), default.clone());
    results::Choice { by: by.name().into(), default, name, value }
}
