//! The whole object dictionary: read before a run, compared and put back after it.

use super::Bench;
use super::rewrite::Original;
use canvass_analyzer::Multiplexer;
use canvass_bus::client::Outcome;
use canvass_bus::client::sdo::Bytes;

/// Where a device without description is looked at: the communication objects that a master configures.
const UNDESCRIBED: [(u16, u16); 7] = [
    (0x1000, 0x102A),
    (0x1200, 0x1201),
    (0x1400, 0x1403),
    (0x1600, 0x1603),
    (0x1800, 0x1803),
    (0x1A00, 0x1A03),
    (0x6000, 0x6003),
];

/// No more entries of one object are read than that, whatever its sub-index 0 says.
const MOST_SUBS: u8 = 16;

impl Bench<'_> {
    /// Reads every object that the description calls readable; without a description the communication objects that
    /// are there. What does not answer with a value is left out.
    pub(crate) fn dump(&mut self) -> Vec<(Multiplexer, Vec<u8>)> {
        let mut values = Vec::new();
        for multiplexer in self.described_objects() {
            values.extend(self.value_of(multiplexer).map(|value| (multiplexer, value)));
        }
        if self.target.description.is_none() {
            for index in UNDESCRIBED.into_iter().flat_map(|(first, last)| first..=last) {
                self.dump_object(index, &mut values);
            }
        }
        values
    }

    fn described_objects(&self) -> Vec<Multiplexer> {
        let Some(description) = &self.target.description else { return Vec::new() };
        let entries = description.dictionary.entries();
        let readable = entries.filter(|(_, entry)| entry.access.is_readable() && !entry.flags.refuses_read_on_scan());
        readable.map(|(multiplexer, _)| multiplexer).collect()
    }

    /// An object of which only the index is known: its sub-index 0, and what that counts where there is more.
    fn dump_object(&mut self, index: u16, values: &mut Vec<(Multiplexer, Vec<u8>)>) {
        let Some(first) = self.value_of(Multiplexer::new(index, 0)) else { return };
        let highest = first.first().copied().filter(|_| first.len() == 1).unwrap_or(0);
        values.push((Multiplexer::new(index, 0), first));
        for sub in 1..=highest.min(MOST_SUBS) {
            let multiplexer = Multiplexer::new(index, sub);
            match self.value_of(multiplexer) {
                Some(value) => values.push((multiplexer, value)),
                // One byte, but no count.
                None => break,
            }
        }
    }

    fn value_of(&mut self, multiplexer: Multiplexer) -> Option<Vec<u8>> {
        match self.upload(multiplexer).ok()?.outcome {
            Outcome::Uploaded(value) => Some(value),
            _ => None,
        }
    }

    /// Compares the writable objects with what was read before the run and writes back what differs: values that were
    /// not stored were lost with the first reset. A sentence about each that could not be written back.
    ///
    /// Works after Ctrl-C too.
    pub(crate) fn put_back_dictionary(&mut self, before: &[(Multiplexer, Vec<u8>)]) -> Vec<String> {
        self.restoring = true;
        if !self.answers_at_last() {
            self.restoring = false;
            let notice = "the device does not answer after the run: its values could not be compared with those before";
            return vec![notice.to_owned()];
        }
        let mut wrong = self.differences(before);
        if !wrong.is_empty() {
            let configured = before.iter().filter(|(multiplexer, _)| self.is_put_back(*multiplexer));
            let originals: Vec<Original> = configured
                .map(|(multiplexer, value)| Original { multiplexer: *multiplexer, value: value.clone() })
                .collect();
            self.write_back(&originals);
            wrong = self.differences(before);
        }
        let lines = wrong.iter().map(|(multiplexer, value)| {
            let now =
                self.value_of(*multiplexer).map_or_else(|| "unreadable".to_owned(), |now| Bytes(&now).to_string());
            format!("{multiplexer} was {} before the run and is {now} after it", Bytes(value))
        });
        let lines = lines.collect();
        self.restoring = false;
        lines
    }

    /// Whether the device answers, though it may be starting again: a reset that was cut short is followed by another, and
    /// the boot-up message of the first is no sign that the second is over.
    fn answers_at_last(&mut self) -> bool {
        (0..3).any(|_| {
            let answers = matches!(self.answers(), Ok(true));
            if !answers {
                // A bus that fails here fails in the next look, too.
                let _ = self.listen(self.timing().boot_up);
            }
            answers
        })
    }

    /// The objects whose value is another one than before, with that before. Values that change by themselves are
    /// read-only.
    fn differences(&mut self, before: &[(Multiplexer, Vec<u8>)]) -> Vec<(Multiplexer, Vec<u8>)> {
        let mut wrong = Vec::new();
        for (multiplexer, value) in before {
            if self.is_put_back(*multiplexer) && self.value_of(*multiplexer).is_some_and(|now| now != *value) {
                wrong.push((*multiplexer, value.clone()));
            }
        }
        wrong
    }
}

impl Bench<'_> {
    /// Whether an object is configuration that a run leaves as it was.
    fn is_put_back(&self, multiplexer: Multiplexer) -> bool {
        let described = self.target.description.is_some() && self.is_described_as_writable(multiplexer);
        (described || is_configuration(multiplexer)) && !super::restore::is_trigger(multiplexer)
    }
}

/// Objects that only change when they are written, whatever the device.
const fn is_configuration(multiplexer: Multiplexer) -> bool {
    matches!(multiplexer.index.0, 0x1005..=0x1007 | 0x100C | 0x100D | 0x1012..=0x1017 | 0x1019 | 0x1029 | 0x1200..=0x1BFF)
}
