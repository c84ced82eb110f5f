//! One law of physics for every entry of the catalogue.

mod chamber;
mod flow;
mod regulator;
mod sensor;
mod supply;
mod valve;

use std::collections::BTreeSet;

use pneudrive_model::model::psi_max;

use crate::effects::bench::{Bench, Sample, catalogue};

/// One test for each entry, of the same name.
macro_rules! laws {
    ($($id:ident => $law:path,)*) => {
        const COVERED: &[&str] = &[$(stringify!($id)),*];

        $(#[test]
        fn $id() {
            $law();
        })*
    };
}

laws! {
    drive_crosstalk => valve::a_closed_valve_opens_by_the_share_of_the_drive_beside_it,
    drive_saturation => valve::beyond_the_limit_more_drive_changes_nothing,
    coil_heating => valve::the_spool_falls_back_as_the_coil_warms_up_and_returns_as_it_cools,
    transport_delay => valve::a_dead_time_of_some_rows_shifts_the_response_by_these_rows,
    valve_lag => valve::a_step_of_the_drive_opens_the_port_exponentially,
    valve_hysteresis => valve::the_spool_stands_half_the_gap_behind_on_either_way,
    valve_stiction => valve::a_slow_ramp_becomes_stairs_of_the_height_of_the_threshold,
    valve_asymmetry => valve::venting_is_slower_by_the_ratio_and_filling_is_not,
    vent_restriction => flow::two_orifices_in_series_pass_the_flow_that_is_equal_in_both,
    flow_function => flow::the_flow_is_that_of_the_critical_ratio_and_exponent,
    heat_exchange => chamber::filling_lies_between_isothermal_and_adiabatic,
    wall_compliance => chamber::a_wall_that_gives_way_slows_the_rise_by_volume_and_growth,
    wall_creep => chamber::a_closed_chamber_creeps_along_the_adiabat_to_its_final_volume,
    line_restriction => chamber::what_is_let_in_is_in_the_tube_or_in_the_chamber,
    chamber_coupling => chamber::a_fall_of_the_pressure_opposite_lengthens_a_closed_chamber,
    supply_misstated => supply::choked_inflow_is_proportional_to_what_the_supply_is,
    supply_sag => supply::the_supply_falls_in_proportion_to_the_total_flow,
    supply_ripple => supply::the_supply_swings_as_a_triangle,
    inflow_cycle => supply::the_inflow_swings_as_a_sine,
    sensor_lag => sensor::a_ramp_is_read_late_by_the_time_constant,
    sensor_nonlinearity => sensor::the_bow_is_in_the_middle_and_nothing_at_the_ends,
    sensor_drift => sensor::the_zero_drifts_exponentially_to_its_change,
    sensor_crosstalk => sensor::the_reading_is_pulled_to_the_sample_before_by_the_share,
    valve_wear => valve::the_opening_changes_exponentially_with_time,
    stale_samples => sensor::an_old_sample_is_held_by_its_share_where_rows_repeat,
    dead_band => regulator::a_small_change_of_the_command_is_ignored_and_a_large_one_is_not,
    rate_limit => regulator::a_large_step_is_a_ramp_at_the_limit,
    offset => regulator::the_final_pressure_is_off_by_the_offset,
    supply_level => supply::choked_inflow_is_proportional_to_the_supply,
    exhaust_leak => flow::a_closed_chamber_decays_with_the_time_constant_of_choked_flow,
    fill_leak => flow::a_closed_chamber_rises_at_the_choked_rate,
    valve_gain => valve::the_opening_is_multiplied,
    valve_centre => valve::a_shift_of_the_spool_is_a_shift_of_the_drive,
    chamber_volume => chamber::a_larger_chamber_does_the_same_more_slowly,
    sensor_offset => sensor::every_reading_is_off_by_the_offset,
    sensor_gain => sensor::every_reading_is_off_by_the_factor,
}

#[test]
fn every_entry_has_a_law() {
    let covered: BTreeSet<&str> = COVERED.iter().copied().collect();
    let entries: BTreeSet<&str> = catalogue().iter().map(|info| info.id).collect();
    assert_eq!(covered, entries, "a new entry needs a law of its own in this folder");
}

#[test]
fn a_bent_sensor_bends_what_is_read_of_the_chamber_opposite_as_well() {
    chamber::a_bent_sensor_bends_what_is_read_of_the_chamber_opposite_as_well();
}

#[test]
fn gas_behind_a_tube_has_a_temperature() {
    chamber::gas_behind_a_tube_is_warmed_and_cools_again();
    chamber::behind_a_wide_tube_gas_is_warmed_as_without_one();
}

#[test]
fn a_wall_gives_way_to_gas_that_has_a_temperature() {
    chamber::a_wall_gives_way_to_gas_that_has_a_temperature();
}

/// A valve of 0.1 mm^2 that fills a chamber so slowly that the flow stays choked.
fn choked(drive: &[f64]) -> Bench {
    Bench::valve(GAIN_MM2, 110e3, drive)
}

/// Opening of that valve at full drive.
const GAIN_MM2: f64 = 0.1;

/// Effective areas of the fill port, from choked flows out of the supply, mm^2.
fn openings(bench: &Bench, samples: &[Sample]) -> Vec<f64> {
    let supplies = bench.inputs.supply_pa.iter();
    samples.iter().zip(supplies).map(|(sample, supply)| sample.draw / (psi_max() * supply)).collect()
}

/// Readings, absolute, Pa.
fn readings(samples: &[Sample]) -> Vec<f64> {
    samples.iter().map(|sample| sample.reading_pa).collect()
}

fn last(samples: &[Sample]) -> f64 {
    samples.last().unwrap().reading_pa
}

/// Fails where two numbers differ by more than a part of the second.
#[track_caller]
fn assert_close(found: f64, expected: f64, part: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= part * expected.abs(),
        "{found} instead of {expected}: off by {:e}",
        error / expected.abs()
    );
}

/// The same for all rows of two series, by the largest expected value.
#[track_caller]
fn assert_all_close(found: &[f64], expected: &[f64], part: f64) {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().map(|v| v.abs()).fold(0.0, f64::max);
    for (row, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= part * largest, "row {row}: {a} instead of {b}");
    }
}
