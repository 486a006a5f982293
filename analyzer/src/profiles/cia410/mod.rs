//! CiA 410: inclinometers. Only the error codes are known here.
//!
//! Sources: the manuals of ifm JN2101 and of Sick TMM61 (table 39), which agree.

use crate::dictionary::names::ErrorCodes;

inventory::submit! { ErrorCodes { profile: 410, codes: CODES } }

const CODES: &[(u16, &str)] = &[(0x5010, "sensor error, X axis"), (0x5020, "sensor error, Y axis")];
