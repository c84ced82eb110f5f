//! The plant as the boards see it.

use super::ageing::{Ageing, Condition};
use super::drive::{DriveChain, SpoolStep};
use super::effects::{Effect, resolve};
use super::error::PlantError;
use super::id::{CHANNELS_PER_BOARD, ChannelId};
use super::integrator::{Dynamics, Integrator, Openings};
use super::noise::{Purpose, stream};
use super::parameters::PlantParameters;
use super::sensor::Sensor;
use super::supply::{Source, Supply};
use super::truth::ChannelTruth;
use super::valve::Valve;

/// The rig behind the boards: supply, valves, chambers, joints and sensors, advanced on a fixed
/// grid.
///
/// The grid's points are multiples of `step_ns`. What is set or asked between two points acts or is
/// answered as at the point before, so that results depend on the drives and their grid points
/// alone, not on how the calls are spaced. Two plants of the same parameters, effects and seed that
/// get the same calls give the same bits.
#[derive(Debug, Clone)]
pub struct Plant {
    integrator: Integrator,
    channels: Vec<Channel>,
    openings: Vec<Openings>,
    supply: Supply,
    source: Source,
    ambient_pa: f64,
    step_ns: u64,
    steps: u64,
    /// Charge on each board's converter capacitor, V.
    held_v: Vec<f64>,
}

/// Everything of a channel that is not integrated.
#[derive(Debug, Clone)]
struct Channel {
    drive: f64,
    chain: DriveChain,
    valve: Valve,
    ageing: Option<Ageing>,
    leak: f64,
    sensor: Sensor,
    /// Spool positions the current openings were computed for.
    spool: SpoolStep,
}

impl Plant {
    /// A plant at rest at time zero, all drives 0.
    ///
    /// # Errors
    /// A parameter or effect outside its range, an effect where there is no channel, a volume too
    /// fast for the step.
    pub fn new(parameters: PlantParameters, effects: &[Effect], seed: u64) -> Result<Self, PlantError> {
        parameters.validate()?;
        let resolved = resolve(&parameters, effects, seed)?;
        let step_s = 1e-9 * parameters.step_ns as f64;
        resolved.check_step(step_s)?;

        let ambient_pa = parameters.ambient_pa();
        let mut supply = Supply::new(resolved.supply, seed);
        let dynamics = Dynamics {
            chambers: resolved.channels.iter().map(|c| c.chamber.clone()).collect(),
            joints: resolved.joints,
            supply_line: supply.physics.line,
            relay: supply.physics.relay,
            ambient_k: parameters.ambient.temperature_k,
        };
        let level = supply.physics.nominal_pa + supply.physics.level_pa;
        let source = supply.source(0.0, parameters.ambient.temperature_k, level);
        let initial_pa = 1e3 * parameters.chamber.initial_kpa;
        let integrator = Integrator::new(dynamics, step_s, source.pressure_pa, ambient_pa + initial_pa);
        let channels: Vec<Channel> = resolved
            .channels
            .iter()
            .enumerate()
            .map(|(place, physics)| Channel {
                drive: 0.0,
                chain: DriveChain::new(&physics.drive, step_s),
                valve: Valve::new(&physics.valve),
                ageing: Ageing::new(&physics.ageing, step_s, stream(seed, Purpose::Water, place)),
                leak: physics.chamber.exhaust_leak,
                sensor: Sensor::new(&physics.sensor, step_s, initial_pa, seed, place),
                spool: SpoolStep::default(),
            })
            .collect();
        let openings = channels.iter().map(Channel::openings_at_rest).collect();
        let boards = channels.len().div_ceil(CHANNELS_PER_BOARD);
        Ok(Self {
            integrator,
            channels,
            openings,
            supply,
            source,
            ambient_pa,
            step_ns: parameters.step_ns,
            steps: 0,
            held_v: vec![super::sensor::kpa_to_volts(0.0); boards],
        })
    }

    /// Channels of the rig.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Boards of the rig; the last one may have fewer than four channels.
    #[must_use]
    pub fn boards(&self) -> usize {
        self.held_v.len()
    }

    /// The grid point the plant has reached, ns.
    #[must_use]
    pub fn time_ns(&self) -> u64 {
        self.steps * self.step_ns
    }

