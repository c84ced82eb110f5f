//! Rows as messages in an MCAP file that is a ROS 2 bag.
//!
//! For each board and row one `pressure_state`, also where the board gave no answer: then its
//! pressures are NaN, and its command stands. Valves' drives and the supply pressure, where they
//! are recorded, stand behind the commands; the supply is also a `supply_pressure`, and an IMU's
//! readings an `imu`, in ROS's own messages. A `pressure_command` wherever a command changes, so
//! that a bag can be played to a node; a line of `events` for whatever happens. Messages are in
//! CDR, schemas in `ros2msg`: nothing else may be in the file, or readers of ROS bags refuse it. So
//! what the recording says of itself is a metadata record.
//!
//! A chunk is finished with each block, so the file can be read to its end by a streaming reader at
//! any time; the indexes that others need come with the end of the recording.

mod metadata;
mod pipe;
mod topics;

pub(super) use metadata::DESCRIPTION as METADATA;

use super::codes::Codes;
use super::format::Form;
use super::recorder::RecordedBus;
use super::rows::{Batch, RecordedEvent};
use crate::messages::{JointState, Log, Time};
use crate::{Description, PageColumns, RecorderOptions};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use metadata::Extent;
use pipe::Pipe;
use pneudrive_host::Calibration;
use pneudrive_protocol::pages::Drives;
use pneudrive_protocol::{CHANNELS, SensorScale};
use serde::Serialize;
use std::io;
use topics::{BoardTopics, Channel, Topic};

/// A bag in the making.
pub(super) struct Bag {
    file_name: String,
    writer: Writer<NoSeek<Pipe>>,
    pipe: Pipe,
    buses: Vec<Bus>,
    events: Channel<Log>,
    extent: Extent,
    buffer: Vec<u8>,
    pages: PageColumns,
    /// Of the atmosphere, kPa absolute.
    ambient_kpa: f64,
}

struct Bus {
    unix_offset_ns: u64,
    /// kPa of each code, as a command.
    command_kpa: Codes<f64>,
    /// kPa of each code, as a reading.
    kpa: Codes<f64>,
    boards: Vec<BoardTopics>,
}

impl Bag {
    /// Topics are `{prefix}/joint_{n}/...`.
    pub(super) fn new(
        file_name: &str,
        prefix: &str,
        buses: &[RecordedBus],
        calibration: &Calibration,
        description: &Description,
        recorder: &RecorderOptions,
    ) -> io::Result<Self> {
        let pipe = Pipe::default();
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("pneudrive-host/", env!("CARGO_PKG_VERSION")))
            // Blocks end chunks.
            .chunk_size(None)
            .compression_threads(0)
            .disable_seeking(true);
        let mut writer = Writer::with_options(NoSeek::new(pipe.clone()), options).map_err(explain)?;
        let events = topics::add_events(&mut writer, prefix).map_err(explain)?;
        let buses: Vec<_> = buses
            .iter()
            .enumerate()
            .map(|(index, bus)| {
                let boards = bus.boards.iter().map(|&board| {
                    let names = topics::names(description, board);
                    let joint = bus.first_joint + u16::from(board);
                    BoardTopics::add(&mut writer, prefix, joint, index, &names, recorder.pages)
                });
                let boards = boards.collect::<Result<_, _>>().map_err(explain)?;
                let command_kpa = Codes::new(&bus.boards, calibration, SensorScale::command_kpa);
                let kpa = Codes::new(&bus.boards, calibration, SensorScale::kpa);
                Ok(Bus { unix_offset_ns: bus.unix_offset_ns, command_kpa, kpa, boards })
            })
            .collect::<io::Result<_>>()?;
        writer.write_metadata(&metadata::description(description)).map_err(explain)?;
        let (extent, buffer) = (Extent::default(), Vec::new());
        let ambient_kpa = recorder.ambient_kpa.unwrap_or(RecorderOptions::STANDARD_ATMOSPHERE_KPA);
        let (file_name, pages) = (file_name.to_owned(), recorder.pages);
        Ok(Self { file_name, writer, pipe, buses, events, extent, buffer, pages, ambient_kpa })
    }

    fn topics(&self) -> impl Iterator<Item = &Topic> {
        let boards = self.buses.iter().flat_map(|bus| &bus.boards);
        boards.flat_map(BoardTopics::all).chain([&self.events.topic])
    }

    fn metadata(&self) -> String {
        metadata::yaml(&self.file_name, &self.extent, self.topics())
    }
}

