//! The RP2040 as far as PneuDrive's firmware uses it, in virtual time.
