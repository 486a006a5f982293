//! What the device has: its description and the device itself are asked.

use super::Bench;
use super::objects::{EVENT_TIMER, TPDO_COB_ID, TPDO_FIRST_ENTRY, TPDO_MAPPED};
use super::pdo::RPDO;
use super::sdo::{DEVICE_TYPE, Reply, number};
use super::state::{GUARD_TIME, Heartbeats};
use crate::case::{Need, Touch};
use crate::verdict::Stop;
use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::Outcome;
use canvass_device::models::Model;

const SYNC_ID: Multiplexer = Multiplexer::new(0x1005, 0);

/// Bit 30 of 1005h: the device produces SYNC.
const PRODUCES: u32 = 1 << 30;

/// A need that is not met is no error.
fn not_applicable(stop: Stop) -> Result<Result<(), String>, Stop> {
    match stop {
        Stop::NotApplicable(reason) => Ok(Err(reason.actual)),
        other => Err(other),
    }
}

/// How a server says that it does not know a command. Any other refusal of a right request is no word on that.
pub fn is_unknown_command(code: AbortCode) -> bool {
    [AbortCode::COMMAND_SPECIFIER, AbortCode::UNSUPPORTED_ACCESS, AbortCode::GENERAL].contains(&code)
}

fn says_absent(reply: &Reply) -> bool {
    reply.response.is_none() || reply.abort().is_some_and(is_unknown_command)
}