impl Form for Bag {
    fn add(&mut self, batch: &Batch) -> io::Result<()> {
        let offset_ns = self.buses.get(batch.bus).map_or(0, |bus| bus.unix_offset_ns);
        batch.events().try_for_each(|event| self.log(event, offset_ns))?;
        let Some(bus) = self.buses.get_mut(batch.bus) else { return Ok(()) };
        for (at_ns, samples) in batch.iter() {
            let log_ns = at_ns + bus.unix_offset_ns;
            // A board that gave no answer was asked, if at all, after the one before it.
            let mut stamp_ns = at_ns;
            for (index, (topics, sample)) in bus.boards.iter_mut().zip(samples).enumerate() {
                let kpa = |channel, counts| *bus.kpa.get(index, channel, counts);
                let command: [f64; CHANNELS] = std::array::from_fn(|channel| {
                    *bus.command_kpa.get(index, channel, sample.command[channel])
                });
                stamp_ns = sample.answer.map_or(stamp_ns, |answer| answer.asked_ns);
                let stamp = Time::from_unix_ns(stamp_ns + bus.unix_offset_ns);
                if topics.last_command != Some(sample.command) {
                    topics.last_command = Some(sample.command);
                    topics.command.message.fill(stamp, command);
                    topics.command.write(&mut self.writer, log_ns, &mut self.buffer)?;
                    self.extent.add(log_ns);
                }
                let pressures: [f64; CHANNELS] = sample.answer.map_or([f64::NAN; CHANNELS], |answer| {
                    std::array::from_fn(|channel| kpa(channel, answer.pressures[channel]))
                });
                // NaN where the board was not asked for them in this cycle.
                let drives = sample.drives.map_or([f64::NAN; CHANNELS], Drives::share);
                let drives = drives.into_iter().take(if self.pages.drives { CHANNELS } else { 0 });
                let electronics = sample.electronics;
                let sensors = [
                    sample.supply.map(|supply| supply.kpa),
                    electronics.and_then(|electronics| electronics.chip_c),
                    electronics.and_then(|electronics| electronics.rail_v),
                ];
                let sensors = sensors.map(|value| value.unwrap_or(f64::NAN)).into_iter();
                let sensors = sensors.take(if self.pages.sensors { JointState::SENSORS.len() } else { 0 });
                topics
                    .state
                    .message
                    .fill(stamp, pressures.into_iter().chain(command).chain(drives).chain(sensors));
                topics.state.write(&mut self.writer, log_ns, &mut self.buffer)?;
                self.extent.add(log_ns);
                let dated = |at_ns: u64| Time::from_unix_ns(at_ns + bus.unix_offset_ns);
                if let (Some(topic), Some(supply)) = (&mut topics.supply, sample.supply) {
                    topic.message.fill(dated(supply.measured_ns), supply.kpa, self.ambient_kpa);
                    topic.write(&mut self.writer, log_ns, &mut self.buffer)?;
                    self.extent.add(log_ns);
                }
                if let (Some(topic), Some(motion)) = (&mut topics.imu, sample.motion) {
                    let (acceleration, rate) = (motion.acceleration_m_s2, motion.angular_rate_rad_s);
                    topic.message.fill(dated(motion.asked_ns), acceleration, rate);
                    topic.write(&mut self.writer, log_ns, &mut self.buffer)?;
                    self.extent.add(log_ns);
                }
            }
        }
        Ok(())
    }

    fn happened(&mut self, event: &RecordedEvent) -> io::Result<()> {
        // Events from elsewhere are dated by the clock that all lines have.
        let offset_ns = self.buses.first().map_or(0, |bus| bus.unix_offset_ns);
        self.log(event, offset_ns)
    }

    fn waiting(&self) -> usize {
        // A chunk grows inside the writer; what counts is that blocks end in time, not how long
        // they are.
        self.pipe.waiting()
    }

    fn block(&mut self) -> io::Result<Vec<u8>> {
        self.writer.flush().map_err(explain)?;
        Ok(self.pipe.take())
    }

    fn end(&mut self) -> io::Result<Vec<u8>> {
        let record = metadata::record(self.metadata());
        self.writer.write_metadata(&record).map_err(explain)?;
        self.writer.finish().map_err(explain)?;
        Ok(self.pipe.take())
    }

    fn companion(&self) -> Option<(&'static str, String)> {
        Some((metadata::FILE_NAME, self.metadata()))
    }
}

impl Bag {
    /// Writes an event, whose time becomes one of the calendar by `offset_ns`.
    fn log(&mut self, event: &RecordedEvent, offset_ns: u64) -> io::Result<()> {
        let at_ns = event.at_ns + offset_ns;
        let notice = &event.notice;
        let message = &mut self.events.message;
        message.stamp = Time::from_unix_ns(at_ns);
        message.level = if notice.kind.is_warning() { Log::WARN } else { Log::INFO };
        message.msg.clone_from(&notice.text);
        message.function = notice.kind.name().to_owned();
        self.extent.add(at_ns);
        self.events.write(&mut self.writer, at_ns, &mut self.buffer)
    }
}

impl<M: Serialize> Channel<M> {
    fn write(
        &mut self,
        writer: &mut Writer<NoSeek<Pipe>>,
        log_ns: u64,
        buffer: &mut Vec<u8>,
    ) -> io::Result<()> {
        /// XCDR1, little endian (OMG DDSI-RTPS 2.5, 10.2).
        const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];
        buffer.clear();
        buffer.extend_from_slice(&ENCAPSULATION);
        cdr_encoding::to_writer::<_, byteorder::LittleEndian, _>(&mut *buffer, &self.message)
            .map_err(io::Error::other)?;
        let header = MessageHeader {
            channel_id: self.topic.id,
            sequence: self.topic.count as u32,
            log_time: log_ns,
            publish_time: log_ns,
        };
        writer.write_to_known_channel(&header, buffer).map_err(explain)?;
        self.topic.count += 1;
        Ok(())
    }
}

fn explain(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