    /// Integrates to the last grid point at or before `time_ns`. A time already passed changes
    /// nothing.
    pub fn advance_to(&mut self, time_ns: u64) {
        let target = time_ns / self.step_ns;
        while self.steps < target {
            self.step();
        }
    }

    fn step(&mut self) {
        let step_s = 1e-9 * self.step_ns as f64;
        let start_s = self.steps as f64 * step_s;
        let ambient_k = self.integrator.dynamics().ambient_k;
        self.source = self.supply.source(start_s + 0.5 * step_s, ambient_k, self.integrator.tank_pa());
        for place in 0..self.channels.len() {
            let neighbour = self.neighbour_drive(place);
            let gas = self.integrator.gas(place);
            let channel = &mut self.channels[place];
            channel.step(&mut self.openings[place], neighbour, start_s, gas.chamber_pa - self.ambient_pa);
        }
        let lagging = self.channels.iter().any(|c| c.sensor.lags());
        if !lagging {
            self.integrator.step(&self.openings, &self.source);
        } else {
            let before: Vec<f64> = (0..self.channels.len()).map(|c| self.port_gauge_pa(c)).collect();
            self.integrator.step(&self.openings, &self.source);
            for (place, before) in before.into_iter().enumerate() {
                let after = self.port_gauge_pa(place);
                self.channels[place].sensor.follow(before, after);
            }
        }
        self.steps += 1;
    }

    /// Drive of the channel before this one on the same board (the last one's, for the first).
    fn neighbour_drive(&self, place: usize) -> f64 {
        let board = place - place % CHANNELS_PER_BOARD;
        let on_board = (self.channels.len() - board).min(CHANNELS_PER_BOARD);
        let before = board + (place - board + on_board - 1) % on_board;
        if before == place { 0.0 } else { self.channels[before].drive }
    }

    fn port_gauge_pa(&self, place: usize) -> f64 {
        let gas = self.integrator.gas(place);
        self.integrator.dynamics().chambers[place].port_pa(&gas) - self.ambient_pa
    }

    /// Sets a valve's drive from now on: -1 (full vent) to 1 (full fill), the duty with the
    /// direction's sign.
    ///
    /// # Errors
    /// No such channel, or `drive` is not a number from -1 to 1.
    pub fn set_drive(&mut self, channel: ChannelId, drive: f64) -> Result<(), PlantError> {
        let place = self.place(channel)?;
        if !(-1.0..=1.0).contains(&drive) {
            return Err(PlantError::Drive { channel, value: drive });
        }
        self.channels[place].drive = drive;
        Ok(())
    }

    /// Converts the four channels of a board one after the other, as its loop does once a cycle:
    /// 12-bit counts.
    ///
    /// Noise, crosstalk between consecutive conversions and stale results happen here and nowhere
    /// else, so call it once per board loop. Channels the rig does not have read 0 kPa without
    /// noise.
    ///
    /// # Errors
    /// No such board.
    pub fn sample(&mut self, board: u8) -> Result<[u16; CHANNELS_PER_BOARD], PlantError> {
        let index = usize::from(board);
        if index >= self.boards() {
            return Err(PlantError::NoSuchBoard { board, boards: self.boards() });
        }
        let time_s = 1e-9 * self.time_ns() as f64;
        let mut counts = [super::sensor::convert(super::sensor::kpa_to_volts(0.0), 12); CHANNELS_PER_BOARD];
        for (on_board, counts) in counts.iter_mut().enumerate() {
            let place = index * CHANNELS_PER_BOARD + on_board;
            if place >= self.channels.len() {
                break;
            }
            let gauge = self.port_gauge_pa(place);
            let sensor = &mut self.channels[place].sensor;
            self.held_v[index] = sensor.sample(gauge, time_s, self.held_v[index]);
            *counts = sensor.counts12();
        }
        Ok(counts)
    }

    /// Sensor voltage at the converter in the last [`Plant::sample`], V.
    ///
    /// # Errors
    /// No such channel.
    pub fn adc_volts(&self, channel: ChannelId) -> Result<f64, PlantError> {
        Ok(self.channels[self.place(channel)?].sensor.volts())
    }

