//! A regulator whose recording looks like one.

/// A number from -1 to 1 that looks random.
pub fn scatter(k: u32) -> f64 {
    f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 23) - 1.0
}

/// 40 s at 100 Hz of a regulator: a lag of 0.2 s behind a dead time of `delay` rows, and 0.2 kPa of
/// noise.
pub fn regulator(delay: usize) -> String {
    let commands: Vec<f64> = (0..4000_u32).map(|k| 150.0 + 100.0 * scatter(k / 35)).collect();
    let (mut text, mut p) = ("t_s,b0_cmd0_kpa,b0_p0_kpa\n".to_owned(), 150.0_f64);
    for (k, command) in commands.iter().enumerate() {
        let noisy = p + 0.34 * scatter(90_000 + k as u32);
        text.push_str(&format!("{:.2},{command:.3},{noisy:.4}\n", k as f64 * 0.01));
        let acting = commands[k.saturating_sub(delay)];
        p = acting + (p - acting) * (-0.05_f64).exp();
    }
    text
}
