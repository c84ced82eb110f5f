//! A saved state holds everything; nothing allocates after creation; derivatives are those of the
//! next step.

#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use crate::support::{Driven, channel, extended, generator};
use pneudrive_capi::{Channel, Inputs, STATE_PRESSURE, StepError};
use pneudrive_model::data::ChannelId;
use pneudrive_model::effects::catalogue::CATALOGUE;
use pneudrive_model::simulation::CalibratedModel;

const ID: ChannelId = ChannelId { board: 0, channel: 0 };

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// Counts what each thread asks for.
struct Counting;

// SAFETY: passes everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: as the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller's.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Every combination of one effect and a kind of drive that makes sense.
fn each(mut test: impl FnMut(&str, Driven, &CalibratedModel)) {
    for (number, info) in CATALOGUE.iter().enumerate() {
        for driven in Driven::ALL.into_iter().filter(|driven| driven.has(info)) {
            let mut rng = generator(50 + number as u64);
            let model = CalibratedModel::from(extended(&mut rng, driven, 1, &[info.id]));
            test(info.id, driven, &model);
        }
    }
}

/// Inputs that keep everything moving.
fn inputs(channel: &Channel, step: u32) -> Inputs {
    let t = f64::from(step);
    Inputs {
        fill: 0.4 * (0.7 * t).sin(),
        vent: 0.2 + 0.2 * (0.3 * t).cos(),
        set_point_kpa: if (step / 12).is_multiple_of(2) { 120.0 } else { 180.0 },
        opposite_kpa: [80.0 + t, 81.0 + t],
        sampled_before_kpa: [60.0 + t, 61.0 + t],
        others_draw: 1e4,
        repeats: step % 8,
        ..*channel.nominal()
    }
}

fn run(channel: &mut Channel, steps: std::ops::Range<u32>) -> Vec<f64> {
    steps.map(|step| channel.step(&inputs(channel, step)).unwrap().reading_kpa).collect()
}

#[test]
fn a_restored_channel_goes_on_with_the_same_numbers() {
    each(|id, driven, model| {
        for saved_after in [0, 1, 40_u32] {
            let mut first = channel(model, ID);
            let begin = inputs(&first, 0);
            first.start(90.0, &begin).unwrap();
            run(&mut first, 0..saved_after);
            let mut state = vec![0.0; first.state_size()];
            first.save(&mut state).unwrap();
            assert_eq!(state[STATE_PRESSURE], first.outputs().pressure_kpa);
            let expected = run(&mut first, saved_after..saved_after + 40);
            // Into itself, into one that never ran, and into one that ran something else.
            let mut never = channel(model, ID);
            let mut other = channel(model, ID);
            other.start(200.0, &begin).unwrap();
            run(&mut other, 3..90);
            for channel in [&mut first, &mut never, &mut other] {
                channel.restore(&state).unwrap();
                let again = run(channel, saved_after..saved_after + 40);
                assert_eq!(again, expected, "{id} {driven:?} after {saved_after}");
            }
        }
    });
}

/// A dead time spans many steps: what is on its way is part of the state, also before all of it has
/// begun.
#[test]
fn what_is_on_its_way_comes_back() {
    for driven in [Driven::Spool, Driven::Separate, Driven::Board] {
        let mut file = extended(&mut generator(9), driven, 1, &["transport_delay"]);
        for one in file.channels.values_mut() {
            one.effects.get_mut("transport_delay").unwrap().insert("delay".to_owned(), 0.05);
        }
        let model = CalibratedModel::from(file);
        for saved_after in [2, 7, 40_u32] {
            let mut first = channel(&model, ID);
            first.start(90.0, &inputs(&first, 0)).unwrap();
            run(&mut first, 0..saved_after);
            let mut state = vec![0.0; first.state_size()];
            first.save(&mut state).unwrap();
            let expected = run(&mut first, saved_after..saved_after + 40);
            let mut never = channel(&model, ID);
            for channel in [&mut first, &mut never] {
                channel.restore(&state).unwrap();
                let again = run(channel, saved_after..saved_after + 40);
                assert_eq!(again, expected, "{driven:?} after {saved_after}");
            }
        }
    }
}

