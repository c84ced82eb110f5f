//! A PneuDrive board's behaviour without its hardware (no_std).
#![no_std]
