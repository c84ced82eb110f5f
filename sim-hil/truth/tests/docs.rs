//! docs/plant.md says what the code does: its tables are compared with the code.
use pneudrive_truth::{PlantParameters, effects_table};

fn docs() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/plant.md");
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn the_table_of_effects_is_the_catalogue() {
    let table = effects_table();
    assert!(docs().contains(table.trim_end()), "docs/plant.md should hold this:\n\n{table}");
}

#[test]
fn the_table_of_parameters_has_the_defaults() {
    let p = PlantParameters::default();
    let docs = docs();
    for (name, value) in [
        ("channels", p.channels.to_string()),
        ("step_ns", p.step_ns.to_string()),
        ("ambient.pressure_kpa_abs", p.ambient.pressure_kpa_abs.to_string()),
        ("ambient.temperature_k", p.ambient.temperature_k.to_string()),
        ("supply.pressure_kpa", p.supply.pressure_kpa.to_string()),
        ("chamber.radius_m", p.chamber.radius_m.to_string()),
        ("chamber.length_m", p.chamber.length_m.to_string()),
        ("chamber.offset_m", p.chamber.offset_m.to_string()),
        ("chamber.initial_kpa", p.chamber.initial_kpa.to_string()),
        ("valve.conductance_m3_per_s_pa", format!("{:e}", p.valve.conductance_m3_per_s_pa)),
        ("valve.fill_edge", p.valve.fill_edge.to_string()),
        ("valve.vent_edge", p.valve.vent_edge.to_string()),
        ("valve.corner", p.valve.corner.to_string()),
        ("valve.leakage", p.valve.leakage.to_string()),
        ("valve.flow.critical_ratio", p.valve.flow.critical_ratio().to_string()),
        ("valve.flow.exponent", p.valve.flow.exponent().to_string()),
        ("valve.flow.laminar_ratio", p.valve.flow.laminar_ratio().to_string()),
        ("valve.spool_time_constant_s", p.valve.spool_time_constant_s.to_string()),
        ("joint.free", p.joint.free.to_string()),
        ("joint.angle_rad_per_mpa", p.joint.angle_rad_per_mpa.to_string()),
        ("joint.natural_frequency_hz", p.joint.natural_frequency_hz.to_string()),
        ("joint.damping_ratio", p.joint.damping_ratio.to_string()),
        ("sensor.noise_kpa", p.sensor.noise_kpa.to_string()),
        ("sensor.adc_bits", p.sensor.adc_bits.to_string()),
        ("nuisances.supply_wander", p.nuisances.supply_wander.to_string()),
        ("nuisances.supply_wander_time_s", p.nuisances.supply_wander_time_s.to_string()),
        ("nuisances.spread", p.nuisances.spread.to_string()),
    ] {
        assert!(
            docs.contains(&format!("| `{name}` | {value} |")),
            "docs/plant.md: `{name}` with default {value}"
        );
    }
}
