//! The needs of the cases of CiA 406: features of encoders, and of Kübler's encoders in particular.

use crate::bench::Bench;
use crate::bench::Met;
use crate::bench::objects::TPDO_FIRST_ENTRY;
use crate::bench::sdo::number;
use crate::need::Need;
use crate::touch::Touch;
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_traces::Duration;

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
const POSITION: Multiplexer = Multiplexer::new(encoder::POSITION_VALUE, 0);
const LENGTH: Multiplexer = Multiplexer::new(encoder::CHANNEL_POSITION_VALUES, 0);
const PRESET: Multiplexer = Multiplexer::new(encoder::PRESET_VALUE, 0);
const VENDOR_ID: Multiplexer = Multiplexer::new(object::IDENTITY, 1);
const KUEBLER: u32 = 0x13;

/// Maximum change of the position of a shaft at rest, in measuring steps.
const TREMBLE: u32 = 4;

/// The device is an encoder (CiA 406).
pub static ENCODER: Need = Need::new("encoder", "an encoder of CiA 406 with a position (6004h)", |bench| {
    let profile = number(&bench.upload(DEVICE_TYPE)?.value()?) & 0xFFFF;
    if profile != 406 {
        return Ok(Err(format!("1000h names profile {profile}")));
    }
    bench.has_all(&[POSITION])
});

/// A preset (6003h) that a reset reverses, unless the user allows writing to non-volatile memory. A device that stores
/// a preset at once wears its memory, and keeps a wrong position if the run ends in the middle.
pub(crate) static VOLATILE_PRESET: Need = Need::new(
    "volatile-preset",
    "a preset that is not stored immediately (or permission to write non-volatile memory)",
    |bench| {
        let may_store = bench.options().allow.contains(&Touch::Nvm);
        Ok(match keeps_presets(bench) && !may_store {
            true => {
                Err("the device stores a preset immediately, and writing non-volatile memory is not allowed".to_owned())
            }
            false => Ok(()),
        })
    },
);

/// Whether the device stores a preset as soon as it is written, according to its manual.
pub(super) fn keeps_presets(bench: &Bench<'_>) -> bool {
    bench.manual().is_some_and(|model| model.sheet().storage.persist_at_once.contains(&PRESET))
}

/// A work area: 6400h, 6401h and 6402h.
pub(crate) static WORK_AREA: Need = Need::new("work-area", "a work area (6400h to 6402h)", |bench| {
    all(bench, &[(encoder::WORK_AREA_STATE, 1), (encoder::WORK_AREA_LOW_LIMIT, 1), (encoder::WORK_AREA_HIGH_LIMIT, 1)])
});

/// Alarms and warnings: 6503h to 6506h.
pub static ALARMS: Need = Need::new("alarms", "alarms and warnings (6503h to 6506h)", |bench| {
    all(
        bench,
        &[
            (encoder::ALARMS, 0),
            (encoder::SUPPORTED_ALARMS, 0),
            (encoder::WARNINGS, 0),
            (encoder::SUPPORTED_WARNINGS, 0),
        ],
    )
});

/// The temperature limits of Kübler's Sendix encoders, 2120h.
pub(crate) static TEMPERATURE_LIMIT: Need =
    Need::new("temperature-limit", "temperature limits of Kübler's Sendix encoders (2120h)", |bench| {
        of_kuebler(bench, &[(0x2120, 2), (0x2120, 3), (encoder::WARNINGS, 0)])
    });

/// The raw position 600Ch.
pub static RAW_POSITION: Need =
    Need::new("raw-position", "a raw position (600Ch)", |bench| all(bench, &[(encoder::POSITION_RAW_VALUE, 0)]));

/// The raw position of Kübler's Sendix encoders with its inverse and checksum, 2160h to 2162h.
pub(crate) static RAW_DATA: Need =
    Need::new("raw-data", "the raw position of Kübler's Sendix encoders with its checksum (2160h to 2162h)", |bench| {
        of_kuebler(bench, &[(0x2160, 0), (0x2161, 0), (0x2162, 0)])
    });

/// The speed 6030h.
pub(crate) static SPEED: Need = Need::new("speed", "a speed (6030h)", |bench| all(bench, &[(encoder::SPEED_VALUE, 1)]));

/// The speed 6030h with its parameters 6031h.
pub(crate) static SPEED_PARAMETERS: Need =
    Need::new("speed-parameters", "a speed with parameters (6030h, 6031h)", |bench| {
        all(bench, &[(encoder::SPEED_VALUE, 1), (encoder::SPEED_PARAMETER, 4)])
    });

/// The acceleration 6040h.
pub(crate) static ACCELERATION: Need = Need::new("acceleration", "an acceleration (6040h)", |bench| {
    all(bench, &[(encoder::SPEED_VALUE, 1), (encoder::ACCELERATION_VALUE, 1)])
});

/// The jerk 6050h, with the acceleration 6040h.
pub(crate) static JERK: Need = Need::new("jerk", "a jerk (6050h) and an acceleration (6040h)", |bench| {
    all(bench, &[(encoder::ACCELERATION_VALUE, 1), (encoder::JERK_VALUE, 1)])
});

