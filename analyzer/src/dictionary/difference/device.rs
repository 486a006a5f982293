//! Differences of the device's general data, the settings of a DCF, and the version of the file.

use super::kind::kinds;
use super::{ChangeKind, Class, Comparison, Fact, Subject};
use crate::dictionary::description::{Commissioning, DeviceDescription, DeviceInfo};
use std::collections::BTreeSet;

kinds! {
    /// the vendor-ID or the product code has changed
    ///
    /// Tools choose the description by these numbers, and a master that expects the old ones (1F85h, 1F86h) does not start the
    /// device.
    NUMBER: Breaking "device/identity";

    /// the revision number has changed
    ///
    /// Tools may choose the description by it. By CiA 301 its high word changes with the CANopen behaviour.
    REVISION: Notable "device/revision";

    /// one of the descriptions lacks the number
    ///
    /// The numbers can't be compared: an XDD has no revision number, and some files leave numbers out.
    UNTOLD: Notable "device/untold";

    /// the name of vendor or product, or the order code, has changed
    ///
    /// Tools show these texts and choose by the numbers.
    NAME: Harmless "device/name";

    /// the device no longer supports the bit rate
    ///
    /// On a bus with that bit rate it can't communicate, or disturbs all other nodes.
    BIT_RATE_GONE: Breaking "device/bit-rate-gone";

    /// the device supports another bit rate
    ///
    /// It supports all its former bit rates.
    BIT_RATE_ADDED: Harmless "device/bit-rate-added";

    /// the device has fewer PDOs
    ///
    /// A DCF that configures a missing PDO can't be downloaded completely.
    FEWER_PDOS: Breaking "device/fewer-pdos";

    /// the device has more PDOs
    ///
    /// It has all its former PDOs.
    MORE_PDOS: Harmless "device/more-pdos";

    /// mapping has become coarser, or fixed
    ///
    /// Granularity is the smallest number of bits that can be mapped, 0 for a fixed mapping: a mapping with fewer
    /// bits is refused.
    COARSER: Breaking "device/coarser-mapping";

    /// mapping is finer
    ///
    /// Mappings that were possible still are.
    FINER: Harmless "device/finer-mapping";

    /// the device no longer has LSS
    ///
    /// A master that gives it node-ID or bit rate by LSS gets no answer.
    NO_LSS: Breaking "device/no-lss";

    /// the device has lost a feature
    ///
    /// A network that this device starts, or that uses group messaging or dynamic channels, needs another set-up.
    FEATURE_GONE: Notable "device/feature-gone";

    /// the device has a new feature
    ///
    /// Programs that do not know the feature do not use it.
    FEATURE_ADDED: Harmless "device/feature-added";

    /// a data type can't skip bits of an RPDO any more
    ///
    /// A mapping with this type as a dummy entry is refused.
    DUMMY_GONE: Breaking "device/dummy-gone";

    /// a data type can skip bits of an RPDO
    ///
    /// Mappings that were possible still are.
    DUMMY_ADDED: Harmless "device/dummy-added";

    /// the device is set to another node-ID or bit rate
    ///
    /// It is no longer reached at the old node-ID or bit rate; COB-IDs that contain the node-ID change too.
    COMMISSIONED: Breaking "commissioning/address";

    /// the network settings of the device have changed
    ///
    /// Names and numbers of networks are for tools; a serial number is for LSS.
    NETWORK: Notable "commissioning/network";

    /// the version of the file has changed
    ///
    /// A new version shows that the content has changed.
    VERSION: Harmless "file/version";

    /// the version of the file is the same, but its content is not
    ///
    /// A tool with the old file may keep it, as it can't see the change.
    SAME_VERSION: Notable "file/same-version";
}

pub(super) fn compare(comparison: &mut Comparison<'_>) {
    let (old, new) = (&comparison.old.device, &comparison.new.device);
    identity(comparison, old, new);
    bit_rates(comparison, old, new);
    numbers(comparison, old, new);
    features(comparison, old, new);
    dummies(comparison);
    if let (Some(old), Some(new)) = (&comparison.old.commissioning, &comparison.new.commissioning) {
        commissioning(comparison, old, new);
    }
}

fn identity(comparison: &mut Comparison<'_>, old: &DeviceInfo, new: &DeviceInfo) {
    let numbers: [(&ChangeKind, _, _, _); 3] = [
        (&NUMBER, "VendorNumber", old.vendor_number, new.vendor_number),
        (&NUMBER, "ProductNumber", old.product_number, new.product_number),
        (&REVISION, "RevisionNumber", old.revision_number, new.revision_number),
    ];
    for (kind, field, before, after) in numbers {
        let kind = if before.is_some() && after.is_some() { kind } else { &UNTOLD };
        comparison.changed(kind, Subject::Field(field), before.map(Fact::Code), after.map(Fact::Code));
    }
    let texts = [
        ("VendorName", &old.vendor_name, &new.vendor_name),
        ("ProductName", &old.product_name, &new.product_name),
        ("OrderCode", &old.order_code, &new.order_code),
    ];
    for (field, before, after) in texts {
        text(comparison, &NAME, field, before, after);
    }
}

fn text(comparison: &mut Comparison<'_>, kind: &'static ChangeKind, field: &'static str, old: &str, new: &str) {
    let fact = |text: &str| Some(Fact::Text(text.to_owned()));
    comparison.changed(kind, Subject::Field(field), fact(old), fact(new));
}

