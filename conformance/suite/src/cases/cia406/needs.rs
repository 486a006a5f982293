//! What the cases of CiA 406 need: what an encoder has, and what Kübler's encoders have beside it.

use crate::bench::Bench;
use crate::bench::Met;
use crate::bench::objects::TPDO_FIRST_ENTRY;
use crate::bench::sdo::number;
use crate::need::Need;
use crate::touch::Touch;
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_traces::Duration;

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
const POSITION: Multiplexer = Multiplexer::new(0x6004, 0);
const LENGTH: Multiplexer = Multiplexer::new(0x6020, 0);
const PRESET: Multiplexer = Multiplexer::new(0x6003, 0);
const VENDOR_ID: Multiplexer = Multiplexer::new(object::IDENTITY, 1);
const KUEBLER: u32 = 0x13;

/// A shaft at rest trembles by so many units.
const TREMBLE: u32 = 4;

/// The device is an encoder (CiA 406).
pub static ENCODER: Need = Need::new("encoder", "an encoder of CiA 406 with a position (6004h)", |bench| {
    let profile = number(&bench.upload(DEVICE_TYPE)?.value()?) & 0xFFFF;
    if profile != 406 {
        return Ok(Err(format!("1000h names profile {profile}")));
    }
    bench.has_all(&[POSITION])
});

/// A preset (6003h) that a reset takes back, unless `--allow nvm` was given. A device that stores a preset at once wears
/// its memory, and keeps a position that is not its own if the run ends in the middle.
pub static VOLATILE_PRESET: Need =
    Need::new("volatile-preset", "a preset that is not stored at once (or --allow nvm)", |bench| {
        let may_store = bench.options().allow.contains(&Touch::Nvm);
        Ok(match keeps_presets(bench) && !may_store {
            true => Err(format!("the device stores a preset at once: say --allow {}", Touch::Nvm)),
            false => Ok(()),
        })
    });

/// Whether the device stores a preset as soon as it is written, as its manual says.
pub(super) fn keeps_presets(bench: &Bench<'_>) -> bool {
    bench.manual().is_some_and(|model| model.sheet().storage.persist_at_once.contains(&PRESET))
}

/// A work area: 6400h, 6401h and 6402h.
pub static WORK_AREA: Need = Need::new("work-area", "a work area (6400h to 6402h)", |bench| {
    all(bench, &[(0x6400, 1), (0x6401, 1), (0x6402, 1)])
});

/// Alarms and warnings: 6503h to 6506h.
pub static ALARMS: Need = Need::new("alarms", "alarms and warnings (6503h to 6506h)", |bench| {
    all(bench, &[(0x6503, 0), (0x6504, 0), (0x6505, 0), (0x6506, 0)])
});

/// The temperature limits of Kübler's Sendix encoders, 2120h.
pub static TEMPERATURE_LIMIT: Need =
    Need::new("temperature-limit", "temperature limits of Kübler's Sendix encoders (2120h)", |bench| {
        of_kuebler(bench, &[(0x2120, 2), (0x2120, 3), (0x6505, 0)])
    });

/// The raw position 600Ch.
pub static RAW_POSITION: Need = Need::new("raw-position", "a raw position (600Ch)", |bench| all(bench, &[(0x600C, 0)]));

/// The raw position of Kübler's Sendix encoders with its inverse and checksum, 2160h to 2162h.
pub static RAW_DATA: Need =
    Need::new("raw-data", "the raw position of Kübler's Sendix encoders with its checksum (2160h to 2162h)", |bench| {
        of_kuebler(bench, &[(0x2160, 0), (0x2161, 0), (0x2162, 0)])
    });

/// The speed 6030h.
pub static SPEED: Need = Need::new("speed", "a speed (6030h)", |bench| all(bench, &[(0x6030, 1)]));

/// The speed 6030h with its parameters 6031h.
pub static SPEED_PARAMETERS: Need = Need::new("speed-parameters", "a speed with parameters (6030h, 6031h)", |bench| {
    all(bench, &[(0x6030, 1), (0x6031, 4)])
});

/// The acceleration 6040h.
pub static ACCELERATION: Need =
    Need::new("acceleration", "an acceleration (6040h)", |bench| all(bench, &[(0x6030, 1), (0x6040, 1)]));

/// The jerk 6050h, with the acceleration 6040h.
pub static JERK: Need =
    Need::new("jerk", "a jerk (6050h) and an acceleration (6040h)", |bench| all(bench, &[(0x6040, 1), (0x6050, 1)]));

/// Cams: 6300h, 6301h, 6302h, 6310h and 6320h.
pub static CAMS: Need = Need::new("cams", "cams (6300h to 6302h, 6310h, 6320h)", |bench| {
    all(bench, &[(0x6300, 1), (0x6301, 1), (0x6302, 1), (0x6310, 1), (0x6320, 1)])
});

/// The position in 64 bits, 6008h.
pub static HIGH_PRECISION: Need =
    Need::new("high-precision", "a position in 64 bits (6008h)", |bench| all(bench, &[(0x6008, 0)]));

/// The shaft turns, or the wire moves, while the case runs. One that rests now may turn in the next case.
pub static TURNING_SHAFT: Need = Need::new("turning-shaft", "a shaft that turns while the case runs", |bench| {
    let at = if bench.has(POSITION)? { POSITION } else { LENGTH };
    if !bench.has(at)? {
        return Ok(Err("the device has no position".to_owned()));
    }
    let first = bench.read_number(at)?;
    bench.listen(Duration::from_millis(100))?;
    let second = bench.read_number(at)?;
    Ok(if first.abs_diff(second) > TREMBLE { Ok(()) } else { Err("the shaft is at rest".to_owned()) })
})
.fleeting();

/// Two redundant channels of the position in TPDO 1: 6020h twice in 1A00h.
pub static REDUNDANT_CHANNELS: Need =
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
pub static INCLINOMETER: Need =
    Need::new("inclinometer", "the inclinometer of Kübler's draw-wire encoders (3003h to 3010h, 5000h)", |bench| {
        of_kuebler(bench, &[(0x3003, 0), (0x3004, 0), (0x3005, 0), (0x3010, 0), (0x5000, 0)])
    });

fn all(bench: &mut Bench<'_>, objects: &[(u16, u8)]) -> Result<Met, Stop> {
    let objects: Vec<Multiplexer> = objects.iter().map(|&(index, sub)| Multiplexer::new(index, sub)).collect();
    bench.has_all(&objects)
}

/// Objects in the manufacturer's area mean something only with the vendor-ID.
fn of_kuebler(bench: &mut Bench<'_>, objects: &[(u16, u8)]) -> Result<Met, Stop> {
    if !bench.has(VENDOR_ID)? || bench.read_number(VENDOR_ID)? != KUEBLER {
        return Ok(Err("the device is not one of Kübler's".to_owned()));
    }
    all(bench, objects)
}