/// Cams: 6300h, 6301h, 6302h, 6310h and 6320h.
pub static CAMS: Need = Need::new("cams", "cams (6300h to 6302h, 6310h, 6320h)", |bench| {
    all(
        bench,
        &[
            (encoder::CAM_STATE, 1),
            (encoder::CAM_ENABLE, 1),
            (encoder::CAM_POLARITY, 1),
            (encoder::CAM_LOW_LIMIT, 1),
            (encoder::CAM_HIGH_LIMIT, 1),
        ],
    )
});

/// The position in 64 bits, 6008h.
pub(crate) static HIGH_PRECISION: Need = Need::new("high-precision", "a position in 64 bits (6008h)", |bench| {
    all(bench, &[(encoder::HIGH_PRECISION_POSITION, 0)])
});

/// The shaft turns, or the wire moves, while the case runs. A shaft that is at rest now may turn in the next case.
pub(crate) static TURNING_SHAFT: Need = Need::new("turning-shaft", "a shaft that turns while the case runs", |bench| {
    let at = if bench.has(POSITION)? { POSITION } else { LENGTH };
    if !bench.has(at)? {
        return Ok(Err("the device has no position".to_owned()));
    }
    let first = bench.read_number(at)?;
    bench.listen(Duration::from_millis(100))?;
    let second = bench.read_number(at)?;
    Ok(if first.abs_diff(second) > TREMBLE { Ok(()) } else { Err("the shaft is at rest".to_owned()) })
})
.fleeting()
.moving();

/// Two redundant channels of the position in TPDO 1: 6020h twice in 1A00h.
pub(crate) static REDUNDANT_CHANNELS: Need =
    Need::new("redundant-channels", "two redundant channels of the position (6020h twice in 1A00h)", |bench| {
        let second = Multiplexer::new(TPDO_FIRST_ENTRY.index.0, 2);
        for entry in [TPDO_FIRST_ENTRY, second] {
            if !bench.has(entry)? || bench.read_number(entry)? >> 16 != u32::from(LENGTH.index.0) {
                return Ok(Err(format!("{entry} does not map 6020h")));
            }
        }
        Ok(Ok(()))
    });

/// The inclinometer of Kübler's draw-wire encoders: 3003h to 3010h, 5000h.
pub(crate) static INCLINOMETER: Need =
    Need::new("inclinometer", "the inclinometer of Kübler's draw-wire encoders (3003h to 3010h, 5000h)", |bench| {
        of_kuebler(bench, &[(0x3003, 0), (0x3004, 0), (0x3005, 0), (0x3010, 0), (0x5000, 0)])
    });

fn all(bench: &mut Bench<'_>, objects: &[(u16, u8)]) -> Result<Met, Stop> {
    let objects: Vec<Multiplexer> = objects.iter().map(|&(index, sub)| Multiplexer::new(index, sub)).collect();
    bench.has_all(&objects)
}