    /// 12-bit counts of the last [`Plant::sample`].
    ///
    /// # Errors
    /// No such channel.
    pub fn adc_counts12(&self, channel: ChannelId) -> Result<u16, PlantError> {
        Ok(self.channels[self.place(channel)?].sensor.counts12())
    }

    /// The true state of a channel.
    ///
    /// # Errors
    /// No such channel.
    pub fn truth(&self, channel: ChannelId) -> Result<ChannelTruth, PlantError> {
        let place = self.place(channel)?;
        let own = &self.channels[place];
        let gas = self.integrator.gas(place);
        let chamber = &self.integrator.dynamics().chambers[place];
        let surroundings = self.integrator.surroundings_now(place, &self.openings[place], &self.source);
        let (_, flows) = chamber.rates(&gas, &surroundings);
        let volume_m3 = chamber.volume(gas.chamber_pa, gas.creep, surroundings.angle);
        Ok(ChannelTruth {
            pressure_pa: gas.chamber_pa,
            port_pa: chamber.port_pa(&gas),
            temperature_k: chamber.temperature(&gas, volume_m3),
            mass_kg: chamber.mass(&gas, volume_m3),
            volume_m3,
            drive: own.drive,
            spool: own.chain.spool(),
            fill_kg_per_s: flows.fill,
            vent_kg_per_s: flows.vent,
            leak_kg_per_s: flows.leak,
        })
    }

    /// Bending angles `q_u`, `q_v` of a board's joint, rad; 0 when it is locked.
    ///
    /// # Errors
    /// No such board.
    pub fn joint_angles(&self, board: u8) -> Result<[f64; 2], PlantError> {
        let index = usize::from(board);
        if index >= self.boards() {
            return Err(PlantError::NoSuchBoard { board, boards: self.boards() });
        }
        Ok(self.integrator.angles(index))
    }

    /// Rates of a board's bending angles, rad/s; 0 when its joint is locked.
    ///
    /// # Errors
    /// No such board.
    pub fn joint_rates(&self, board: u8) -> Result<[f64; 2], PlantError> {
        let index = usize::from(board);
        if index >= self.boards() {
            return Err(PlantError::NoSuchBoard { board, boards: self.boards() });
        }
        Ok(self.integrator.angular_rates(index))
    }

    /// Absolute pressure the valves draw from, Pa: behind the supply line, if there is one.
    #[must_use]
    pub fn supply_pressure_pa(&self) -> f64 {
        self.integrator.manifold_pa(&self.source)
    }

    /// Absolute ambient pressure, Pa.
    #[must_use]
    pub fn ambient_pressure_pa(&self) -> f64 {
        self.ambient_pa
    }

    fn place(&self, channel: ChannelId) -> Result<usize, PlantError> {
        let channels = self.channels.len();
        channel.index().filter(|&i| i < channels).ok_or(PlantError::NoSuchChannel { channel, channels })
    }
}

impl Channel {
    fn openings_at_rest(&self) -> Openings {
        Openings { valve: [self.valve.conductances(0.0, 1.0); 3], leak: self.leak }
    }

    /// Moves the spool over one step and sets the openings the integrator uses for it.
    #[inline]
    fn step(&mut self, openings: &mut Openings, neighbour: f64, time_s: f64, chamber_gauge_pa: f64) {
        let spool = self.chain.step(self.drive, neighbour);
        if let Some(ageing) = &mut self.ageing {
            let condition = ageing.step(time_s, self.chain.coil(), chamber_gauge_pa);
            self.set_openings(openings, spool, condition);
        } else if spool != self.spool {
            self.set_openings(openings, spool, Condition::NEW);
        }
        self.spool = spool;
    }

    fn set_openings(&self, openings: &mut Openings, spool: SpoolStep, condition: Condition) {
        let at = |x: f64| {
            let mut c = self.valve.conductances(x, condition.gain);
            c.fill *= condition.passage;
            c.vent *= condition.passage;
            c
        };
        let start = at(spool.start);
        let moving = spool.start.total_cmp(&spool.end).is_ne();
        openings.valve = if moving { [start, at(spool.middle), at(spool.end)] } else { [start; 3] };
        openings.leak = self.leak + condition.crack;
    }
}
