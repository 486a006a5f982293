//! A model from a device description alone: what the description does not say is as CiA 301 has it.

use super::rules::Rule;
use super::sheet::Sheet;
use super::shows_limit_switches;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{DeviceDescription, Setting};
use canvass_analyzer::object;
use canvass_analyzer::object::encoder;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lss::Lss;
use toml::{Table, Value};

/// The node-ID where the description is for any.
const USUAL_NODE: u8 = 1;
/// Of an encoder, the period of its first TPDO.
const CYCLIC_TIMER: Multiplexer = Multiplexer::new(encoder::CYCLIC_TIMER, 0);
/// The bit rate in kbit/s where the description does not say which ones there are.
const USUAL_BIT_RATE: u16 = 250;

/// The sheet of a device with the services that its object dictionary shows.
pub(super) fn sheet(name: &str, description: &DeviceDescription) -> Result<Sheet, toml::de::Error> {
    let product = &description.device.product_name;
    let summary = if product.is_empty() { "a device as its description says" } else { product };
    let mut sheet = Table::new();
    sheet.insert("id".to_owned(), name.into());
    sheet.insert("summary".to_owned(), summary.into());
    sheet.insert("network".to_owned(), network(description).into());
    sheet.insert("bit_rate".to_owned(), Value::Array(bit_rates(description)));
    if let Some(encoder) = encoder(description) {
        sheet.insert("encoder".to_owned(), encoder.into());
        let links = links(description);
        sheet.insert("quirks".to_owned(), quirks(description, !links.is_empty()).into());
        sheet.insert("link".to_owned(), Value::Array(links));
        sheet.insert("check".to_owned(), Value::Array(checks(description)));
    }
    sheet.insert("value".to_owned(), Value::Array(identity(description)));
    sheet.try_into()
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

/// Whether a TPDO is delivered with remote frames allowed.
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

/// Of an encoder, the cyclic timer is the event timer of TPDO 1 (CiA 406).
fn links(description: &DeviceDescription) -> Vec<Value> {
    let timers = [CYCLIC_TIMER, Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 5)];
    if !timers.iter().all(|at| is_writable(description, *at)) {
        return Vec::new();
    }
    let objects: Vec<Value> = timers.iter().map(|at| written(*at).into()).collect();
    let mut link = Table::new();
    link.insert("kind".to_owned(), "same".into());
    link.insert("objects".to_owned(), Value::Array(objects));
    vec![link.into()]
}

/// What its description shows that such an encoder does beside CiA 406.
fn quirks(description: &DeviceDescription, has_event_timer: bool) -> Table {
    let mut quirks = Table::new();
    let is_cyclic = !has_event_timer && is_writable(description, CYCLIC_TIMER);
    quirks.insert("cyclic_tpdo".to_owned(), is_cyclic.into());
    quirks.insert("limit_switches".to_owned(), shows_limit_switches(description).into());
    quirks
}

/// Of a work area the low limit is below the high one (CiA 406), for each channel that has both.
fn checks(description: &DeviceDescription) -> Vec<Value> {
    let (low, high) = (encoder::WORK_AREA_LOW_LIMIT, encoder::WORK_AREA_HIGH_LIMIT);
    let row = |(at, rule, of): (Multiplexer, &str, Multiplexer)| {
        let mut row = Table::new();
        row.insert("at".to_owned(), written(at).into());
        row.insert("rule".to_owned(), rule.into());
        row.insert("of".to_owned(), written(of).into());
        row.insert("abort".to_owned(), i64::from(Rule::AtMost.standard_abort().0).into());
        Value::Table(row)
    };
    let channels = (1..=254).map(|sub| (Multiplexer::new(low, sub), Multiplexer::new(high, sub)));
    let both = channels.filter(|(low, high)| [low, high].iter().all(|at| description.dictionary.entry(**at).is_ok()));
    both.flat_map(|(low, high)| [(low, "at-most", high), (high, "at-least", low)]).map(row).collect()
}

fn is_writable(description: &DeviceDescription, at: Multiplexer) -> bool {
    description.dictionary.entry(at).is_ok_and(|entry| entry.access.is_writable())
}

/// The identity as the head of the file has it, where 1018h has no default.
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

/// An object as sheets write it: `1018:01`.
fn written(at: Multiplexer) -> String {
    format!("{:04X}:{:02X}", at.index.0, at.sub.0)
}

/// Of an encoder (CiA 406), the physical resolution: of a rotary one 6501h and 6502h tell it, of a linear one (1000h) 6002h, as
/// 6501h is then the length of a step.
fn encoder(description: &DeviceDescription) -> Option<Table> {
    let number = |index| {
        let entry = description.dictionary.entry(Multiplexer::new(index, 0)).ok()?;
        entry.default.as_ref()?.fixed()?.to_raw()
    };
    let has_position = description.dictionary.entry(Multiplexer::new(encoder::POSITION_VALUE, 0)).is_ok();
    if description.device_profile() != Some(406) || !has_position {
        return None;
    }
    let mut encoder = Table::new();
    if number(object::DEVICE_TYPE).is_some_and(|device_type| matches!(device_type >> 16, 8 | 9)) {
        let steps = number(encoder::TOTAL_MEASURING_RANGE).unwrap_or(1).clamp(1, u64::from(u32::MAX));
        encoder.insert("kind".to_owned(), "linear".into());
        encoder.insert("single_turn_bits".to_owned(), 0.into());
        encoder.insert("revolutions".to_owned(), (steps as i64).into());
        return Some(encoder);
    }
    let bits = number(encoder::SINGLE_TURN_RESOLUTION).map_or(13, |steps| i64::from(steps.max(1).ilog2().min(32)));
    encoder.insert("single_turn_bits".to_owned(), bits.into());
    let revolutions = number(encoder::NUMBER_OF_REVOLUTIONS).unwrap_or(1).clamp(1, u64::from(u32::MAX));
    encoder.insert("revolutions".to_owned(), (revolutions as i64).into());
    Some(encoder)
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
        let encoder = model.sheet().encoder.unwrap();
        assert_eq!((encoder.single_turn_bits, encoder.revolutions), (13, 4096));
    }

    /// The head of the file says who it is where 1018h has no defaults, and only there.
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

    /// The timer of a first TPDO without event timer is 6200h; where it has one, both are the same.
    #[test]
    fn the_cyclic_timer_is_that_of_the_first_tpdo() {
        let of = |id: &str| {
            let eds = Model::by_id(id).unwrap().eds_text().unwrap();
            let model = Model::generic("my.eds", eds.as_bytes()).unwrap();
            let quirks = &model.sheet().quirks;
            (quirks.cyclic_tpdo, quirks.limit_switches, model.sheet().links.len(), model.sheet().checks.len())
        };
        assert_eq!(of("lika-ax58"), (true, true, 0, 0));
        assert_eq!(of("tr-c65"), (true, false, 0, 0));
        assert_eq!(of("kuebler-sendix-58x8"), (false, false, 1, 4));
        assert_eq!(of("reference-301"), (false, false, 0, 0));
    }

    #[test]
    fn hardly_anything_is_enough() {
        let model = Model::generic("x", b"[MandatoryObjects]\nSupportedObjects=0\n").unwrap();
        assert_eq!(model.default_bit_rate(), 250_000);
    }
}