/// Checks objects in the manufacturer's area, which have a meaning only together with the vendor-ID.
fn of_kuebler(bench: &mut Bench<'_>, objects: &[(u16, u8)]) -> Result<Met, Stop> {
    if !bench.has(VENDOR_ID)? || bench.read_number(VENDOR_ID)? != KUEBLER {
        return Ok(Err("the device is not one of Kübler's".to_owned()));
    }
    all(bench, objects)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::need::tests::{assert_needs, unmet};
    use crate::scripted::Row;

    fn row(index: u16, sub: u8, value: &[u8]) -> Row {
        ((index, sub), value.to_vec(), false)
    }

    #[test]
    fn needs_are_the_objects_that_they_name() {
        let rows: [(&'static Need, &[(u16, u8)]); 9] = [
            (&WORK_AREA, &[(0x6400, 1), (0x6401, 1), (0x6402, 1)]),
            (&ALARMS, &[(0x6503, 0), (0x6504, 0), (0x6505, 0), (0x6506, 0)]),
            (&RAW_POSITION, &[(0x600C, 0)]),
            (&SPEED, &[(0x6030, 1)]),
            (&SPEED_PARAMETERS, &[(0x6030, 1), (0x6031, 4)]),
            (&ACCELERATION, &[(0x6030, 1), (0x6040, 1)]),
            (&JERK, &[(0x6040, 1), (0x6050, 1)]),
            (&CAMS, &[(0x6300, 1), (0x6301, 1), (0x6302, 1), (0x6310, 1), (0x6320, 1)]),
            (&HIGH_PRECISION, &[(0x6008, 0)]),
        ];
        for (need, objects) in rows {
            assert_needs(need, objects, false);
        }
    }

    /// The low word of 1000h is the profile: 406 is 196h in hexadecimal.
    #[test]
    fn an_encoder_has_its_profile_and_a_position() {
        let encoder = |device_type: &[u8]| unmet(&ENCODER, &[row(0x1000, 0, device_type), row(0x6004, 0, &[0; 4])]);
        assert_eq!(encoder(&[0x96, 1, 2, 0]), None);
        assert_eq!(encoder(&[0x96, 1, 8, 0]), None);
        assert_eq!(encoder(&[0x95, 1, 2, 0]).as_deref(), Some("1000h names profile 405"));
        assert!(unmet(&ENCODER, &[row(0x1000, 0, &[0x96, 1, 2, 0])]).is_some());
    }

    /// Kübler's vendor-ID in 1018h:01 is 13h.
    #[test]
    fn what_is_kueblers_is_of_kueblers_devices() {
        let needs: [(&'static Need, &[(u16, u8)]); 3] = [
            (&TEMPERATURE_LIMIT, &[(0x2120, 2), (0x2120, 3), (0x6505, 0)]),
            (&RAW_DATA, &[(0x2160, 0), (0x2161, 0), (0x2162, 0)]),
            (&INCLINOMETER, &[(0x3003, 0), (0x3004, 0), (0x3005, 0), (0x3010, 0), (0x5000, 0)]),
        ];
        for (need, objects) in needs {
            let mut rows: Vec<Row> = objects.iter().map(|&(index, sub)| row(index, sub, &[0])).collect();
            assert!(unmet(need, &rows).is_some());
            rows.push(row(0x1018, 1, &[0x13, 0, 0, 0]));
            assert_eq!(unmet(need, &rows), None, "{need:?}");
            for missing in 0..objects.len() {
                let mut fewer = rows.clone();
                fewer.remove(missing);
                assert!(unmet(need, &fewer).is_some(), "{need:?}");
            }
            if let Some(vendor) = rows.last_mut() {
                vendor.1 = vec![0x14, 0, 0, 0];
            }
            assert!(unmet(need, &rows).is_some_and(|why| why.contains("Kübler")));
        }
    }

    /// Two channels are 6020h:01 and :02 as the first two entries of 1A00h.
    #[test]
    fn two_channels_are_two_entries() {
        let mapped = |first: u8, second: u8| {
            let entry = |sub, low| row(0x1A00, sub, &[32, sub, low, 0x60]);
            unmet(&REDUNDANT_CHANNELS, &[entry(1, first), entry(2, second)]).is_none()
        };
        assert!(mapped(0x20, 0x20) && !mapped(0x20, 0x04) && !mapped(0x04, 0x20));
        assert!(unmet(&REDUNDANT_CHANNELS, &[row(0x1A00, 1, &[32, 1, 0x20, 0x60])]).is_some());
        assert_eq!(unmet(&TURNING_SHAFT, &[row(0x6004, 0, &[5, 0, 0, 0])]).as_deref(), Some("the shaft is at rest"));
        assert_eq!(unmet(&TURNING_SHAFT, &[]).as_deref(), Some("the device has no position"));
    }

    /// A device that stores a preset at once keeps it over a reset: the tester writes it only if the user allows that.
    #[test]
    fn a_preset_that_is_stored_at_once_needs_leave() {
        use crate::bench::{Options, Target};
        use crate::need::tests::asked;
        use crate::scripted::dictionary;
        use canvass_device::models::Model;
        let met = |model: &str, allow: &[Touch]| {
            let target = Target {
                model: model.to_owned(),
                ..Target::unknown(canvass_analyzer::NodeId::new(crate::scripted::NODE).unwrap())
            };
            let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
            asked(&VOLATILE_PRESET, dictionary(Vec::new()), &target, &options).err().map(|stop| stop.reason().actual)
        };
        let stores = Model::all().iter().find(|model| model.sheet().storage.persist_at_once.contains(&PRESET)).unwrap();
        let lacking = met(stores.id(), &[Touch::NodeId]);
        let expected = "the device stores a preset immediately, and writing non-volatile memory is not allowed";
        assert_eq!(lacking.as_deref(), Some(expected));
        assert_eq!((met(stores.id(), &[Touch::Nvm]), met("reference-406", &[]), met("", &[])), (None, None, None));
    }

    /// A shaft turns if its position differs after a tenth of a second, in either direction, by more than it trembles;
    /// a draw-wire encoder has its length instead.
    #[test]
    fn a_shaft_turns_by_more_than_it_trembles() {
        use crate::scripted::{dictionary, frame, with_bench};
        use canvass_traces::Frame;
        let turns = |index: &'static str, first: u8, second: u8| {
            let (mut others, mut asked) = (dictionary(Vec::new()), 0);
            let script = move |request: &Frame| {
                if !request.to_string().starts_with(&format!("63F#40{index}")) {
                    return others(request);
                }
                // First the tester asks whether the object exists, twice in the case of the position.
                asked += 1;
                let last = if index == "046000" { 4 } else { 3 };
                let value = if asked < last { first } else { second };
                vec![(Duration::from_millis(1), frame(&format!("5BF#43{index}{value:02X}000000")))]
            };
            with_bench(script, |bench| (TURNING_SHAFT.check(bench).unwrap().is_ok(), bench.now()))
        };
        for index in ["046000", "206000"] {
            let found = [(10, 14), (10, 15), (14, 10), (15, 10)].map(|(first, second)| turns(index, first, second).0);
            assert_eq!(found, [false, true, false, true], "{index}");
        }
        assert_eq!(turns("046000", 1, 1).1, canvass_traces::Timestamp::ZERO + Duration::from_millis(104));
    }
}
