//! The reliability diagram as a picture.

use std::fmt::Write;

use super::reliability::Bin;

/// Edge of the plot, and what is left around it for axes, px.
const EDGE: f64 = 320.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 20.0;

fn x(probability: f64) -> f64 {
    LEFT + EDGE * probability
}

fn y(share: f64) -> f64 {
    TOP + EDGE * (1.0 - share)
}

/// An SVG: stated probability across, share that was hidden upwards with its 95 % interval, and
/// beside each point how many sets it is.
#[must_use]
pub fn svg(bins: &[Bin]) -> String {
    let (width, height) = (LEFT + EDGE + 56.0, TOP + EDGE + 52.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    let mut add =
        |text: std::fmt::Arguments<'_>| writeln!(svg, "{text}").expect("a String takes what is written");
    for tick in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
        let (across, up) = (x(tick), y(tick));
        add(format_args!("<path d=\"M{LEFT} {up}h{EDGE}M{across} {TOP}v{EDGE}\" stroke=\"#ddd\"/>"));
        add(format_args!(
            "<text x=\"{across}\" y=\"{}\" text-anchor=\"middle\">{tick}</text>",
            TOP + EDGE + 18.0
        ));
        add(format_args!("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{tick}</text>", LEFT - 8.0, up + 4.0));
    }
    add(format_args!(
        "<path d=\"M{} {}L{} {}\" stroke=\"#888\" stroke-dasharray=\"4 4\"/>",
        x(0.0),
        y(0.0),
        x(1.0),
        y(1.0)
    ));
    for bin in bins {
        let (across, up, [low, high]) = (x(bin.stated), y(bin.share()), bin.share_ci95());
        add(format_args!(
            "<path d=\"M{across} {}V{}\" stroke=\"#1664a8\" stroke-width=\"2\"/>",
            y(low),
            y(high)
        ));
        add(format_args!("<circle cx=\"{across}\" cy=\"{up}\" r=\"4\" fill=\"#1664a8\"/>"));
        add(format_args!(
            "<text x=\"{}\" y=\"{}\" fill=\"#666\">{}</text>",
            across + 8.0,
            up + 14.0,
            bin.sets
        ));
    }
    let middle = TOP + EDGE / 2.0;
    add(format_args!(
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">probability stated</text>",
        x(0.5),
        height - 12.0
    ));
    add(format_args!(
        "<text x=\"18\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 18 {middle})\">share that was hidden</text>"
    ));
    svg.push_str("</svg>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_bin_is_a_point_at_its_place_with_its_interval() {
        let bin = Bin { low: 0.4, high: 0.6, sets: 100, stated: 0.5, hidden: 25 };
        let svg = svg(&[bin, Bin { low: 0.6, high: 0.8, sets: 4, stated: 0.7, hidden: 4 }]);
        assert!(svg.contains("<circle cx=\"224\" cy=\"260\""), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains(">100</text>") && svg.trim_end().ends_with("</svg>"), "{svg}");
        let [low, high] = bin.share_ci95();
        assert!((low - 0.175).abs() < 0.002 && (high - 0.343).abs() < 0.002, "{low} {high}");
    }
}
