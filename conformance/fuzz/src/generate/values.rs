//! Random objects, and values near the limits of an object.

use super::Script;
use crate::Known;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;

impl Script<'_> {
    /// An object that exists, or an address near one.
    pub(super) fn object(&mut self) -> Multiplexer {
        // The time on a live bus is short: mapping parameters with their many entries must not take most of it.
        if !self.plan.patient
            && self.dice.flip()
            && let Some(at) = self.entry_of_any_object()
        {
            return at;
        }
        let entries = self.knowledge().entries();
        match (self.dice.below(12), self.dice.pick(entries)) {
            (0, Some(known)) => Multiplexer::new(known.at.index.0, known.at.sub.0.wrapping_add(self.dice.byte() | 1)),
            (1, _) => {
                let raw = self.dice.number();
                // Half of these indexes lie at the beginning of the manufacturer's area.
                let index = if raw >> 32 & 1 == 0 { raw as u16 } else { 0x2000 + (raw as u16 & 0x1F) };
                Multiplexer::new(index, (raw >> 16) as u8 & 3)
            }
            (2, Some(known)) => {
                let near = self.dice.one_of([1, 2, 3, 4, 8, 10, 16]);
                Multiplexer::new(known.at.index.0.wrapping_add(near), known.at.sub.0)
            }
            (_, Some(known)) => known.at,
            (_, None) => self.dice.one_of([
                Multiplexer::new(object::DEVICE_TYPE, 0),
                Multiplexer::new(object::ERROR_REGISTER, 0),
                Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0),
                Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0),
                Multiplexer::new(object::IDENTITY, 1),
                Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 2),
            ]),
        }
    }

    /// An entry of a random object. All objects have the same probability, however many entries they have.
    fn entry_of_any_object(&mut self) -> Option<Multiplexer> {
        let objects = self.plan.knowledge.entries().chunk_by(|one, next| one.at.index == next.at.index);
        let objects: Vec<&[Known]> = objects.collect();
        let entries = self.dice.pick(&objects)?;
        self.dice.pick(entries).map(|known| known.at)
    }

    /// The first object from a random position on that meets the condition. `None` if no object does.
    pub(super) fn object_where(&mut self, fits: impl Fn(&Known) -> bool) -> Option<&'_ Known> {
        let entries = self.plan.knowledge.entries();
        let first = self.dice.below(entries.len().max(1));
        let (head, tail) = entries.split_at(first.min(entries.len()));
        tail.iter().chain(head).find(|known| fits(known))
    }

    /// A value near the limits of the object.
    pub(super) fn value_of(&mut self, known: &Known) -> u64 {
        if !self.plan.patient && known.at.index.0 == object::CONSUMER_HEARTBEAT_TIME && known.at.sub.0 > 0 {
            return self.consumer_entry();
        }
        let (low, high) = known.limits;
        let power_on = known.power_on.unwrap_or(0);
        match self.dice.below(12) {
            0 => 0,
            1 => 1,
            2 => u64::MAX,
            3 => low.map_or(0, |low| low as u64),
            4 => low.map_or(u64::MAX, |low| (low - 1) as u64),
            5 => high.map_or(0x7FFF_FFFF, |high| high as u64),
            6 => high.map_or(0x8000_0000, |high| (high + 1) as u64),
            7 => power_on,
            8 => power_on ^ 1 << self.dice.below(32),
            9 => self.dice.number() & 0xFF,
            10 => self.dice.number() & 0xFFFF,
            _ => self.dice.number(),
        }
    }

    /// An entry of 1016h with a node-ID and a time near their limits.
    fn consumer_entry(&mut self) -> u64 {
        let node = self.dice.one_of([0_u64, 1, 127, 128, 255]);
        node << 16 | self.dice.one_of([0, 1, 50, 1_000])
    }

    /// The bytes of a value of the object. An object without fixed length gets a text.
    pub(super) fn bytes_for(&mut self, known: &Known) -> Vec<u8> {
        match known.size {
            Some(size) => self.value_of(known).to_le_bytes().into_iter().chain([0; 8]).take(size.min(16)).collect(),
            None => {
                let len = self.dice.one_of([0, 1, 4, 5, 7, 8, 14, 15, 21, 30]);
                (0..len).map(|_| self.dice.byte()).collect()
            }
        }
    }
}
