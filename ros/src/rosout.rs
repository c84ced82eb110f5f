//! `/rosout`: the node's log, for users who watch the logs of all nodes.

use crate::logger;
use crate::names::Names;
use pneudrive_record::messages::{Log, Time};
use ros2_client::Publisher;

/// Publishes what was logged since it last did.
///
/// Not the logger itself: lines come from the bus threads too, and these must not wait for DDS.
pub struct Rosout {
    publisher: Publisher<Log>,
    name: String,
}

impl Rosout {
    /// Of the node that has these names.
    pub fn new(publisher: Publisher<Log>, names: &Names) -> Self {
        Self { publisher, name: logger_name(&names.full()) }
    }

    /// Publishes what waits.
    pub fn publish(&self) {
        for line in logger::take() {
            let log = Log {
                stamp: Time::from_unix_ns(line.unix_ns),
                level: level(line.level),
                name: self.name.clone(),
                msg: line.text,
                file: line.file.to_owned(),
                function: String::new(),
                line: line.number,
            };
            // Who does not read it cannot stop the node.
            let _ = self.publisher.publish(log);
        }
    }
}

/// What ROS calls the logger of a node: `/arm/pneudrive` is `arm.pneudrive`.
fn logger_name(full_name: &str) -> String {
    full_name.trim_start_matches('/').replace('/', ".")
}

fn level(level: log::Level) -> u8 {
    /// Of `rcl_interfaces/msg/Log`.
    const ERROR: u8 = 40;
    match level {
        log::Level::Error => ERROR,
        log::Level::Warn => Log::WARN,
        _ => Log::INFO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loggers_are_called_as_in_other_nodes() {
        assert_eq!(logger_name("/arm/pneudrive"), "arm.pneudrive");
        assert_eq!(logger_name("/pneudrive"), "pneudrive");
    }
}
