//! Recognises the model of a node by the objects that it shows: device type (1000h), name (1008h), identity (1018h),
//! and further objects that distinguish models.
//!
//! A model is a candidate as long as the trace does not contradict its facts. It is recognised when the trace also
//! confirms vendor-ID and product code, or device type and name. Several models may be recognised at once. Then those
//! remain that have all objects which the node has transferred, and whose TPDOs have the lengths of the node's TPDOs.
//! If several models still remain, the first stands for all if their PDOs are alike.

use super::number::number;
use crate::dictionary::names::{Role, has_role, profiles, with_role};
use crate::dictionary::{KnownDevice, Value};
use crate::message::PdoNumber;
use crate::object;
use crate::wire::pdo::MappingEntry;
use crate::{Multiplexer, NodeId, SubIndex};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, LazyLock};

/// A model as which nodes can be recognised.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The name of the model.
    pub id: Arc<str>,
    /// The values that a node of this model shows.
    pub facts: Vec<(Multiplexer, Fact)>,
    /// Prior knowledge of a node of this model.
    pub device: Arc<KnownDevice>,
    /// Whether the user named this model. All its facts must then be shown, and it takes precedence over other models.
    pub is_said: bool,
}

/// The models as which nodes can be recognised; loaded at the first use, as loading may take longer than decoding a
/// short capture.
#[derive(Clone, Default)]
pub struct Candidates(Option<Arc<LazyLock<Arc<[Candidate]>, Find>>>);

type Find = Box<dyn FnOnce() -> Arc<[Candidate]> + Send>;

impl Candidates {
    /// Candidates that `find` loads at the first use.
    pub fn new(find: impl FnOnce() -> Arc<[Candidate]> + Send + 'static) -> Self {
        Self(Some(Arc::new(LazyLock::new(Box::new(find)))))
    }

    /// Whether the value of an object may identify a node.
    pub(super) fn want(&self, object: Multiplexer) -> bool {
        self.0.is_some() && (OBJECTS.contains(&object) || object.sub.0 == 0 && has_role(object.index, Role::Identity))
    }

    /// The objects of the communication profile and of all device profiles that may identify a node.
    pub fn objects() -> impl Iterator<Item = Multiplexer> {
        let of_profiles = profiles().flat_map(|profile| with_role(profile, Role::Identity));
        OBJECTS.into_iter().chain(of_profiles.map(|index| Multiplexer { index, sub: SubIndex(0) }))
    }

    /// The models that match the objects shown: no contradiction, and enough confirmation.
    pub fn fitting(&self, shown: &Shown) -> Vec<Arc<str>> {
        let candidates = self.get();
        let fitting = candidates.iter().filter(|candidate| candidate.evidence(shown).is_some());
        fitting.map(|candidate| Arc::clone(&candidate.id)).collect()
    }

    /// Whether there are models as which nodes can be recognised.
    pub(super) const fn exist(&self) -> bool {
        self.0.is_some()
    }

    pub(super) fn get(&self) -> Arc<[Candidate]> {
        self.0.as_ref().map(|found| Arc::clone(LazyLock::force(found))).unwrap_or_default()
    }
}

/// The value that a node of a model has in one of [`Candidates::objects`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Fact {
    /// One of these numbers.
    Number(Vec<u32>),
    /// This text.
    Text(String),
    /// A text with this beginning.
    Begins(String),
}

/// The result of a recognition.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Recognition {
    /// The model.
    pub model: Arc<str>,
    /// Other models that match equally well.
    pub or: Vec<Arc<str>>,
    /// The objects that confirm the model.
    pub by: Vec<Multiplexer>,
}

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
const NAME: Multiplexer = Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0);
const VENDOR: Multiplexer = Multiplexer::new(object::IDENTITY, 1);
const PRODUCT: Multiplexer = Multiplexer::new(object::IDENTITY, 2);

