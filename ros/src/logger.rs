/// Warnings and errors go to standard error. Those of the DDS library at most as errors: it warns of every peer that comes or goes.
struct StandardError;

impl log::Log for StandardError {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        let ours = metadata.target().starts_with("pneudrive");
        // Asking for matched peers before there are any is an "error" to it.
        let noisy = metadata.target().starts_with("ros2_client::node");
        metadata.level() <= if ours { log::Level::Info } else { log::Level::Error } && !noisy
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            eprintln!("{}: {}", record.level().as_str().to_lowercase(), record.args());
        }
    }

    fn flush(&self) {}
}

pub fn install() {
    if log::set_logger(&StandardError).is_ok() {
        log::set_max_level(log::LevelFilter::Info);
    }
}
