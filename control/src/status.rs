use crate::{BoardState, Micros, SensorFault, ValveDrive};
use pneudrive_protocol::{CHANNELS, Counts, FrameStatistics};

/// What a channel did in the last control step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ChannelStatus {
    /// The valve follows the control law.
    Regulating,
    /// The valve vents because the whole board does ([`BoardState`]).
    Venting,
    /// The valve vents because the sensor cannot be believed; the answer carries
    /// [`SensorFault::reported`].
    SensorFault(SensorFault),
    /// The channel is not in use; its valve vents.
    Disabled,
}

/// What has happened since power-up. All counters stop at their largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Valid requests to this board with commands.
    pub requests: u32,
    /// Answers to them. Fewer than requests only if a request came before the first control step.
    pub answers: u32,
    /// Page requests to this board.
    pub page_requests: u32,
    /// Bytes the receiver flagged as damaged.
    pub line_errors: u32,
    /// Packets with this board's address whose CRC did not fit: damaged, repeated, or of another
    /// host.
    pub damaged_requests: u32,
    /// Packets on the bus (anybody's), and bytes that belonged to none.
    pub frames: FrameStatistics,
    /// Control steps.
    pub steps: u32,
    /// Control steps that came more than one and a half loop periods after the one before.
    pub late_steps: u32,
    /// Times that the host fell silent for the command timeout.
    pub command_timeouts: u32,
    /// Sensor faults, all channels together.
    pub sensor_faults: u32,
}

/// What the last control step did, and what has happened in the control loop since power-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ControlStatus {
    /// See [`BoardStatus::state`].
    pub state: BoardState,
    /// See [`BoardStatus::channels`].
    pub channels: [ChannelStatus; CHANNELS],
    /// See [`BoardStatus::pressures`].
    pub pressures: [Counts; CHANNELS],
    /// Drives of the four valves until the next step.
    pub drives: [ValveDrive; CHANNELS],
    /// The longest time from one step to the next; zero before the second.
    pub longest_interval: Micros,
    /// See [`Counters::steps`].
    pub steps: u32,
    /// See [`Counters::late_steps`].
    pub late_steps: u32,
    /// See [`Counters::command_timeouts`].
    pub command_timeouts: u32,
    /// See [`Counters::sensor_faults`].
    pub sensor_faults: u32,
}

/// A board at a glance, for logs and tests. On the bus it is in pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardStatus {
    /// What the board as a whole does, as of the last control step.
    pub state: BoardState,
    /// What each channel did in the last control step.
    pub channels: [ChannelStatus; CHANNELS],
    /// Set points.
    pub commands: [Counts; CHANNELS],
    /// What the next answer carries: filtered pressures, or [`SensorFault::reported`].
    pub pressures: [Counts; CHANNELS],
    /// What has happened since power-up.
    pub counters: Counters,
}
