//! The fields of SDO messages. A request and a response of the opposite service have the same fields.

use crate::wire::{Field, Layout};

const SPECIFIER: Field = Field::new("command specifier", 0, 5, 3);
const TOGGLE: Field = Field::new("toggle bit", 0, 4, 1);
const INDEX: Field = Field::new("index", 1, 0, 16);
const SUB_INDEX: Field = Field::new("sub-index", 3, 0, 8);
const SUBCOMMAND: Field = Field::new("subcommand", 0, 0, 2);
const CRC_SUPPORT: Field = Field::new("CRC support", 0, 2, 1);

/// Seven bytes of a value: download segment request, upload segment response.
pub(super) const SEGMENT: &[Field] = &[
    SPECIFIER,
    TOGGLE,
    Field::new("unused bytes", 0, 1, 3),
    Field::new("no more segments", 0, 0, 1),
    Field::new("data", 1, 0, 56),
];

/// The other side of a segment: upload segment request, download segment response.
pub(super) const TOGGLE_ONLY: &[Field] = &[SPECIFIER, TOGGLE, Field::reserved(0, 0, 4), Field::reserved(1, 0, 56)];

/// A value or its size: initiate download request, initiate upload response.
pub(super) const INITIATE: &[Field] = &[
    SPECIFIER,
    Field::reserved(0, 4, 1),
    Field::new("unused bytes", 0, 2, 2),
    Field::new("expedited", 0, 1, 1),
    Field::new("size indicator", 0, 0, 1),
    INDEX,
    SUB_INDEX,
    Field::new("data", 4, 0, 32),
];

/// An object without a value: initiate upload request, initiate download response.
pub(super) const OBJECT_ONLY: &[Field] =
    &[SPECIFIER, Field::reserved(0, 0, 5), INDEX, SUB_INDEX, Field::reserved(4, 0, 32)];

/// The size of a value: initiate block download request, initiate block upload response.
pub(super) const BLOCK_SIZE_STATED: &[Field] = &[
    SPECIFIER,
    Field::reserved(0, 3, 2),
    CRC_SUPPORT,
    Field::new("size indicator", 0, 1, 1),
    Field::new("subcommand", 0, 0, 1),
    INDEX,
    SUB_INDEX,
    Field::new("size", 4, 0, 32),
];

/// The receiver's side of an initiate block upload, with the protocol switch threshold.
pub(super) const BLOCK_REQUESTED: &[Field] = &[
    SPECIFIER,
    Field::reserved(0, 3, 2),
    CRC_SUPPORT,
    SUBCOMMAND,
    INDEX,
    SUB_INDEX,
    Field::new("block size", 4, 0, 8),
    Field::new("protocol switch threshold", 5, 0, 8),
    Field::reserved(6, 0, 16),
];

/// The receiver's side of an initiate block download.
pub(super) const BLOCK_ACCEPTED: &[Field] = &[
    SPECIFIER,
    Field::reserved(0, 3, 2),
    CRC_SUPPORT,
    SUBCOMMAND,
    INDEX,
    SUB_INDEX,
    Field::new("block size", 4, 0, 8),
    Field::reserved(5, 0, 24),
];

/// The confirmation of the segments of a block.
pub(super) const BLOCK_CONFIRMED: &[Field] = &[
    SPECIFIER,
    Field::reserved(0, 2, 3),
    SUBCOMMAND,
    Field::new("sequence number", 1, 0, 8),
    Field::new("block size", 2, 0, 8),
    Field::reserved(3, 0, 40),
];

/// The end of the data in a block transfer: end block download request, end block upload response.
pub(super) const BLOCK_ENDED: &[Field] = &[
    SPECIFIER,
    Field::new("unused bytes", 0, 2, 3),
    Field::reserved(0, 1, 1),
    Field::new("subcommand", 0, 0, 1),
    Field::new("CRC", 1, 0, 16),
    Field::reserved(3, 0, 40),
];

/// A command of a block transfer without parameters.
pub(super) const BLOCK_COMMAND: &[Field] =
    &[SPECIFIER, Field::reserved(0, 2, 3), SUBCOMMAND, Field::reserved(1, 0, 56)];

pub(super) static ABORT: Layout = Layout {
    name: "abort",
    fields: &[SPECIFIER, Field::reserved(0, 0, 5), INDEX, SUB_INDEX, Field::new("abort code", 4, 0, 32)],
};

pub(super) static UNKNOWN: Layout =
    Layout { name: "unknown", fields: &[Field::new("command", 0, 0, 8), Field::new("data", 1, 0, 56)] };
