/// A number on page 1; the discriminant is its entry. All stop at their largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Counter {
    /// Valid requests to this board with commands.
    Requests = 0,
    /// Answers to them.
    Answers = 1,
    /// Page requests to this board.
    PageRequests = 2,
    /// Bytes that the receiver flagged as damaged.
    LineErrors = 3,
    /// Valid packets on the bus, anybody's.
    Packets = 4,
    /// Bytes on the bus that belonged to no valid packet.
    DiscardedBytes = 5,
    /// Control steps.
    Steps = 6,
    /// Control steps that came more than one and a half loop periods after the one before.
    LateSteps = 7,
    /// The longest time from one control step to the next, us.
    LongestIntervalUs = 8,
    /// The longest time from the start of a loop (before the sensors are read) to its valve pins,
    /// us; 0 where it is not measured.
    LongestLoopUs = 9,
    /// Times that the host fell silent for the command timeout.
    CommandTimeouts = 10,
    /// Sensor faults, all channels together.
    SensorFaults = 11,
    /// Time since the board's clock began, s.
    UptimeS = 12,
    /// Resets by the watchdog since power-on.
    WatchdogResets = 13,
    /// Packets with this board's address whose CRC did not fit: damaged, repeated, or of another
    /// host.
    DamagedRequests = 14,
    /// Packets whose CRC fitted nothing that this board knows: of other boards' sessions, or
    /// damaged.
    UnverifiedPackets = 15,
}

impl Counter {
    /// In the order of their entries.
    pub const ALL: [Self; 16] = [
        Self::Requests,
        Self::Answers,
        Self::PageRequests,
        Self::LineErrors,
        Self::Packets,
        Self::DiscardedBytes,
        Self::Steps,
        Self::LateSteps,
        Self::LongestIntervalUs,
        Self::LongestLoopUs,
        Self::CommandTimeouts,
        Self::SensorFaults,
        Self::UptimeS,
        Self::WatchdogResets,
        Self::DamagedRequests,
        Self::UnverifiedPackets,
    ];

    /// Its name in JSON: that of the variant, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Requests => "requests",
            Self::Answers => "answers",
            Self::PageRequests => "page_requests",
            Self::LineErrors => "line_errors",
            Self::Packets => "packets",
            Self::DiscardedBytes => "discarded_bytes",
            Self::Steps => "steps",
            Self::LateSteps => "late_steps",
            Self::LongestIntervalUs => "longest_interval_us",
            Self::LongestLoopUs => "longest_loop_us",
            Self::CommandTimeouts => "command_timeouts",
            Self::SensorFaults => "sensor_faults",
            Self::UptimeS => "uptime_s",
            Self::WatchdogResets => "watchdog_resets",
            Self::DamagedRequests => "damaged_requests",
            Self::UnverifiedPackets => "unverified_packets",
        }
    }

    /// The counter in this entry.
    pub fn of_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}