/// The objects of the communication profile that may identify a node.
const OBJECTS: [Multiplexer; 8] = [
    DEVICE_TYPE,
    NAME,
    Multiplexer::new(object::MANUFACTURER_HARDWARE_VERSION, 0),
    Multiplexer::new(object::MANUFACTURER_SOFTWARE_VERSION, 0),
    VENDOR,
    PRODUCT,
    Multiplexer::new(object::IDENTITY, 3),
    Multiplexer::new(object::IDENTITY, 4),
];

/// The values of identifying objects that a node has shown, as transferred.
pub type Shown = BTreeMap<Multiplexer, Vec<u8>>;

/// What a node shows of its model besides its identity.
#[derive(Clone, Default)]
pub(super) struct Traits {
    /// The objects that were transferred, of the manufacturer and of device profiles.
    objects: BTreeSet<Multiplexer>,
    /// The lengths of the first TPDOs in bytes.
    lengths: [Option<u8>; 4],
}

impl Traits {
    /// Maximum number of objects that are kept for each node. Two models differ in far fewer objects.
    const MOST: usize = 64;

    /// Notes a transferred object; returns whether the object is new.
    pub fn transferred(&mut self, object: Multiplexer) -> bool {
        let is_of_model = matches!(object.index.0, 0x2000..=0x9FFF);
        is_of_model && self.objects.len() < Self::MOST && self.objects.insert(object)
    }

    /// Notes the length of a TPDO, numbered from 1, that the node has not sent before; returns whether it is new. Later
    /// lengths do not count, so that PDOs after the first have no effect.
    pub fn received(&mut self, tpdo: u16, length: usize) -> bool {
        let known = self.lengths.get_mut(usize::from(tpdo).wrapping_sub(1)).filter(|known| known.is_none());
        let Some(known) = known else { return false };
        *known = u8::try_from(length).ok();
        true
    }

    fn fit_objects(&self, candidate: &Candidate) -> bool {
        let dictionary = &candidate.device.description.dictionary;
        self.objects.iter().all(|object| dictionary.entry(*object).is_ok())
    }

    fn fit_lengths(&self, candidate: &Candidate) -> bool {
        let seen = (1..).zip(self.lengths).filter_map(|(tpdo, length)| Some((tpdo, usize::from(length?))));
        seen.into_iter().all(|(tpdo, length)| candidate.tpdo_length(tpdo).is_none_or(|described| described == length))
    }

    /// The models of a choice that fit the traits; the whole choice if none fits. Models that the user named remain.
    fn narrow<T>(&self, mut choice: Vec<T>, of: impl Fn(&T) -> &Candidate) -> Vec<T> {
        for fits in [Self::fit_objects, Self::fit_lengths] {
            if choice.iter().any(|one| fits(self, of(one))) {
                choice.retain(|one| of(one).is_said || fits(self, of(one)));
            }
        }
        choice
    }
}

/// Maximum length of a device name.
pub(super) const LONGEST: usize = 64;

impl Candidate {
    /// The model of a description: its facts are the defaults of 1000h, 1008h and 1018h:01 and :02.
    pub fn of(id: &str, device: Arc<KnownDevice>) -> Self {
        let fact = |object| {
            let value = device.description.dictionary.entry(object).ok()?.start_value(NodeId::MIN)?;
            let fact = match value {
                Value::VisibleString(text) => Fact::Text(String::from_utf8(text).ok()?),
                other => Fact::Number(vec![u32::try_from(other.to_raw()?).ok()?]),
            };
            Some((object, fact))
        };
        let facts = [DEVICE_TYPE, NAME, VENDOR, PRODUCT].into_iter().filter_map(fact).collect();
        Self { id: id.into(), facts, device, is_said: false }
    }

    /// A model named by the user, for nodes that show all of these facts.
    pub fn said(id: &str, facts: Vec<(Multiplexer, Fact)>, device: Arc<KnownDevice>) -> Self {
        Self { id: id.into(), facts, device, is_said: true }
    }

    /// Sets a fact.
    pub fn set(&mut self, object: Multiplexer, fact: Fact) {
        self.facts.retain(|known| known.0 != object);
        self.facts.push((object, fact));
    }

