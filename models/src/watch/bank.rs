//! The observers of one channel: the calibrated model, and one for each effect. Their innovations,
//! whitened, become blocks.

use super::block::{Block, Limiter};
use super::direction::{Direction, directions};
use super::observer::Observer;
use super::setup::Prepared;
use super::window::{StepInputs, Window};
use crate::effects::Plant;

/// Time in which an observer follows the measured pressure, s. Shorter, and slow changes are
/// forgotten before they show; longer, and what the model lacks adds up.
const FOLLOW_S: f64 = 0.3;
/// Steps after a start that are not counted: the observers are on their way, s.
const SETTLE_S: f64 = 1.5;
/// Correlation of an innovation with the next beyond which it is not taken for the noise's own.
const MOST_CORRELATED: f64 = 0.95;
/// Least standard deviation of innovations, Pa.
const LEAST_PA: f64 = 1.0;

/// Variance and correlation of innovations, as far as they are known.
#[derive(Debug, Clone, Copy, Default)]
struct Colour {
    squares: f64,
    products: f64,
    count: f64,
}

/// How innovations are made white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whitening {
    /// Correlation of each with the one before.
    pub correlation: f64,
    /// Standard deviation of what is left, Pa.
    pub deviation_pa: f64,
}

/// The observers.
#[derive(Clone)]
pub struct Bank {
    plant: Plant,
    window: Window,
    nominal: Observer,
    probes: Vec<Observer>,
    /// What the probes are of.
    pub directions: Vec<Direction>,
    running: bool,
    settled_at_s: f64,
    before: Option<(f64, Vec<f64>)>,
    colour: Colour,
    whitening: Option<Whitening>,
    limiter: Limiter,
    block: Block,
    /// Flow that the calibrated model draws from the supply, mm^2 Pa.
    pub draw: f64,
}

impl Bank {
    /// Of a channel.
    pub fn new(prepared: &Prepared) -> Self {
        let plant = prepared.data.plant.clone();
        let window = Window::new(&prepared.data.inputs);
        let directions = directions(&plant, &prepared.model);
        let observer = |model| Observer::new(&plant, model, &window);
        Self {
            nominal: observer(&prepared.model),
            probes: directions.iter().map(|d| observer(&d.model)).collect(),
            limiter: Limiter::default(),
            block: Block::new(directions.len()),
            directions,
            running: false,
            settled_at_s: f64::INFINITY,
            before: None,
            colour: Colour::default(),
            whitening: None,
            draw: 0.0,
            window,
            plant,
        }
    }

    /// Stops until the next fresh step.
    pub fn stop(&mut self) {
        self.running = false;
        self.before = None;
        self.draw = 0.0;
    }

    /// Over a step; `measured_pa` is the gauge pressure measured at its end, if it was, Pa.
    pub fn step(&mut self, inputs: &StepInputs, measured_pa: Option<f64>) {
        let fresh = !self.running;
        self.window.set(inputs, fresh);
        let Self { plant, window, nominal, probes, .. } = self;
        if fresh {
            nominal.start(plant, window);
            probes.iter_mut().for_each(|probe| probe.start(plant, window));
            self.running = true;
            self.settled_at_s = inputs.t_s + SETTLE_S;
        }
        let follow = -(-inputs.length_s / FOLLOW_S).exp_m1();
        let (expected, draw) = nominal.advance(plant, window);
        self.draw = draw;
        let error = measured_pa.map(|measured| measured - expected);
        let along = probes.iter_mut().map(|probe| {
            let (reading, _) = probe.advance(plant, window);
            if let Some(measured) = measured_pa {
                probe.lead(follow * (measured - reading));
            }
            reading - expected
        });
        let along: Vec<f64> = along.collect();
        if let Some(error) = error {
            nominal.lead(follow * error);
        }
        window.end_step();
        let finite = nominal.is_finite() && probes.iter().all(Observer::is_finite);
        if !finite || along.iter().any(|d| !d.is_finite()) {
            return self.stop();
        }
        match error {
            Some(error) if inputs.t_s >= self.settled_at_s => self.count(error, along),
            _ => self.before = None,
        }
    }

    /// Counts an innovation, Pa, less what of it was to be expected from the one before.
    fn count(&mut self, error: f64, along: Vec<f64>) {
        if let Some((error_before, along_before)) = &self.before {
            match &self.whitening {
                None => {
                    self.colour.squares += error * error;
                    self.colour.products += error * error_before;
                    self.colour.count += 1.0;
                }
                Some(Whitening { correlation, deviation_pa }) => {
                    let white = |now: f64, before: f64| (now - correlation * before) / deviation_pa;
                    let along: Vec<f64> =
                        along.iter().zip(along_before).map(|(now, before)| white(*now, *before)).collect();
                    let innovation = self.limiter.limit(white(error, *error_before));
                    self.block.add(innovation, &along);
                }
            }
        }
        self.before = Some((error, along));
    }

    /// Fixes the whitening by what has been seen; whether enough has.
    pub fn whiten(&mut self, least: f64) -> bool {
        if self.colour.count < least {
            return false;
        }
        let Colour { squares, products, count } = self.colour;
        let correlation = (products / squares.max(f64::MIN_POSITIVE)).clamp(0.0, MOST_CORRELATED);
        let left = squares / count * (1.0 - correlation * correlation);
        self.whitening = Some(Whitening { correlation, deviation_pa: left.sqrt().max(LEAST_PA) });
        true
    }

    /// How innovations are whitened, once that is known.
    pub fn whitening(&self) -> Option<Whitening> {
        self.whitening
    }

    /// Hands over the block so far, and begins another.
    pub fn take_block(&mut self) -> Block {
        std::mem::replace(&mut self.block, Block::new(self.directions.len()))
    }
}
