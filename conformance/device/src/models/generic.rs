//! A model from a device description alone: where the description says nothing, the model follows CiA 301.

use super::profile;
use super::sheet::Sheet;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{DeviceDescription, Setting};
use canvass_analyzer::object;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lss::Lss;
use toml::{Table, Value};

/// The node-ID if the description is for any node-ID.
const USUAL_NODE: u8 = 1;
/// The bit rate in kbit/s if the description lists none.
const USUAL_BIT_RATE: u16 = 250;

/// The sheet of a device whose services follow from its object dictionary.
pub(super) fn sheet(name: &str, description: &DeviceDescription) -> Result<Sheet, toml::de::Error> {
    let product = &description.device.product_name;
    let summary = if product.is_empty() { "a device as its description says" } else { product };
    let mut sheet = Table::new();
    sheet.insert("id".to_owned(), name.into());
    sheet.insert("summary".to_owned(), summary.into());
    sheet.insert("network".to_owned(), network(description).into());
    sheet.insert("bit_rate".to_owned(), Value::Array(bit_rates(description)));
    let application = profile::describe(description, &mut sheet);
    sheet.insert("value".to_owned(), Value::Array(identity(description)));
    // Read as a text, as the sheets of models are: a reader of tables beside it makes the page's module 2 % larger.
    let sheet: Sheet = toml::from_str(&sheet.to_string())?;
    Ok(Sheet { application, ..sheet })
}

fn network(description: &DeviceDescription) -> Table {
    let commissioning = description.commissioning.as_ref();
    let node = commissioning.and_then(|set| set.node_id).map_or(USUAL_NODE, |node| node.raw());
    let known = &description.device.bit_rates;
    let rate = commissioning.and_then(|set| set.bit_rate).filter(|rate| known.contains(rate));
    let usual = (known.is_empty() || known.contains(&USUAL_BIT_RATE)).then_some(USUAL_BIT_RATE);
    let rate = rate.or(usual).or(known.last().copied()).unwrap_or(USUAL_BIT_RATE);
    let has = |index, sub| description.dictionary.entry(Multiplexer::new(index, sub)).is_ok();
    let writable = |index| is_writable(description, Multiplexer::new(index, 0));
    let mut network = Table::new();
    network.insert("default_node_id".to_owned(), i64::from(node).into());
    network.insert("default_bit_rate_kbit".to_owned(), i64::from(rate.max(1)).into());
    network.insert("lss".to_owned(), description.device.lss_supported.into());
    network.insert("lss_restarts".to_owned(), false.into());
    network.insert("node_guarding".to_owned(), (has(object::GUARD_TIME, 0) && has(object::LIFE_TIME_FACTOR, 0)).into());
    network.insert("rtr".to_owned(), allows_rtr(description).into());
    network.insert("sdo_block_transfer".to_owned(), true.into());
    network.insert(
        "sync_producer".to_owned(),
        (writable(object::COB_ID_SYNC) && writable(object::COMMUNICATION_CYCLE_PERIOD)).into(),
    );
    network.insert("time_consumer".to_owned(), writable(object::COB_ID_TIME).into());
    network
}

/// Whether any TPDO is delivered with remote frames allowed.
fn allows_rtr(description: &DeviceDescription) -> bool {
    let no_rtr = |index| {
        let default = description.dictionary.entry(Multiplexer::new(index, 1)).ok()?.default.as_ref()?;
        Some(match default {
            Setting::Fixed(value) => value.to_raw()? & 1 << 30 != 0,
            Setting::NodeIdPlus(offset) => offset & 1 << 30 != 0,
        })
    };
    (0x1800..0x1A00).filter_map(no_rtr).any(|no_rtr| !no_rtr)
}

fn bit_rates(description: &DeviceDescription) -> Vec<Value> {
    let row = |&kbit: &u16| {
        let code = Lss::bit_rate_index(u32::from(kbit) * 1_000);
        let mut row = Table::new();
        row.insert("kbit".to_owned(), i64::from(kbit).into());
        if let Some(code) = code {
            row.insert("lss_code".to_owned(), i64::from(code).into());
        }
        row.into()
    };
    description.device.bit_rates.iter().map(row).collect()
}

pub(crate) fn is_writable(description: &DeviceDescription, at: Multiplexer) -> bool {
    description.dictionary.entry(at).is_ok_and(|entry| entry.access.is_writable())
}

/// Values of 1018h from the head of the file, for sub-indexes without a default.
fn identity(description: &DeviceDescription) -> Vec<Value> {
    let device = &description.device;
    let numbers = [(1, device.vendor_number), (2, device.product_number), (3, device.revision_number)];
    let row = |(sub, number): (u8, Option<u32>)| {
        let at = Multiplexer::new(object::IDENTITY, sub);
        let entry = description.dictionary.entry(at).ok().filter(|entry| entry.default.is_none())?;
        let number = number.filter(|_| entry.access.is_readable())?;
        let mut row = Table::new();
        row.insert("at".to_owned(), written(at).into());
        row.insert("value".to_owned(), i64::from(number).into());
        Some(row.into())
    };
    numbers.into_iter().filter_map(row).collect()
}

/// The address of an object in the notation of sheets: `1018:01`.
pub(crate) fn written(at: Multiplexer) -> String {
    format!("{:04X}:{:02X}", at.index.0, at.sub.0)
}

#[cfg(test)]
mod tests {
    use crate::models::Model;

    #[test]
    fn a_description_alone_makes_a_device() {
        let eds = include_bytes!("../../models/kuebler-sendix-58x8.eds");
        let model = Model::generic("my.eds", eds).unwrap();
        assert_eq!((model.id(), model.summary()), ("my.eds", "Sendix 5868"));
        assert_eq!((model.default_node().unwrap().raw(), model.default_bit_rate()), (1, 250_000));
        let network = &model.sheet().network;
        assert!(network.lss && network.rtr && network.node_guarding && network.sync_producer);
        assert_eq!(model.sheet().bit_rates.iter().find(|rate| rate.kbit == 50).unwrap().lss_code, Some(6));
    }

    /// The head of the file gives the identity only if 1018h has no defaults.
    #[test]
    fn the_identity_comes_from_the_head_of_the_file() {
        let text = include_str!("../../models/kuebler-sendix-58x8.eds");
        let without: String = text.replace("DefaultValue=0x00000013\n", "");
        assert_ne!(text, without);
        let identity = |text: &str| {
            let model = Model::generic("my.eds", text.as_bytes()).unwrap();
            let values = model.sheet().values.iter().map(|value| (value.at.to_string(), value.value.as_integer()));
            (model.vendor(), values.collect::<Vec<_>>())
        };
        assert_eq!(identity(text), (Some(0x13), Vec::new()));
        assert_eq!(identity(&without), (Some(0x13), vec![("1018h:01".to_owned(), Some(0x13))]));
    }

    #[test]
    fn hardly_anything_is_enough() {
        let model = Model::generic("x", b"[MandatoryObjects]\nSupportedObjects=0\n").unwrap();
        assert_eq!(model.default_bit_rate(), 250_000);
    }
}