#[test]
fn nothing_allocates_after_creation() {
    each(|id, driven, model| {
        let mut channel = channel(model, ID);
        let mut state = vec![0.0; channel.state_size()];
        let before = ALLOCATIONS.get();
        for _ in 0..2 {
            channel.start(90.0, &inputs(&channel, 0)).unwrap();
            channel.save(&mut state).unwrap();
            for step in 0..100 {
                channel.step(&inputs(&channel, step)).unwrap();
                if step == 50 {
                    channel.save(&mut state).unwrap();
                    channel.partials(&inputs(&channel, step)).unwrap();
                }
            }
            channel.restore(&state).unwrap();
            channel.set_pressure(100.0).unwrap();
        }
        assert_eq!(ALLOCATIONS.get() - before, 0, "{id} {driven:?}");
    });
    let counts = ALLOCATIONS.get();
    drop(vec![0_u8; 100]);
    assert_eq!(ALLOCATIONS.get(), counts + 1, "allocations are counted");
}

#[test]
fn partials_are_those_of_the_next_step() {
    let model = CalibratedModel::from(extended(&mut generator(3), Driven::Spool, 1, &["valve_lag"]));
    let mut channel = channel(&model, ID);
    let at = Inputs { fill: 0.4, ..*channel.nominal() };
    channel.start(150.0, &at).unwrap();
    for _ in 0..3 {
        channel.step(&at).unwrap();
    }
    let here = *channel.outputs();
    let partials = channel.partials(&at).unwrap();
    assert_eq!(*channel.outputs(), here, "it stays where it is");
    let mut state = vec![0.0; channel.state_size()];
    channel.save(&mut state).unwrap();
    let mut end = |pressure_kpa: f64, inputs: &Inputs| {
        channel.restore(&state).unwrap();
        channel.set_pressure(pressure_kpa).unwrap();
        channel.step(inputs).unwrap().pressure_kpa
    };
    let before = end(here.pressure_kpa, &at);
    // A tenth of a percent of the whole change, predicted to 2 % of it.
    let close = |after: f64, predicted: f64, name: &str| {
        let change = after - before;
        assert!((change - predicted).abs() < 0.02 * change.abs(), "{name}: {change} and {predicted}");
    };
    close(end(here.pressure_kpa + 1.0, &at), partials.by_pressure, "pressure");
    close(end(here.pressure_kpa, &Inputs { fill: 0.41, ..at }), 0.01 * partials.by_fill, "drive");
    let supply_kpa = at.supply_kpa + 5.0;
    close(end(here.pressure_kpa, &Inputs { supply_kpa, ..at }), 5.0 * partials.by_supply, "supply");
    let volume = 0.01 * at.volume_m3;
    let volume_m3 = at.volume_m3 + volume;
    close(end(here.pressure_kpa, &Inputs { volume_m3, ..at }), volume * partials.by_volume, "volume");
    let volume_rate_m3_s = at.volume_m3;
    let predicted = volume_rate_m3_s * partials.by_volume_rate;
    close(end(here.pressure_kpa, &Inputs { volume_rate_m3_s, ..at }), predicted, "volume rate");
    assert_eq!([partials.by_vent, partials.by_set_point], [0.0; 2]);
}

#[test]
fn impossible_inputs_change_nothing() {
    let model = CalibratedModel::from(extended(&mut generator(5), Driven::Board, 1, &[]));
    let mut channel = channel(&model, ID);
    let good = *channel.nominal();
    assert_eq!(channel.step(&good).unwrap_err(), StepError::NotStarted);
    channel.start(20.0, &good).unwrap();
    let before = *channel.outputs();
    for bad in [
        Inputs { set_point_kpa: f64::NAN, ..good },
        Inputs { volume_m3: 0.0, ..good },
        Inputs { supply_kpa: f64::INFINITY, ..good },
    ] {
        assert!(matches!(channel.step(&bad), Err(StepError::Input { .. })));
    }
    assert_eq!(*channel.outputs(), before);
    assert!(matches!(channel.restore(&[1.0; 3]), Err(StepError::State { found: 3, .. })));
}
