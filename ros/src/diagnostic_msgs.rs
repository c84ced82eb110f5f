//! `diagnostic_msgs`, as far as the node sends them.

use pneudrive_record::messages::Header;
use serde::Serialize;

/// `diagnostic_msgs/msg/DiagnosticArray`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DiagnosticArray {
    /// When.
    pub header: Header,
    /// Of each part.
    pub status: Vec<DiagnosticStatus>,
}

/// `diagnostic_msgs/msg/DiagnosticStatus`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DiagnosticStatus {
    /// How bad it is.
    pub level: u8,
    /// Of what.
    pub name: String,
    /// In words.
    pub message: String,
    /// Which hardware.
    pub hardware_id: String,
    /// In numbers.
    pub values: Vec<KeyValue>,
}

/// `diagnostic_msgs/msg/KeyValue`
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct KeyValue {
    /// What.
    pub key: String,
    /// How much.
    pub value: String,
}

impl DiagnosticStatus {
    /// As it should be.
    pub const OK: u8 = 0;
    /// Worth a look.
    pub const WARN: u8 = 1;
    /// Out of order.
    pub const ERROR: u8 = 2;

    /// Adds a number.
    pub fn with(mut self, key: &str, value: impl ToString) -> Self {
        self.values.push(KeyValue { key: key.to_owned(), value: value.to_string() });
        self
    }
}
