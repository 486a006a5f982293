//! CiA 401: input and output modules. Only the error codes are known here.
//!
//! Sources: `CO_Emergency.h` of CANopenNode (Apache-2.0), whose names mark the codes of CiA 401; the manuals of Festo
//! CPX-E-CEC (2018-09, table 20) agree.

use crate::dictionary::names::ErrorCodes;

inventory::submit! { ErrorCodes { profile: 401, codes: CODES } }

const CODES: &[(u16, &str)] = &[
    (0x2310, "current at outputs too high"),
    (0x2320, "short circuit at outputs"),
    (0x2330, "load dump at outputs"),
    (0x3110, "input voltage too high"),
    (0x3120, "input voltage too low"),
    (0x3210, "internal voltage too high"),
    (0x3220, "internal voltage too low"),
    (0x3310, "output voltage too high"),
    (0x3320, "output voltage too low"),
];
