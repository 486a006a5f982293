//! The schemas and channels of a file, and how the messages of each channel are read.

use super::cdr::Cdr;
use super::fields::Shape;
use super::json::JsonPlan;
use super::plan::Plan;
use super::protobuf::ProtobufPlan;
use super::ros1::Ros1;
use super::{lengths, ros_definition, topic};
use crate::damage::Flaw;
use crate::{ChannelId, Channels, Record, Timestamp};
use mcap::records::{self, op};
use std::collections::HashMap;

/// How many bytes of schemas are held.
const MOST_SCHEMA_BYTES: usize = 64 * 1024 * 1024;

/// What is known of the file's schemas and topics.
#[derive(Default)]
pub(crate) struct Topics {
    /// By the user; empty for all.
    pub(crate) wanted: Vec<String>,
    schemas: HashMap<u16, records::SchemaHeader>,
    texts: HashMap<u16, Vec<u8>>,
    schema_bytes: usize,
    /// By the file's channel number.
    pub(crate) slots: Vec<Slot>,
    /// All topics of the file, for the message that none of them has CAN frames.
    pub(crate) seen: Vec<String>,
    pub(crate) found: bool,
    pub(crate) channels: Channels,
}

/// What is known of a channel.
#[derive(Default)]
pub(crate) enum Slot {
    #[default]
    Undeclared,
    /// Its messages are no CAN frames, or not wanted.
    Other,
    Can(Box<Decoder>),
}

/// How to read a channel's messages.
pub(crate) struct Decoder {
    encoding: Encoding,
    pub(crate) channel: ChannelId,
}

enum Encoding {
    Cdr(Plan),
    Ros1(Plan),
    Json(JsonPlan),
    Protobuf(ProtobufPlan),
}

impl Decoder {
    /// The frame of a message; `None` if it is none with a frame.
    #[inline]
    pub(crate) fn record(&self, message: &[u8], logged: Timestamp) -> Result<Option<Record>, Flaw> {
        let record = match &self.encoding {
            Encoding::Cdr(plan) => plan.record(&mut Cdr::new(message)?, logged)?,
            Encoding::Ros1(plan) => plan.record(&mut Ros1(message), logged)?,
            Encoding::Protobuf(plan) => plan.read(message)?.record(plan.shape(), logged)?,
            Encoding::Json(plan) => match plan.read(message)? {
                Some(values) => values.record(plan.shape(), logged)?,
                None => return Ok(None),
            },
        };
        Ok(Some(record))
    }
}

/// The longest list of topics in a message to the user.
const MOST_SEEN: usize = 20;

impl Topics {
    /// Nothing known yet; `wanted` are the topics that the user names, none for all.
    pub(crate) fn new(wanted: Vec<String>) -> Self {
        Self { wanted, ..Self::default() }
    }

    /// Keeps a schema.
    pub(crate) fn schema(&mut self, record: &[u8]) -> Result<(), Flaw> {
        let parsed = lengths::schema_fits(record).then(|| mcap::parse_record(op::SCHEMA, record));
        let Some(Ok(records::Record::Schema { header, data })) = parsed else {
            return Err(Flaw::malformed("a schema", format!("{} bytes", record.len())));
        };
        if self.texts.contains_key(&header.id) {
            return Ok(());
        }
        self.schema_bytes += data.len();
        if self.schema_bytes > MOST_SCHEMA_BYTES {
            return Err(Flaw::unsupported(format!("at most {MOST_SCHEMA_BYTES} bytes of schemas"), ""));
        }
        self.texts.insert(header.id, data.into_owned());
        self.schemas.insert(header.id, header);
        Ok(())
    }