fn bit_rates(comparison: &mut Comparison<'_>, old: &DeviceInfo, new: &DeviceInfo) {
    let subject = Subject::Field("BaudRate");
    for &rate in old.bit_rates.iter().filter(|rate| !new.bit_rates.contains(rate)) {
        comparison.report(&BIT_RATE_GONE, subject, Some(Fact::BitRate(rate)), None);
    }
    for &rate in new.bit_rates.iter().filter(|rate| !old.bit_rates.contains(rate)) {
        comparison.report(&BIT_RATE_ADDED, subject, None, Some(Fact::BitRate(rate)));
    }
}

fn numbers(comparison: &mut Comparison<'_>, old: &DeviceInfo, new: &DeviceInfo) {
    let number = |number: u16| Some(Fact::Number(number.into()));
    for (field, before, after) in [("NrOfRXPDO", old.rpdos, new.rpdos), ("NrOfTXPDO", old.tpdos, new.tpdos)] {
        let kind: &ChangeKind = if after < before { &FEWER_PDOS } else { &MORE_PDOS };
        comparison.changed(kind, Subject::Field(field), number(before), number(after));
    }
    // Granularity 0 means that mapping is fixed, which is the coarsest.
    let coarseness = |granularity: u8| if granularity == 0 { u8::MAX } else { granularity };
    let (before, after) = (old.granularity, new.granularity);
    let kind: &ChangeKind = if coarseness(after) > coarseness(before) { &COARSER } else { &FINER };
    comparison.changed(kind, Subject::Field("Granularity"), number(before.into()), number(after.into()));
}

fn features(comparison: &mut Comparison<'_>, old: &DeviceInfo, new: &DeviceInfo) {
    let features: [(&ChangeKind, _, _, _); 5] = [
        (&NO_LSS, "LSS_Supported", old.lss_supported, new.lss_supported),
        (&FEATURE_GONE, "SimpleBootUpMaster", old.simple_boot_up_master, new.simple_boot_up_master),
        (&FEATURE_GONE, "SimpleBootUpSlave", old.simple_boot_up_slave, new.simple_boot_up_slave),
        (&FEATURE_GONE, "DynamicChannelsSupported", old.dynamic_channels, new.dynamic_channels),
        (&FEATURE_GONE, "GroupMessaging", old.group_messaging, new.group_messaging),
    ];
    for (gone, field, before, after) in features {
        let kind = if before { gone } else { &FEATURE_ADDED };
        comparison.changed(kind, Subject::Field(field), Some(Fact::Flag(before)), Some(Fact::Flag(after)));
    }
}

fn dummies(comparison: &mut Comparison<'_>) {
    let usable = |description: &DeviceDescription| -> BTreeSet<u16> {
        description.dummy_usage.iter().filter(|(_, usable)| **usable).map(|(&index, _)| index).collect()
    };
    let (old, new) = (usable(comparison.old), usable(comparison.new));
    let fact = |index: &u16| Some(Fact::DataType(crate::dictionary::DataType(*index)));
    let subject = Subject::Field("DummyUsage");
    for index in old.difference(&new) {
        comparison.report(&DUMMY_GONE, subject, fact(index), None);
    }
    for index in new.difference(&old) {
        comparison.report(&DUMMY_ADDED, subject, None, fact(index));
    }
}

fn commissioning(comparison: &mut Comparison<'_>, old: &Commissioning, new: &Commissioning) {
    let node = |it: &Commissioning| it.node_id.map(|id| Fact::Number(id.raw().into()));
    comparison.changed(&COMMISSIONED, Subject::Field("NodeID"), node(old), node(new));
    let rate = |it: &Commissioning| it.bit_rate.map(Fact::BitRate);
    comparison.changed(&COMMISSIONED, Subject::Field("Baudrate"), rate(old), rate(new));
    text(comparison, &NETWORK, "NodeName", &old.node_name, &new.node_name);
    text(comparison, &NETWORK, "NetworkName", &old.network_name, &new.network_name);
    let net = |it: &Commissioning| it.net_number.map(Fact::Number);
    comparison.changed(&NETWORK, Subject::Field("NetNumber"), net(old), net(new));
    let manager = |it: &Commissioning| Some(Fact::Flag(it.is_manager));
    comparison.changed(&NETWORK, Subject::Field("CANopenManager"), manager(old), manager(new));
    let serial = |it: &Commissioning| it.lss_serial_number.map(Fact::Code);
    comparison.changed(&NETWORK, Subject::Field("LSS_SerialNumber"), serial(old), serial(new));
}

/// Compares the version of the file with the differences found.
pub(super) fn compare_version(comparison: &mut Comparison<'_>) {
    let (old, new) = (&comparison.old.file, &comparison.new.file);
    text(comparison, &VERSION, "FileVersion", &old.version, &new.version);
    text(comparison, &VERSION, "FileRevision", &old.revision, &new.revision);
    let is_new = (&old.version, &old.revision) != (&new.version, &new.revision);
    let matters = comparison.found.iter().any(|difference| difference.kind.class > Class::Harmless);
    if matters && !is_new {
        let version = Some(Fact::Text(new.version.clone()));
        comparison.report(&SAME_VERSION, Subject::Field("FileVersion"), version.clone(), version);
    }
}
