//! The four pictures.

use crate::capture::{characters, pins};
use crate::svg::{self, Mark, Panel, picture};
use pneudrive_chip::{Level, Ticks};
use pneudrive_protocol::CHANNELS;
use system_tests::chip_bench::{BUS, CHARACTER, ChipBench, DIR, DRIVER_ENABLE, PWM, packet};

const TRANSMIT: usize = 0;
const MS: Ticks = Ticks::from_millis(1);
const US: Ticks = Ticks::from_micros(1);

/// Valve pins from the boot loader's start on, and again when Embassy resets them.
pub fn reset() -> String {
    let watched = [(6, "PWM 0"), (7, "DIR 0"), (13, "DIR 3"), (2, "DE"), (0, "bus TX")];
    let mut bench = ChipBench::power_on(0);
    // Its pull-up on the board (docs/firmware.md).
    bench.chip.set_pin_input(TRANSMIT, Level::High);
    let start = pins(&mut bench, &watched, US * 300);
    let driven = start[0].first_driven().unwrap_or(f64::NAN);
    bench.chip.run_until(Ticks::from_micros(127_500));
    let init = pins(&mut bench, &watched, MS * 131);
    // Driven at first, let go by the initialisation, driven again.
    let gone = init[1].changes.get(1).map_or(f64::NAN, |(at, _)| *at);
    let back = init[1].changes.get(2).map_or(f64::NAN, |(at, _)| *at);
    picture(&[
        Panel {
            title: "After a reset: 0 is where the boot ROM hands over (solid: driven, dashed: pulled)".into(),
            from: 0.0,
            to: 300.0,
            zero: 0.0,
            traces: start,
            marks: vec![Mark { row: 0, from: 0.0, to: driven, text: format!("{driven:.0} us: pulled up") }],
        },
        Panel {
            title: format!("{:.0} ms later: Embassy's initialisation lets go of the pins", gone / 1e3),
            from: gone - 200.0,
            to: gone + 1_000.0,
            zero: gone,
            traces: init,
            marks: vec![Mark {
                row: 1,
                from: gone,
                to: back,
                text: format!("{:.0} us: pulled up", back - gone),
            }],
        },
    ])
}

/// One exchange, and its two ends.
pub fn answer() -> String {
    let mut bench = ChipBench::running(0);
    let bytes = packet(0, [500, 102, 341, 682]).encode();
    let begin = bench.chip.now() + US * 20;
    bench.run(US * 20);
    let end = bench.send(&bytes);
    let mut seen = pins(&mut bench, &[(DRIVER_ENABLE, "DE")], end + US * 160);
    let mut enable = seen.remove(0);
    // It was low before, too.
    enable.changes[0].0 = 0.0;
    let sent: Vec<_> = bench.chip.take_transmitted(BUS).map(|sent| (sent.byte, sent.end)).collect();
    let heard: Vec<_> =
        bytes.iter().zip((1..=10).map(|n| begin + CHARACTER * n)).map(|(b, at)| (*b, at)).collect();
    let receive = characters("GPIO 1  bus RX", begin.saturating_sub(US * 20), &heard);
    let transmit = characters(&format!("GPIO {TRANSMIT}  bus TX"), begin.saturating_sub(US * 20), &sent);
    let end = end.as_micros();
    let start_bit = transmit.edges(false).next().unwrap_or(f64::NAN);
    let last_stop = sent.last().map_or(f64::NAN, |(_, at)| at.as_micros());
    let enabled = enable.edges(true).next().unwrap_or(f64::NAN);
    let released = enable.edges(false).next().unwrap_or(f64::NAN);
    let traces = vec![receive, transmit, enable];
    let panel = |title: &str, from: f64, to: f64, marks| Panel {
        title: title.into(),
        from,
        to,
        zero: end,
        traces: traces.clone(),
        marks,
    };
    let mark = |row, from: f64, to: f64, what: &str| {
        let us = to - from;
        let length = if us < 0.5 { format!("{:.0} ns", us * 1e3) } else { format!("{us:.1} us") };
        Mark { row, from, to, text: format!("{length} {what}") }
    };
    picture(&[
        panel(
            "One exchange at 1 Mbaud: 0 is the end of the request's last stop bit",
            end - 110.0,
            end + 130.0,
            vec![mark(1, start_bit, last_stop, "")],
        ),
        panel(
            "From request to answer",
            end - 6.0,
            end + 22.0,
            vec![
                mark(1, end, start_bit, "(13.6 to 20)"),
                mark(2, enabled, start_bit, "before the start bit"),
            ],
        ),
        panel("The answer's end", last_stop - 12.0, last_stop + 8.0, vec![mark(2, last_stop, released, "")]),
    ])
}