impl Bench<'_> {
    /// Whether a case's need is met; if not, why not. Asked once in a run.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus fails, [`Stop::Inconclusive`] if the run was cancelled.
    pub fn meets(&mut self, need: Need) -> Result<Result<(), String>, Stop> {
        // Other nodes can turn up at any time.
        if need == Need::Alone {
            return self.alone();
        }
        // A shaft that rests now may turn in the next case.
        if need == Need::TurningShaft {
            return self.turning_shaft();
        }
        if let Some(known) = self.knowledge.features.get(&need) {
            return Ok(known.clone());
        }
        let met = self.unjudged(|bench| bench.find_out(need))?;
        self.knowledge.features.insert(need, met.clone());
        Ok(met)
    }

    fn find_out(&mut self, need: Need) -> Result<Result<(), String>, Stop> {
        let absent = |what: &str| Err(format!("the device has no {what}"));
        Ok(match need {
            Need::VisibleState => match self.heartbeats()? != Heartbeats::None || self.has(GUARD_TIME)? {
                true => Ok(()),
                false => Err("the device has no 1017h that is not 0, and no 100Ch".to_owned()),
            },
            Need::Heartbeat => match self.heartbeats()? {
                Heartbeats::Settable => Ok(()),
                Heartbeats::Fixed(period) => {
                    Err(format!("the period is fixed: 1017h is {period} and can't be written"))
                }
                Heartbeats::None => Err("the device has no 1017h that can be written".to_owned()),
            },
            Need::ScratchObject => match self.scratch_objects()?.is_empty() {
                true => absent("object that can be written without consequence"),
                false => Ok(()),
            },
            Need::SegmentedUpload => self
                .long_object(8)?
                .map(|_| ())
                .ok_or_else(|| "no object that was found gives more than 7 bytes".to_owned()),
            Need::Tpdo => self.tpdo()?,
            Need::EventTimer => self.event_timer()?,
            Need::Name => {
                if self.names()?.is_empty() {
                    absent("1008h, 1009h or 100Ah")
                } else {
                    Ok(())
                }
            }
            Need::Lss => self.lss(),
            Need::Lmt => self.lmt()?,
            Need::HeartbeatConsumer => self.heartbeat_consumer()?,
            Need::Monitoring => match self.can_be_guarded()? {
                true => Ok(()),
                false if self.watches_once_stored() => {
                    Err("the device watches other nodes only once that is stored, as its manual says".to_owned())
                }
                false => self.heartbeat_consumer()?,
            },
            Need::Guarding => match (self.has(GUARD_TIME)?, self.heartbeats()?) {
                (false, _) => absent("100Ch"),
                (true, Heartbeats::Fixed(_)) => {
                    Err("its heartbeat can't be switched off (1017h), and goes before guarding".to_owned())
                }
                (true, _) => Ok(()),
            },
            Need::ErrorHistory => {
                if self.has(Multiplexer::new(0x1003, 0))? {
                    Ok(())
                } else {
                    absent("1003h")
                }
            }
            Need::DynamicMapping => self.dynamic_mapping()?,
            Need::Rpdo => self.all_there(&[RPDO.parameter(1), RPDO.entry(0)])?,
            Need::RpdoMapping => match self.all_writable(&[RPDO.parameter(1), RPDO.entry(0), RPDO.entry(1)])? {
                Ok(()) if self.rpdo_objects().is_empty() => {
                    Err("the description names no object that an RPDO can carry and an SDO can read".to_owned())
                }
                met => met,
            },
            Need::Changeable => match self.dynamic_mapping()? {
                Ok(()) => self.changeable().map_or_else(not_applicable, |_| Ok(Ok(())))?,
                unmet => unmet,
            },
            Need::Sync => self.all_there(&[SYNC_ID])?,
            Need::SyncProducer => self.sync_producer()?,
            Need::SyncCounter => self.all_writable(&[Multiplexer::new(0x1019, 0)])?,
            Need::Time => self.all_writable(&[Multiplexer::new(0x1012, 0)])?,
            Need::EmcyObject => self.all_there(&[Multiplexer::new(0x1014, 0)])?,
            Need::EmcyId => self.all_writable(&[Multiplexer::new(0x1014, 0)])?,
            Need::EmcyInhibit => self.all_writable(&[Multiplexer::new(0x1015, 0)])?,
            Need::ErrorBehaviour => self.all_writable(&[Multiplexer::new(0x1029, 1)])?,
            Need::ApplicationParameter => match self.application_scratch()? {
                Some(_) => Ok(()),
                None => {
                    Err("no application object that the tester knows can be written without consequence".to_owned())
                }
            },
            Need::ServerParameter => self.all_there(&[Multiplexer::new(0x1200, 1)])?,
            Need::SecondServer => self.all_writable(&[Multiplexer::new(0x1201, 1), Multiplexer::new(0x1201, 2)])?,
            Need::StartUp => self.all_writable(&[Multiplexer::new(0x1F80, 0)])?,
            Need::Unconfigured => Err("the device has a node-ID".to_owned()),
            Need::Encoder => self.encoder()?,
            Need::VolatilePreset
            | Need::WorkArea
            | Need::Alarms
            | Need::TemperatureLimit
            | Need::RawPosition
            | Need::RawData
            | Need::Speed
            | Need::SpeedParameters
            | Need::Acceleration
            | Need::Jerk
            | Need::Cams
            | Need::HighPrecision
            | Need::TurningShaft
            | Need::RedundantChannels
            | Need::Inclinometer => self.of_encoder(need)?,
            Need::Store => {
                if self.has(Multiplexer::new(0x1010, 1))? {
                    Ok(())
                } else {
                    absent("1010h:01")
                }
            }
            Need::VerifyConfiguration => {
                self.all_writable(&[Multiplexer::new(0x1020, 1), Multiplexer::new(0x1020, 2)])?
            }
            Need::BlockUpload => self.block_upload_feature()?,
            Need::BlockDownload => self.block_download_feature()?.map(|_| ()),
            Need::BlockCrc => self.block_download_feature()?.and_then(|crc| {
                if crc { Ok(()) } else { Err("the SDO server checks no CRC of block downloads".to_owned()) }
            }),
            Need::LongScratch => match self.long_writable() {
                Some(_) => Ok(()),
                None => Err("the description names no string that can be written and read".to_owned()),
            },
            Need::EmptyValue => match self.empty_object()? {
                Some(_) => Ok(()),
                None => Err("no object that was found is an empty string".to_owned()),
            },
            Need::Description => match self.target.description {
                Some(_) => Ok(()),
                None => Err("no description of the device was given".to_owned()),
            },
            Need::Alone => self.alone()?,
        })
    }

    /// Whether the device has an object. It is the device that decides; where it does not answer, its description.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn has(&mut self, multiplexer: Multiplexer) -> Result<bool, Stop> {
        if let Some(described) = self.described(multiplexer) {
            return Ok(described);
        }
        let outcome = self.upload(multiplexer)?.outcome;
        Ok(match outcome {
            Outcome::Aborted(abort) => !matches!(abort.code, AbortCode::NO_OBJECT | AbortCode::NO_SUB_INDEX),
            Outcome::Silent => false,
            _ => true,
        })
    }

    /// What the description says of an object; `None` without a description.
    pub fn described(&self, multiplexer: Multiplexer) -> Option<bool> {
        self.target.description.as_ref().map(|description| description.dictionary.entry(multiplexer).is_ok())
    }

    /// Whether a block upload begins as one. It is aborted at once.
    fn block_upload_feature(&mut self) -> Result<Result<(), String>, Stop> {
        // Without a long object a short one will do.
        let multiplexer = self.long_object(8)?.unwrap_or(DEVICE_TYPE);
        let request = Request::InitiateBlockUpload { multiplexer, crc: true, block_size: 1, threshold: 0 };
        let reply = self.exchange(&request, format!("block upload of {multiplexer}"))?;
        self.send_request(&Request::abort(multiplexer, AbortCode::GENERAL))?;
        // A firmware that answers aborts does it now, not in the middle of the case.
        self.listen(self.timing().reaction)?;
        Ok(match says_absent(&reply) {
            true => Err(format!("a block upload of {multiplexer} is answered by {}", reply.actual())),
            false => Ok(()),
        })
    }

    /// Whether a block download begins as one, and whether with CRC. It is aborted before any data.
    fn block_download_feature(&mut self) -> Result<Result<bool, String>, Stop> {
        let Some(scratch) = self.scratch_objects()?.into_iter().next() else {
            return Ok(Err("the device has no object that can be written without consequence".to_owned()));
        };
        let (multiplexer, size) = (scratch.multiplexer, u32::try_from(scratch.value.len()).ok());
        let request = Request::InitiateBlockDownload { multiplexer, crc: true, size };
        let reply = self.exchange(&request, format!("block download to {multiplexer}"))?;
        self.send_request(&Request::abort(multiplexer, AbortCode::GENERAL))?;
        // A firmware that answers aborts does it now, not in the middle of the case.
        self.listen(self.timing().reaction)?;
        Ok(match reply.response {
            Some(Response::InitiateBlockDownload { crc, .. }) => Ok(crc),
            _ if says_absent(&reply) => {
                Err(format!("a block download to {multiplexer} is answered by {}", reply.actual()))
            }
            // Refused for another reason than that there are none: the cases judge that.
            _ => Ok(true),
        })
    }

    fn all_there(&mut self, objects: &[Multiplexer]) -> Result<Result<(), String>, Stop> {
        for &multiplexer in objects {
            if !self.has(multiplexer)? {
                return Ok(Err(format!("the device has no {multiplexer}")));
            }
        }
        Ok(Ok(()))
    }

    fn all_writable(&mut self, objects: &[Multiplexer]) -> Result<Result<(), String>, Stop> {
        for &multiplexer in objects {
            if !self.can_write(multiplexer)? {
                return Ok(Err(format!("{multiplexer} is absent or can't be written")));
            }
        }
        Ok(Ok(()))
    }

    /// Whether bit 30 of 1005h can be set while the period is 0: then nothing is sent.
    fn sync_producer(&mut self) -> Result<Result<(), String>, Stop> {
        let period = Multiplexer::new(0x1006, 0);
        if let Err(why) = self.all_writable(&[SYNC_ID, period])? {
            return Ok(Err(why));
        }
        let before = number(&self.read(SYNC_ID)?);
        let attempt = self.download(SYNC_ID, &(before | PRODUCES).to_le_bytes())?;
        let produces = attempt.outcome == Outcome::Downloaded;
        self.write(SYNC_ID, &before.to_le_bytes())?;
        Ok(if produces { Ok(()) } else { Err("bit 30 of 1005h can't be set".to_owned()) })
    }

    fn tpdo(&mut self) -> Result<Result<(), String>, Stop> {
        let Outcome::Uploaded(cob_id) = self.upload(TPDO_COB_ID)?.outcome else {
            return Ok(Err(format!("the device has no {TPDO_COB_ID}")));
        };
        if !CobId(number(&cob_id)).is_valid() {
            return Ok(Err(format!("TPDO 1 is switched off ({TPDO_COB_ID} is {})", CobId(number(&cob_id)))));
        }
        self.all_there(&[TPDO_MAPPED])
    }

    fn event_timer(&mut self) -> Result<Result<(), String>, Stop> {
        Ok(match self.tpdo()? {
            Ok(()) if !self.has(EVENT_TIMER)? => Err(format!("the device has no {EVENT_TIMER}")),
            met => met,
        })
    }

    /// Whether life guarding can be set, and is not kept off by a heartbeat that can't be ended.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub(crate) fn can_be_guarded(&mut self) -> Result<bool, Stop> {
        let is_settable = self.can_write(GUARD_TIME)? && self.can_write(Multiplexer::new(0x100D, 0))?;
        Ok(is_settable && !matches!(self.heartbeats()?, Heartbeats::Fixed(_)))
    }

    /// Whether the manual says that entries of 1016h act only once they are stored.
    fn watches_once_stored(&self) -> bool {
        let model = Model::by_id(&self.target.model);
        model.is_some_and(|model| model.sheet().network.heartbeat_consumer_needs_store)
    }

    fn heartbeat_consumer(&mut self) -> Result<Result<(), String>, Stop> {
        Ok(match (self.has(Multiplexer::new(0x1016, 1))?, self.vacant_neighbour()) {
            (false, _) => Err("the device has no 1016h:01".to_owned()),
            (true, None) => Err("every node-ID beside that of the device is in use".to_owned()),
            (true, Some(_)) => Ok(()),
        })
    }

    /// Whether the device has an object and its description does not call it read-only.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn can_write(&mut self, multiplexer: Multiplexer) -> Result<bool, Stop> {
        if !self.is_described_as_writable(multiplexer) || !self.has(multiplexer)? {
            return Ok(false);
        }
        if self.target.description.is_some() {
            return Ok(true);
        }
        // Nobody says so: the value that it has is written again.
        let Outcome::Uploaded(value) = self.upload(multiplexer)?.outcome else { return Ok(false) };
        let refusal = self.download(multiplexer, &value)?.abort();
        Ok(!matches!(refusal, Some(AbortCode::READ_ONLY | AbortCode::UNSUPPORTED_ACCESS)))
    }

    fn dynamic_mapping(&mut self) -> Result<Result<(), String>, Stop> {
        for multiplexer in [TPDO_COB_ID, TPDO_MAPPED, TPDO_FIRST_ENTRY] {
            if !self.can_write(multiplexer)? {
                return Ok(Err(format!("{multiplexer} is absent or can't be written")));
            }
        }
        Ok(Ok(()))
    }

    fn encoder(&mut self) -> Result<Result<(), String>, Stop> {
        let Outcome::Uploaded(device_type) = self.upload(Multiplexer::new(0x1000, 0))?.outcome else {
            return Ok(Err("1000h can't be read".to_owned()));
        };
        let profile = number(&device_type) & 0xFFFF;
        if profile != 406 {
            return Ok(Err(format!("1000h names profile {profile}")));
        }
        Ok(if self.has(Multiplexer::new(0x6004, 0))? { Ok(()) } else { Err("the device has no 6004h".to_owned()) })
    }

    fn lss(&self) -> Result<(), String> {
        match &self.target.description {
            Some(description) if description.device.lss_supported => Ok(()),
            Some(_) => Err("the description says that LSS is not supported".to_owned()),
            None => Err("without a description it is not known whether the device supports LSS".to_owned()),
        }
    }

    fn lmt(&mut self) -> Result<Result<(), String>, Stop> {
        let described = self.target.description.as_ref();
        if described.is_some_and(|description| description.device.lss_supported) {
            return Ok(Err("the description says that the device has LSS".to_owned()));
        }
        Ok(match crate::cases::ds205::has_slave(self)? {
            true => Ok(()),
            false => Err("no LMT slave answers an inquiry".to_owned()),
        })
    }

    fn alone(&mut self) -> Result<Result<(), String>, Stop> {
        if self.options.allow.contains(&Touch::OtherNodes) {
            return Ok(Ok(()));
        }
        self.look_for_others()?;
        Ok(match self.watch.others().first() {
            None => Ok(()),
            Some(other) => Err(format!(
                "node {other} is on this bus too; with --allow {} it is commanded as well",
                Touch::OtherNodes
            )),
        })
    }

    /// A node-ID next to that of the device at which no other node was heard.
    pub fn vacant_neighbour(&self) -> Option<u8> {
        let own = self.node().raw();
        let candidates = [own.checked_add(1), own.checked_sub(1), own.checked_add(2), own.checked_sub(2)];
        let vacant =
            |raw: &u8| canvass_analyzer::NodeId::new(*raw).is_some_and(|node| !self.watch.others().contains(&node));
        candidates.into_iter().flatten().find(vacant)
    }
}
