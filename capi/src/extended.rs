//! A channel with the extended model of a diagnosis.

use pneudrive_model::data::ChannelId;
use pneudrive_model::diagnosis::{ChannelData, ExtendedFile};
use pneudrive_model::effects::catalogue::AnyEffect;
use pneudrive_model::effects::{
    DriveInput, Facing, Plant, Step, Stepper, StepperState, Stretch, course_from, install,
};

use crate::engine::{Engine, check_loop};
use crate::error::CreateError;
use crate::inputs::{Control, Inputs};
use crate::outputs::Outputs;
use crate::window::{NEXT, NOW, Window};

const PA_PER_KPA: f64 = 1e3;

/// Calls after which an effect keeps everything that it does not collect call by call.
const CALLS_TO_SETTLE: usize = 3;

/// The engine: the steps that a simulation with effects makes.
pub struct ExtendedEngine {
    plant: Plant,
    base: Vec<f64>,
    effects: Vec<AnyEffect<f64>>,
    /// How many numbers each effect remembers once it has begun.
    counts: Vec<usize>,
    /// Room for what one of them remembers.
    kept: Vec<f64>,
    window: Window,
    /// Inputs with neighbours: some effects remember nothing without them.
    with_neighbours: Inputs,
    state: StepperState<f64>,
    state_size: usize,
    noise_draw: u64,
    step_s: f64,
    /// Length of an integration step, s.
    part_s: f64,
}

impl ExtendedEngine {
    /// Sets up a channel; `name` is the file's, for messages.
    pub fn new(
        (name, file): (&str, &ExtendedFile),
        id: ChannelId,
        step_s: f64,
        control: Control,
        nominal: &Inputs,
    ) -> Result<Self, CreateError> {
        let stored = file.channels.get(&id.to_string()).ok_or_else(|| CreateError::NoChannel {
            channel: id,
            found: file.channels.keys().cloned().collect::<Vec<_>>().join(", "),
        })?;
        if stored.correction.is_some() {
            return Err(CreateError::Correction { channel: id });
        }
        if control == Control::Drive && stored.drive == "command" {
            return Err(CreateError::Regulator { channel: id });
        }
        let set_point = match control {
            Control::AsCalibrated => None,
            Control::SetPoint => Some(true),
            Control::Drive => Some(false),
        };
        let data = file.template(name, id, set_point)?;
        let model = file.models(name, std::slice::from_ref(&data))?.remove(0);
        let ChannelData { plant, inputs, .. } = data;
        let controlled = plant.board.filter(|_| inputs.drive == DriveInput::Controlled);
        let loops = match &controlled {
            Some(board) => {
                check_loop(step_s, board.rate_hz)?;
                board.steps(step_s)
            }
            None => 1,
        };
        let parts = loops * plant.steps(step_s / loops as f64);
        let base_count = plant.parameters().len();
        let mut effects = install(&plant, &model.effects, &model.values);
        let base = model.values[..base_count].to_vec();
        let mut window = Window::new(&inputs, step_s);
        window.set(0.0, nominal);
        let mut state = Stepper::new(&plant, &base, &mut effects, &window.inputs).state();
        let mut state_size = 0;
        state.values(&mut |_| state_size += 1);
        let mut engine = Self {
            noise_draw: controlled.map_or(0, |board| board.noise_draw),
            counts: Vec::new(),
            kept: Vec::new(),
            part_s: step_s / parts as f64,
            effects,
            plant,
            base,
            window,
            with_neighbours: Inputs { opposite_kpa: [0.0; 2], sampled_before_kpa: [0.0; 2], ..*nominal },
            state,
            state_size,
            step_s,
        };
        engine.window.set(0.0, &engine.with_neighbours);
        for k in 0..engine.effects.len() {
            (0..CALLS_TO_SETTLE).for_each(|_| engine.begin(k));
            // A dead time collects a drive a call, until it spans as many as it is long.
            let mut count = engine.count(k);
            loop {
                engine.begin(k);
                match engine.count(k) {
                    same if same == count => break,
                    more => count = more,
                }
            }
            engine.counts.push(count);
            engine.effects[k].reset();
        }
        engine.kept = vec![0.0; engine.counts.iter().copied().max().unwrap_or(0)];
        engine.window.set(0.0, nominal);
        Ok(engine)
    }

    /// Numbers that an effect remembers now.
    fn count(&mut self, effect: usize) -> usize {
        let mut count = 0;
        self.effects[effect].memory(&mut |_, _| count += 1);
        count
    }