    /// The objects that confirm the facts; `None` if an object contradicts them, or if too few objects confirm them.
    fn evidence(&self, shown: &Shown) -> Option<Vec<Multiplexer>> {
        let mut seen = Vec::new();
        for (object, fact) in &self.facts {
            if let Some(data) = shown.get(object) {
                if !fact.holds(data) {
                    return None;
                }
                seen.push(*object);
            }
        }
        seen.sort_unstable();
        if self.is_said {
            return (seen.len() == self.facts.len()).then_some(seen);
        }
        let both = |a, b| seen.contains(&a) && seen.contains(&b);
        (both(VENDOR, PRODUCT) || both(DEVICE_TYPE, NAME)).then_some(seen)
    }

    /// The length in bytes of a TPDO, numbered from 1, of a device as delivered; `None` if it is not described.
    fn tpdo_length(&self, tpdo: u16) -> Option<usize> {
        if self.device.manual.settings.pads(tpdo) {
            return Some(8);
        }
        let dictionary = &self.device.description.dictionary;
        let of = |sub| {
            let entry = dictionary.entry(Multiplexer::new(PdoNumber::Transmit(tpdo).mapping_index(), sub)).ok()?;
            u32::try_from(entry.start_value(NodeId::MIN)?.to_raw()?).ok()
        };
        let count = of(0).and_then(|count| u8::try_from(count).ok()).filter(|&count| (1..=64).contains(&count))?;
        let bits: Option<usize> = (1..=count).map(|sub| Some(usize::from(MappingEntry(of(sub)?).bits()))).sum();
        bits.map(|bits| bits.div_ceil(8))
    }

    /// Whether the PDOs of both models have the same layout and transmission.
    fn has_pdos_of(&self, other: &Self) -> bool {
        let start = |candidate: &Self, object| {
            let entry = candidate.device.description.dictionary.entry(object).ok()?;
            entry.start_value(NodeId::MIN)
        };
        self.device.description.dictionary.entries().all(|(object, entry)| {
            let is_pdo = matches!(object.index.0, 0x1400..=0x1BFF);
            !is_pdo || start(other, object).is_none_or(|value| entry.start_value(NodeId::MIN) == Some(value))
        })
    }
}

impl Fact {
    /// Whether an object's value matches the fact.
    pub fn holds(&self, data: &[u8]) -> bool {
        match self {
            Self::Number(any) => number(data).is_some_and(|number| any.contains(&number)),
            // Devices fill names up with zeros and blanks.
            Self::Text(text) => data.trim_ascii_end().split(|&byte| byte == 0).next() == Some(text.as_bytes()),
            Self::Begins(text) => data.starts_with(text.as_bytes()),
        }
    }
}

