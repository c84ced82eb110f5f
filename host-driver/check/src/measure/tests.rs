use super::*;

/// A chamber that rises by 500 and falls by 250 kPa/s, 12 ms late, stops 1 kPa below a set point
/// that it rises to and 3 kPa above one that it falls to, loses 2 kPa/s there, and reads 0.5 kPa
/// too much; channel 1 follows channel 0 by 2 kPa.
fn chamber(plan: &Plan) -> Samples {
    const STEP_S: f64 = 0.001;
    let mut samples = Samples::default();
    let mut kpa = [0.0_f64; CHANNELS];
    let mut arrived = [false; CHANNELS];
    for row in 0..(plan.seconds() / STEP_S) as u32 {
        // Between the times at which phases begin: rounding decides nothing.
        let t_s = (f64::from(row) + 0.3) * STEP_S;
        let command = plan.command_kpa(t_s, &samples);
        let crosstalk = [0.0, if command[0] > 0.0 { 2.0 } else { 0.0 }, 0.0, 0.0];
        samples.push(t_s, command, std::array::from_fn(|channel| kpa[channel] + 0.5 + crosstalk[channel]));
        let late = plan.command_kpa(t_s - 0.012, &samples);
        for channel in 0..CHANNELS {
            let (below, above) =
                (late[channel] - 1.0, late[channel] + if late[channel] > 0.0 { 3.0 } else { 0.0 });
            let p = &mut kpa[channel];
            if *p < below - 1e-9 && !arrived[channel] {
                *p = (*p + 500.0 * STEP_S).min(below);
            } else if *p > above {
                *p = (*p - 250.0 * STEP_S).max(above);
            } else if late[channel] > 0.0 {
                *p -= 2.0 * STEP_S;
            }
            arrived[channel] = *p >= below - 1e-9 || (arrived[channel] && *p >= below - 4.0);
        }
    }
    samples
}

#[test]
fn every_quantity_is_what_the_chamber_has() {
    let plan = Plan::new([150.0; 4], 1.0).unwrap();
    let measured = measure(&plan, &chamber(&plan));
    let value = |channel, quantity| {
        let found = measured.iter().find(|one| (one.channel, one.quantity) == (channel, quantity)).unwrap();
        found.estimate.clone().unwrap().0
    };
    let expected = [
        (Quantity::Zero, 0.5, 1e-9),
        (Quantity::Noise, 0.0, 1e-9),
        (Quantity::FillRate, 500.0, 1.0),
        (Quantity::VentRate, 250.0, 1.0),
        // The first row behind the dead time begins to rise, the next one shows it.
        (Quantity::DeadTime, 12.0, 1.1),
        // 2 kPa/s take 0.45 kPa before and while it is measured.
        (Quantity::Threshold, 4.0, 0.3),
        (Quantity::Centre, 1.0 + 0.5 - 0.45, 0.3),
        (Quantity::Leak, 2.0, 0.01),
    ];
    for (quantity, expected, tolerance) in expected {
        let value = value(2, quantity);
        assert!((value - expected).abs() <= tolerance, "{quantity:?}: {value}, expected {expected}");
    }
    assert!((value(0, Quantity::Crosstalk) - 2.0).abs() < 0.01 && value(2, Quantity::Crosstalk) < 0.01);
}

#[test]
fn a_ramped_set_point_has_no_rate() {
    let plan = Plan::new([150.0; 4], 1.0).unwrap();
    let mut samples = Samples::default();
    let mut command = [0.0_f64; CHANNELS];
    for row in 0..(plan.seconds() / 0.002) as u32 {
        let t_s = f64::from(row) * 0.002;
        for (now, to) in command.iter_mut().zip(plan.command_kpa(t_s, &samples)) {
            // 200 kPa/s upwards.
            *now = to.min(*now + 0.4);
        }
        samples.push(t_s, command, command);
    }
    let measured = measure(&plan, &samples);
    let of = |quantity| &measured.iter().find(|one| one.quantity == quantity).unwrap().estimate;
    assert!(of(Quantity::FillRate).as_ref().unwrap_err().to_string().contains("ramp"));
    assert!(of(Quantity::Reached).is_ok());
}
