//! The schemas and channels of a file, and the decoder of each channel.

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

/// Maximum number of bytes of schemas in memory.
const MOST_SCHEMA_BYTES: usize = 16 * 1024 * 1024;
/// Maximum number of bytes of schemas parsed: all channels of a file may refer to the same large schema.
const MOST_PARSED_BYTES: usize = 4 * MOST_SCHEMA_BYTES;
/// Maximum number of bytes of schemas with a plan. The schema of a CAN frame has less than 4 KiB.
const MOST_PLANNED_BYTES: usize = MOST_SCHEMA_BYTES / 4;

/// The schemas and topics of a file.
#[derive(Default)]
pub(crate) struct Topics {
    /// The topics that the user asked for; empty for all topics.
    pub(crate) wanted: Vec<String>,
    schemas: HashMap<u16, records::SchemaHeader>,
    texts: HashMap<u16, Vec<u8>>,
    schema_bytes: usize,
    parsed_bytes: usize,
    planned_bytes: usize,
    /// The state of each channel, by its number in the file.
    pub(crate) slots: Vec<Slot>,
    /// All topics of the file, for the message that none of them has CAN frames.
    pub(crate) seen: Vec<String>,
    pub(crate) found: bool,
    pub(crate) channels: Channels,
}

/// The state of a channel.
#[derive(Default)]
pub(crate) enum Slot {
    #[default]
    Undeclared,
    /// The messages of the channel are no CAN frames, or the user did not ask for them.
    Other,
    /// The messages would be CAN frames, but their encoding or schema is damaged or unknown.
    Unreadable,
    Can(Box<Decoder>),
}

/// Decodes the messages of a channel.
pub(crate) struct Decoder {
    encoding: Encoding,
    pub(crate) channel: ChannelId,
    /// The number of the channel in the file.
    number: u16,
    pub(crate) messages: u64,
    /// Number of messages with a frame and without; messages without schema may have none.
    pub(crate) frames: u64,
    pub(crate) frameless: u64,
}

enum Encoding {
    Cdr(Plan),
    Ros1(Plan),
    Json(JsonPlan),
    Protobuf(ProtobufPlan),
}

impl Decoder {
    /// The frame of a message; `None` if it holds no frame.
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

/// Maximum number of topics in a message to the user.
const MOST_SEEN: usize = 20;

impl Topics {
    /// An empty state without schemas; `wanted` are the topics that the user asked for, empty for all.
    pub(crate) fn new(wanted: Vec<String>) -> Self {
        Self { wanted, ..Self::default() }
    }

    /// Stores a schema.
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

    /// Chooses the decoder of a channel.
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
        let text = self.texts.get(&channel.schema_id).map_or(0, Vec::len);
        self.parsed_bytes += text;
        if self.parsed_bytes > MOST_PARSED_BYTES {
            return Err(Flaw::unsupported(format!("channels with at most {MOST_PARSED_BYTES} bytes of schemas"), ""));
        }
        let encoding = match self.encoding(&channel) {
            Ok(encoding) => encoding,
            Err(flaw) => {
                if let Some(slot) = self.slots.get_mut(place) {
                    *slot = Slot::Unreadable;
                }
                return Err(flaw);
            }
        };
        let Some(encoding) = encoding else {
            if named {
                let expected =
                    format!("a schema with fields for an identifier and data on the topic {}", channel.topic);
                return Err(Flaw::unsupported(expected, self.schema_name(&channel)));
            }
            return Ok(());
        };
        self.planned_bytes += text;
        if self.planned_bytes > MOST_PLANNED_BYTES {
            let expected = format!("channels of CAN frames with at most {MOST_PLANNED_BYTES} bytes of schemas");
            return Err(Flaw::unsupported(expected, ""));
        }
        // Without a schema, only the messages show whether they are CAN frames.
        self.found |= !matches!(&encoding, Encoding::Json(plan) if !plan.is_certain());
        let name = self.channels.intern(topic::channel(&channel.topic));
        let decoder = Decoder { encoding, channel: name, number: channel.id, messages: 0, frames: 0, frameless: 0 };
        if let Some(slot) = self.slots.get_mut(place) {
            *slot = Slot::Can(Box::new(decoder));
        }
        Ok(())
    }

    /// A CAN channel with fewer messages than the file's statistics state: its name, the stated number and the actual
    /// number.
    pub(crate) fn missing(&self, statistics: &records::Statistics) -> Option<(&str, u64, u64)> {
        self.slots.iter().find_map(|slot| {
            let Slot::Can(decoder) = slot else { return None };
            let told = *statistics.channel_message_counts.get(&decoder.number)?;
            (told > decoder.messages).then(|| (self.channels.name(decoder.channel), told, decoder.messages))
        })
    }

    /// The CAN channels in which some messages had no frame, with the number of these messages.
    pub(crate) fn frameless(&self) -> impl Iterator<Item = (&str, u64)> {
        self.slots.iter().filter_map(|slot| match slot {
            Slot::Can(decoder) if decoder.frames > 0 && decoder.frameless > 0 => {
                Some((self.channels.name(decoder.channel), decoder.frameless))
            }
            _ => None,
        })
    }

    fn schema_name(&self, channel: &records::Channel) -> String {
        self.schemas.get(&channel.schema_id).map_or_else(|| "no schema".to_owned(), |schema| schema.name.clone())
    }

    /// The encoding of the channel's messages; `None` if they are no CAN frames.
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
            // An unsupported schema is a damage only if it seems to be one of CAN frames.
            Err(error) if looks_like_can(name) => Err(Flaw::unsupported(error, format!("schema {name}"))),
            Err(_) => Ok(None),
        };
        let ros = || match ros()? {
            None if is_can_frame(name) => {
                Err(Flaw::unsupported("fields for an identifier and data", format!("schema {name}")))
            }
            plan => Ok(plan),
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

/// Whether the name of the message proves that it is a CAN frame, whatever its fields.
fn is_can_frame(name: &str) -> bool {
    name.starts_with("can_msgs/") || Shape::is_named_fd(name.rsplit('/').next().unwrap_or_default())
}

/// Whether the name of the message suggests a CAN frame, so that the user would miss its frames.
fn looks_like_can(name: &str) -> bool {
    let last = name.rsplit(['/', '.', ':']).next().unwrap_or_default();
    name.starts_with("can_msgs/") || last.contains("CAN") || last.contains("Can") || Shape::is_named_fd(last)
}