/// The model of a node that has shown these values and traits, and its index among the candidates.
pub(super) fn recognise(candidates: &[Candidate], shown: &Shown, traits: &Traits) -> Option<(usize, Recognition)> {
    let all = candidates.iter().enumerate();
    let fitting = all.filter_map(|(n, candidate)| Some((n, candidate, candidate.evidence(shown)?))).collect();
    let mut fitting = traits.narrow(fitting, |one: &(usize, &Candidate, _)| one.1).into_iter();
    let (place, first, by) = fitting.next()?;
    // With a model named by the user, other models need not be excluded.
    let others: Vec<_> =
        fitting.map(|(_, candidate, _)| candidate).filter(|other| other.is_said || !first.is_said).collect();
    others.iter().all(|other| first.has_pdos_of(other)).then(|| {
        let or = others.into_iter().map(|other| Arc::clone(&other.id)).collect();
        (place, Recognition { model: Arc::clone(&first.id), or, by })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(id: &str, pdo: u32, name: &str) -> Candidate {
        let eds = format!(
            "[DeviceInfo]\n[1800]\nParameterName=TPDO\nObjectType=8\nSubNumber=1\n[1800sub1]\nParameterName=COB-ID\n\
             ObjectType=7\nDataType=7\nAccessType=rw\nDefaultValue={pdo}\n"
        );
        let description = crate::dictionary::DeviceDescription::read(eds.as_bytes()).unwrap();
        let mut candidate = Candidate::of(id, Arc::new(KnownDevice::described(description)));
        candidate.set(DEVICE_TYPE, Fact::Number(vec![0x0001_0196, 0x0002_0196]));
        candidate.set(NAME, Fact::Begins(name.to_owned()));
        candidate.set(VENDOR, Fact::Number(vec![0x13]));
        candidate.set(PRODUCT, Fact::Number(vec![0x5868_2001]));
        candidate
    }

    fn recognised(candidates: &[Candidate], shown: &[(Multiplexer, &[u8])]) -> Option<Recognition> {
        let shown = shown.iter().map(|&(object, data)| (object, data.to_vec())).collect();
        recognise(candidates, &shown, &Traits::default()).map(|found| found.1)
    }

    const TYPE: (Multiplexer, &[u8]) = (DEVICE_TYPE, &[0x96, 1, 2, 0]);

    #[test]
    fn one_fact_is_too_few_and_a_contradiction_is_enough() {
        let all = [candidate("a", 0x185, "Sendix")];
        assert_eq!(recognised(&all, &[TYPE]), None);
        assert_eq!(recognised(&all, &[TYPE, (NAME, b"Sendix Encoder")]).unwrap().by, [DEVICE_TYPE, NAME]);
        assert_eq!(recognised(&all, &[TYPE, (NAME, b"Sendi")]), None);
        let identity: [(Multiplexer, &[u8]); 2] = [(VENDOR, &[0x13, 0, 0, 0]), (PRODUCT, &[0x01, 0x20, 0x68, 0x58])];
        assert!(recognised(&all, &identity).is_some());
        assert_eq!(recognised(&all, &[identity[0], identity[1], (DEVICE_TYPE, &[0x96, 1, 8, 0])]), None);
    }

    #[test]
    fn the_first_stands_for_its_like_only() {
        let shown = [TYPE, (NAME, &b"Sendix"[..])];
        let found = recognised(&[candidate("a", 0x185, "Sendix"), candidate("b", 0x185, "Send")], &shown).unwrap();
        assert_eq!((&*found.model, &found.or[..]), ("a", &["b".into()][..]));
        assert_eq!(recognised(&[candidate("a", 0x185, "Sendix"), candidate("b", 0x285, "Send")], &shown), None);
        let told = [candidate("a", 0x185, "Other"), candidate("b", 0x285, "Send")];
        assert_eq!(&*recognised(&told, &shown).unwrap().model, "b");
    }

    #[test]
    fn what_the_user_says_needs_all_that_was_named_and_no_more() {
        let built_in = candidate("a", 0x185, "Sendix");
        let facts = vec![(PRODUCT, Fact::Number(vec![0x5868_2001]))];
        let said = Candidate::said("mine", facts, Arc::clone(&candidate("b", 0x285, "").device));
        let all = [said, built_in];
        let product: (Multiplexer, &[u8]) = (PRODUCT, &[0x01, 0x20, 0x68, 0x58]);
        let found = recognised(&all, &[product, TYPE, (NAME, b"Sendix Encoder")]).unwrap();
        assert_eq!((&*found.model, found.or.len(), &found.by[..]), ("mine", 0, &[PRODUCT][..]));
        assert_eq!(&*recognised(&all, &[TYPE, (NAME, b"Sendix Encoder")]).unwrap().model, "a");
        assert_eq!(recognised(&all, &[(PRODUCT, &[2, 0, 0, 0])]), None);
    }

    #[test]
    fn names_are_filled_up() {
        let fact = Fact::Text("LMP30".to_owned());
        assert!(fact.holds(b"LMP30\0\0") && fact.holds(b"LMP30  ") && !fact.holds(b"LMP300"));
    }
}
