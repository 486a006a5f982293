use crate::dictionary::names;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::wear::{Wear, WearLimits};
use crate::findings::{Context, Scene};
use crate::network::sdo::{Direction, Outcome};
use crate::object;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;

/// parameters are stored more often than the memory endures
///
/// At the rate at which parameters are stored, the memory of the device wears out within its service life. Parameters
/// are stored by 1010h or by the signature `save` in a manufacturer-specific object; some devices also store each write
/// of an object of their profile at once.
///
/// # Why
/// An EEPROM endures some 100 000 writes. Some masters store at every start or even in every cycle; years later the
/// device loses its configuration.
///
/// # What to do
/// Store once, at commissioning. Configure all other parameters at every start without storing them.
#[rule(id = "sdo/store-wear", severity = Warning, rank = Detail, also = EndedTransfers)]
struct StoreWear {
    /// a lower number of stores is not judged
    #[threshold(count = 10, min = 1)]
    times: u64,
    /// number of writes that the memory bears
    #[threshold(count = 100_000, min = 1)]
    cycles: u64,
    /// service life of the device
    #[threshold(count = 10, unit = "years", min = 1)]
    years: u64,
    nodes: PerNode<Wear>,
}

/// Whether a download to `object` writes the memory of the node.
fn is_kept(object: Multiplexer, node: NodeId, context: &Context<'_>) -> bool {
    if object.index.0 == object::STORE_PARAMETERS {
        return true;
    }
    let kept = || {
        let known = context.scene.bus.node(node)?;
        let described = || known.description().and_then(|description| description.device.vendor_number);
        let vendor = known.certain(node, Multiplexer::new(object::IDENTITY, 1)).or_else(described)?;
        Some(names::possible(known.profile(node)).any(|profile| profile.keeps_at_once(object, vendor)))
    };
    matches!(object.index.0, 0x6000..=0x9FFF) && kept() == Some(true)
}

impl Rule for StoreWear {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let transfer = context.decoded.channel.and_then(|channel| context.scene.bus.transfer(channel));
        let written = transfer
            .filter(|transfer| transfer.outcome == Outcome::Complete && transfer.direction == Direction::Download);
        let signed = |data: &[u8]| matches!(data, b"save");
        let stored = written.is_some_and(|transfer| match transfer.multiplexer.index.0 {
            0x2000..=0x5FFF => signed(transfer.data()),
            _ => is_kept(transfer.multiplexer, node, context),
        });
        if stored {
            self.nodes[node].count(context);
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let limits = WearLimits { times: self.times, cycles: self.cycles, years: self.years };
        for (node, stores) in self.nodes.iter() {
            let Some((first, message)) = stores.judge(&limits, scene) else { continue };
            sink.report(Report::at(first.time()).node(node).evidence(first.evidence()), || message);
        }
    }
}
