//! Bus master for PneuDrive boards: library and command line.
