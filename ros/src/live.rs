use std::sync::atomic::{AtomicU64, Ordering};

/// Settings that may change while the node runs. Times in ns; 0 switches off.
#[derive(Debug, Default)]
pub struct Live {
    max_command_age_ns: AtomicU64,
    command_timeout_ns: AtomicU64,
    publish_period_ns: AtomicU64,
}

impl Live {
    /// A stamp may lie this far from now, in either direction.
    pub fn max_command_age_ns(&self) -> u64 {
        self.max_command_age_ns.load(Ordering::Relaxed)
    }

    /// A joint without a valid command for so long is vented.
    pub fn command_timeout_ns(&self) -> u64 {
        self.command_timeout_ns.load(Ordering::Relaxed)
    }

    /// States are published at most this often.
    pub fn publish_period_ns(&self) -> u64 {
        self.publish_period_ns.load(Ordering::Relaxed)
    }

    /// Sets the parameter `name`, if it is one of these, from its value in the parameter's unit.
    pub fn set(&self, name: &str, value: f64) {
        let ns = |seconds: f64| (seconds * 1e9).round() as u64;
        match name {
            "max_command_age_s" => self.max_command_age_ns.store(ns(value), Ordering::Relaxed),
            "command_timeout_s" => self.command_timeout_ns.store(ns(value), Ordering::Relaxed),
            "publish_rate_hz" => self.publish_period_ns.store(ns(value.recip()), Ordering::Relaxed),
            _ => {}
        }
    }
}