/// Four drives at once: fills fully, fills by half, vents by half, vents fully.
pub fn pwm() -> String {
    let mut bench = ChipBench::running(0);
    bench.read([500; CHANNELS]);
    let commands = [540, 520, 480, 460];
    for _ in 0..20 {
        let _ = bench.exchange(packet(0, commands));
        bench.run(MS * 2);
    }
    let names: Vec<(usize, String)> = (0..CHANNELS)
        .flat_map(|valve| [(DIR[valve], format!("DIR {valve}")), (PWM[valve], format!("PWM {valve}"))])
        .collect();
    let watched: Vec<(usize, &str)> = names.iter().map(|(pin, name)| (*pin, name.as_str())).collect();
    let from = bench.chip.now();
    let traces = pins(&mut bench, &watched, from + US * 120);
    let rises: Vec<f64> = traces[3].edges(true).collect();
    let (first, second) = match rises[..] {
        [first, second, ..] => (first, second),
        _ => (f64::NAN, f64::NAN),
    };
    let text = format!("{:.2} us, {:.2} kHz", second - first, 1e3 / (second - first));
    picture(&[Panel {
        title: "Set point 34, 17, -17, -34 kPa from the pressure: fills, fills by half, vents by half, vents"
            .into(),
        from: from.as_micros(),
        to: from.as_micros() + 120.0,
        zero: from.as_micros(),
        marks: vec![Mark { row: 3, from: first, to: second, text }],
        traces,
    }])
}

/// How late answers begin, at all phases of the control loop and the log.
pub fn answer_times() -> String {
    const FROM: f64 = 12.0;
    const TO: f64 = 21.0;
    const BIN: f64 = 0.1;
    let mut bench = ChipBench::running(0);
    let mut bins = vec![0_u32; ((TO - FROM) / BIN).round() as usize];
    for n in 0..2_000_u64 {
        let Some(answer) = bench.exchange(packet(0, [n as u16 % 1024; CHANNELS])) else { continue };
        let bin = ((answer.delay.as_micros() - FROM) / BIN).clamp(0.0, bins.len() as f64 - 1.0);
        bins[bin as usize] += 1;
        bench.run(Ticks::new(n * 7_919 % 125_000));
    }
    let (left, width, bottom, height) = (60.0, 880.0, 270.0, 200.0);
    let x = |us: f64| left + (us - FROM) / (TO - FROM) * width;
    let most = f64::from(bins.iter().copied().max().unwrap_or(1));
    let mut svg = svg::header(320.0);
    let title = "From the request's last stop bit to the answer's start bit, 2000 exchanges";
    svg::text(&mut svg, left, 24.0, "start", "title", title);
    for us in 12..=21 {
        let at = x(f64::from(us));
        svg::line(&mut svg, "grid", (at, bottom - height - 10.0), (at, bottom + 6.0));
        svg::text(&mut svg, at, bottom + 22.0, "middle", "", &us.to_string());
    }
    svg::text(&mut svg, left + width, bottom + 42.0, "end", "", "us");
    for (n, count) in bins.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (at, tall) = (x(FROM + BIN * n as f64), f64::from(*count) / most * height);
        svg.push_str(&format!(
            "<rect x=\"{at:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{tall:.1}\" fill=\"#1b5e8c\"/>\n",
            bottom - tall,
            width * BIN / (TO - FROM) - 1.0
        ));
    }
    for (limit, words) in [(13.6, "not before 13.6"), (20.0, "not after 20")] {
        svg::line(&mut svg, "mark", (x(limit), bottom - height - 10.0), (x(limit), bottom));
        svg::text(&mut svg, x(limit) - 6.0, bottom - height - 4.0, "end", "red", words);
    }
    svg.push_str("</svg>\n");
    svg
}