    /// Makes an effect remember something of everything that it will.
    fn begin(&mut self, effect: usize) {
        let inputs = &self.window.inputs;
        let step = Step { row: NOW, time_s: 0.5 * self.part_s, length_s: self.part_s, lags: false, inputs };
        let effect = &mut self.effects[effect];
        effect.drive(&step, 0, &mut 0.0);
        if matches!(inputs.drive, DriveInput::Separate { .. }) {
            effect.drive(&step, 1, &mut 0.0);
        }
        let mut stretch = Stretch { factor: 1.0, rate: 0.0, by_pressure: 0.0 };
        let opposite = inputs.opposite_pa.get(NOW).map(|gauge| gauge + inputs.ambient_pa);
        effect.stretch(&step, &Facing { own: inputs.ambient_pa, opposite }, &mut stretch);
        effect.sense(&step, &mut 0.0);
        effect.sample(inputs, NOW, 0.0);
    }

    /// Runs the channel on from where it stands.
    fn run<T>(&mut self, act: impl FnOnce(&mut Stepper<'_, f64>) -> T) -> T {
        let mut stepper = Stepper::new(&self.plant, &self.base, &mut self.effects, &self.window.inputs);
        stepper.resume(self.state);
        let result = act(&mut stepper);
        self.state = stepper.state();
        result
    }

    fn kpa(&self, pa: f64) -> f64 {
        (pa - self.window.inputs.ambient_pa) / PA_PER_KPA
    }

    fn outputs(&self, reading_pa: f64, drive: f64, draw: f64) -> Outputs {
        let [fill, vent] = self.state.spool();
        Outputs {
            pressure_kpa: self.kpa(self.state.pressure()),
            port_kpa: self.kpa(self.state.port()),
            reading_kpa: reading_pa / PA_PER_KPA,
            temperature_k: self.state.temperature(),
            fill,
            vent,
            drive,
            draw,
            ..Outputs::default()
        }
    }
}

impl Engine for ExtendedEngine {
    fn start(&mut self, kpa: f64, inputs: &Inputs) -> Outputs {
        self.window.set(0.0, inputs);
        self.window.set_start(kpa);
        self.window.set_fresh(true);
        let reading_pa = self.run(|stepper| {
            stepper.start(NOW);
            stepper.reading(NOW)
        });
        self.outputs(reading_pa, 0.0, 0.0)
    }

    fn step(&mut self, step: u64, inputs: &Inputs) -> Outputs {
        #[allow(clippy::cast_precision_loss)] // exact for 285 years of microseconds
        self.window.set(step as f64 * self.step_s, inputs);
        self.window.set_fresh(step == 0);
        if let Some(board) = &mut self.plant.board {
            board.noise_draw = course_from(self.noise_draw, step.cast_signed() - NOW as i64);
        }
        let supply_pa = self.window.inputs.supply_pa[NOW];
        let (reading_pa, drive, draw) = self.run(|stepper| {
            stepper.set_supply(supply_pa);
            let (drive, draw) = stepper.interval(NOW);
            (stepper.reading(NEXT), drive, draw)
        });
        self.window.set_point_was(inputs.set_point_kpa);
        self.outputs(reading_pa, drive, draw)
    }

    fn set_pressure(&mut self, kpa: f64) {
        let pa = self.window.inputs.ambient_pa + PA_PER_KPA * kpa;
        self.run(|stepper| stepper.set_pressure(pa));
    }

    fn size(&self) -> usize {
        1 + self.state_size + self.counts.iter().sum::<usize>()
    }

    fn save(&mut self, into: &mut dyn FnMut(f64)) {
        into(self.window.set_point_before());
        self.state.values(&mut |value| into(*value));
        for k in 0..self.effects.len() {
            let mut missing = self.counts[k];
            self.effects[k].memory(&mut |_, value| {
                if missing > 0 {
                    missing -= 1;
                    into(*value);
                }
            });
            (0..missing).for_each(|_| into(f64::NAN));
        }
    }

    fn restore(&mut self, from: &mut dyn FnMut() -> f64) {
        self.window.set_point_was(from());
        self.state.values(&mut |value| *value = from());
        for k in 0..self.effects.len() {
            if self.counts[k] == 0 {
                continue;
            }
            // What has not collected everything yet is followed by NaN.
            let mut known = 0;
            for (place, kept) in self.kept[..self.counts[k]].iter_mut().enumerate() {
                *kept = from();
                known = if kept.is_nan() { known } else { place + 1 };
            }
            if self.count(k) != known {
                self.effects[k].reset();
                self.window.set(0.0, &self.with_neighbours);
                for _ in 0..self.counts[k] {
                    if self.count(k) >= known {
                        break;
                    }
                    self.begin(k);
                }
            }
            let mut kept = self.kept[..known].iter();
            let mut begun = known > 0;
            self.effects[k].memory(&mut |_, value| {
                *value = kept.next().copied().unwrap_or(f64::NAN);
                begun &= !value.is_nan();
            });
            if !begun {
                self.effects[k].reset();
            }
        }
    }
}
