//! What holds the project together: its arrows, its files, its documents.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod comment_width;
mod crate_arrows;
mod defect_table;
mod documentation;
mod module_cycles;
mod one_file_one_line;
mod test_files;
