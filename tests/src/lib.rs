//! End-to-end tests of PneuDrive.
