//! PneuDrive's bus: packets, addresses, units, framing and wire times (no_std).
#![no_std]
