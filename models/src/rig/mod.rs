//! The rig description.