    /// Finds out how a channel's messages are read.
    pub(crate) fn channel(&mut self, record: &[u8]) -> Result<(), Flaw> {
        let parsed = lengths::channel_fits(record).then(|| mcap::parse_record(op::CHANNEL, record));
        let Some(Ok(records::Record::Channel(channel))) = parsed else {
            return Err(Flaw::malformed("a channel", format!("{} bytes", record.len())));
        };
        let place = usize::from(channel.id);
        // Channels are repeated in chunks and in the summary.
        if self.slots.get(place).is_some_and(|slot| !matches!(slot, Slot::Undeclared)) {
            return Ok(());
        }
        if self.slots.len() <= place {
            self.slots.resize_with(place + 1, Slot::default);
        }
        let Some(slot) = self.slots.get_mut(place) else { return Ok(()) };
        *slot = Slot::Other;
        if self.seen.len() < MOST_SEEN && !self.seen.contains(&channel.topic) {
            self.seen.push(channel.topic.clone());
        }
        let named = self.wanted.contains(&channel.topic);
        if !self.wanted.is_empty() && !named {
            return Ok(());
        }
        let Some(encoding) = self.encoding(&channel)? else {
            if named {
                let expected =
                    format!("a schema with fields for an identifier and data on the topic {}", channel.topic);
                return Err(Flaw::unsupported(expected, self.schema_name(&channel)));
            }
            return Ok(());
        };
        // Without a schema only the messages show whether they are CAN frames.
        self.found |= !matches!(&encoding, Encoding::Json(plan) if !plan.is_certain());
        let decoder = Decoder { encoding, channel: self.channels.intern(topic::channel(&channel.topic)) };
        if let Some(slot) = self.slots.get_mut(place) {
            *slot = Slot::Can(Box::new(decoder));
        }
        Ok(())
    }

    fn schema_name(&self, channel: &records::Channel) -> String {
        self.schemas.get(&channel.schema_id).map_or_else(|| "no schema".to_owned(), |schema| schema.name.clone())
    }

    /// How the channel's messages are read; `None` if they are no CAN frames.
    fn encoding(&self, channel: &records::Channel) -> Result<Option<Encoding>, Flaw> {
        if channel.schema_id != 0 && !self.texts.contains_key(&channel.schema_id) {
            let expected = format!("the schema {} before the channel {}", channel.schema_id, channel.topic);
            return Err(Flaw::malformed(expected, ""));
        }
        let text = self.texts.get(&channel.schema_id).map_or(&[][..], Vec::as_slice);
        let (name, kind) = self
            .schemas
            .get(&channel.schema_id)
            .map_or(("", ""), |schema| (schema.name.as_str(), schema.encoding.as_str()));
        let ros = || match ros_definition::parse(name, &String::from_utf8_lossy(text)) {
            Ok(definitions) => Ok(Plan::new(&definitions)),
            // A schema that is not understood may well be no CAN frame.
            Err(error) if looks_like_can(name) => Err(Flaw::unsupported(error, format!("schema {name}"))),
            Err(_) => Ok(None),
        };
        Ok(match (channel.message_encoding.as_str(), kind) {
            ("cdr", "ros2msg") => ros()?.map(Encoding::Cdr),
            ("ros1", "ros1msg") => ros()?.map(Encoding::Ros1),
            ("json", _) => JsonPlan::new(name, text).map(Encoding::Json),
            ("protobuf", "protobuf") => ProtobufPlan::new(name, text).map(Encoding::Protobuf),
            (encoding, kind) if looks_like_can(name) => {
                let expected = "an encoding cdr with ros2msg, ros1 with ros1msg, json, or protobuf";
                return Err(Flaw::unsupported(expected, format!("{encoding} with {kind} for {name}")));
            }
            _ => None,
        })
    }
}

/// Whether a message of that name is probably a CAN frame, so that it would be missed.
fn looks_like_can(name: &str) -> bool {
    let last = name.rsplit(['/', '.', ':']).next().unwrap_or_default();
    name.starts_with("can_msgs/") || last.contains("CAN") || last.contains("Can") || Shape::is_named_fd(last)
}
