//! The object dictionary: data types, values, device descriptions (EDS, DCF, XDD, XDC), and the names of the
//! standards.

mod annotation;
pub mod check;
pub mod configuration;
pub mod consistency;
pub mod convert;
mod data_type;
mod description;
pub mod difference;
pub mod editor;
pub mod eds;
pub mod layout;
mod limits;
mod loss;
mod manual;
mod moment;
pub mod names;
mod object;
mod place;
mod problem;
mod reading;
pub mod rules;
pub mod source;
pub mod survey;
mod unusable;
mod value;
pub mod xdd;

pub use annotation::{Annotation, Annotations, BitName, Condition, Redundancy};
pub use data_type::{DataClass, DataType};
pub use description::{Commissioning, DeviceDescription, DeviceInfo, FileInfo, Module, ObjectLists, SubExtension};
pub use loss::{Loss, LossKind};
pub use manual::{Checked, EmergencyField, KnownDevice, KnownEmergency, Manual, Settings};
pub use names::Unit;
pub use object::{Access, Entry, Missing, Object, ObjectCode, ObjectDictionary, ObjectFlags, Setting};
pub use place::{SectionId, Span, Spot};
pub use problem::EdsProblem;
pub use rules::{ProblemKind, Rule, Severity};
pub use unusable::Unusable;
pub use value::{DaysAndMilliseconds, Value, ValueError};
