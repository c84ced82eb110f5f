//! The format: every table and key of the file, what it means and which values it may have.

/// A table.
#[derive(Debug)]
pub(crate) struct Table {
    pub name: &'static str,
    pub meaning: &'static str,
    pub keys: &'static [Key],
    pub tables: &'static [&'static Table],
    /// Tables whose names are numbers.
    pub numbered: Option<&'static Numbered>,
}

/// Tables `0` to `highest`.
#[derive(Debug)]
pub(crate) struct Numbered {
    /// What is counted.
    pub what: &'static str,
    pub highest: u8,
    pub table: &'static Table,
}

/// A key.
#[derive(Debug)]
pub(crate) struct Key {
    pub name: &'static str,
    pub kind: Kind,
    /// Whether the table makes no sense without it.
    pub required: bool,
    pub meaning: &'static str,
}

/// Which values a key may have.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// A number in a range, whose low end may be excluded.
    Number { above: bool, low: f64, high: f64, unit: &'static str },
    /// A whole number in a range.
    Whole { low: i64, high: i64, unit: &'static str },
    /// The same, or a word.
    WholeOr { word: &'static str, low: i64, high: i64, unit: &'static str },
    /// A text of 1 to so many characters, none of which ends a line.
    Text { most: usize, what: &'static str },
    /// One of some words.
    Word(&'static [&'static str]),
}

impl Kind {
    /// What is expected, in words.
    pub fn expected(&self) -> String {
        let of = |unit: &str| if unit.is_empty() { String::new() } else { format!(" {unit}") };
        match *self {
            Self::Number { above: true, low, high, unit } => {
                format!("a number above {low}, at most {high}{}", of(unit))
            }
            Self::Number { low, high, unit, .. } => format!("a number from {low} to {high}{}", of(unit)),
            Self::Whole { low, high, unit } => format!("a whole number from {low} to {high}{}", of(unit)),
            Self::WholeOr { word, low, high, unit } => {
                format!("a whole number from {low} to {high}{}, or \"{word}\"", of(unit))
            }
            Self::Text { most, what } => format!("{what} of 1 to {most} characters, in quotes"),
            Self::Word(words) => {
                let quoted: Vec<_> = words.iter().map(|word| format!("\"{word}\"")).collect();
                quoted.join(" or ")
            }
        }
    }
}

const fn number(
    name: &'static str,
    (low, high): (f64, f64),
    unit: &'static str,
    meaning: &'static str,
) -> Key {
    Key { name, kind: Kind::Number { above: false, low, high, unit }, required: false, meaning }
}

const fn positive(name: &'static str, high: f64, unit: &'static str, meaning: &'static str) -> Key {
    Key { name, kind: Kind::Number { above: true, low: 0.0, high, unit }, required: false, meaning }
}

const fn required(key: Key) -> Key {
    Key { required: true, ..key }
}

const fn table(name: &'static str, meaning: &'static str, keys: &'static [Key]) -> Table {
    Table { name, meaning, keys, tables: &[], numbered: None }
}

/// Longest name of a board or channel: what terminal and page have room for.
const NAME: Key = Key {
    name: "name",
    kind: Kind::Text { most: 24, what: "a name" },
    required: false,
    meaning: "what people call it",
};

const ZERO_COUNTS: Key = required(number(
    "zero_counts",
    (-16_777_215.0, 16_777_215.0),
    "counts",
    "reading at 0 kPa gauge; 102.4 of 1024 for the nominal sensor",
));
const KPA_PER_COUNT: Key = required(number(
    "kpa_per_count",
    (1e-6, 100.0),
    "kPa",
    "pressure of one converter step; 0.841645 for the nominal sensor of 100 psi",
));

static LIMITS: Table = table(
    "limits",
    "what may be commanded; of several limits for a channel the strictest holds",
    &[
        number("max_kpa", (0.0, 2000.0), "kPa gauge", "highest set point; what is above it is refused"),
        positive("max_rate_kpa_s", 1e6, "kPa/s", "fastest change of a set point; what is faster is ramped"),
    ],
);

static CALIBRATION: Table = table(
    "sensor",
    "calibration of these sensors, instead of the one above it in the file's hierarchy",
    &[ZERO_COUNTS, KPA_PER_COUNT],
);

static CHANNEL: Table = Table {
    name: "K",
    meaning: "a channel: a valve and its chamber",
    keys: &[NAME],
    tables: &[&LIMITS, &CALIBRATION, &CHAMBER, &OWN_VALVE],
    numbered: None,
};

static CHANNELS: Table = Table {
    name: "channels",
    meaning: "channels of a board, 0 to 3",
    keys: &[],
    tables: &[],
    numbered: Some(&Numbered { what: "channel", highest: crate::CHANNELS as u8 - 1, table: &CHANNEL }),
};

static BOARD: Table = Table {
    name: "N",
    meaning: "a board, by its number on the bus",
    keys: &[NAME],
    tables: &[&LIMITS, &CALIBRATION, &CHAMBER, &OWN_VALVE, &CONTROLLER, &CHANNELS],
    numbered: None,
};

static BOARDS: Table = Table {
    name: "boards",
    meaning: "boards, by their numbers on the bus",
    keys: &[],
    tables: &[],
    numbered: Some(&Numbered { what: "board", highest: 255, table: &BOARD }),
};

static BUS: Table = table(
    "bus",
    "how the boards are reached; the command line comes before it",
    &[
        Key {
            name: "port",
            kind: Kind::Text { most: 4096, what: "a serial port, or \"sim\" for virtual boards," },
            required: false,
            meaning: "serial port; a name in /dev/serial/by-id stays the same",
        },
        Key {
            name: "boards",
            kind: Kind::Whole { low: 1, high: 256, unit: "" },
            required: false,
            meaning: "boards on the bus, numbered from 0",
        },
        Key {
            name: "baud",
            kind: Kind::WholeOr { word: "auto", low: 1_200, high: 7_812_500, unit: "bit/s" },
            required: false,
            meaning: "line rate, \"auto\" for the fastest that all boards agree to; 1000000 unless said otherwise",
        },
        positive("rate_hz", 100_000.0, "Hz", "cycles per second; as fast as possible without it"),
    ],
);

static DISPLAY: Table = table(
    "display",
    "what people see; files and messages keep kPa",
    &[Key {
        name: "unit",
        kind: Kind::Word(&crate::Unit::NAMES),
        required: false,
        meaning: "unit of pressures on terminal and page",
    }],
);

static SUPPLY: Table = table(
    "supply",
    "compressed air before the fill valves",
    &[required(number(
        "pressure_kpa",
        (0.1, 2000.0),
        "kPa gauge (1 bar = 100 kPa, 1 psi = 6.895 kPa)",
        "nominal pressure",
    ))],
);

static AMBIENT: Table = table(
    "ambient",
    "the room into which the chambers vent",
    &[
        number("pressure_kpa_abs", (30.0, 120.0), "kPa absolute", "air pressure, near 101.325 at sea level"),
        number("temperature_k", (200.0, 400.0), "K (add 273.15 to degrees Celsius)", "of air and gas"),
    ],
);

static CHAMBER: Table = table(
    "chamber",
    "cylindrical chambers of a continuum joint, of length l = h +- r q, or vessels of constant volume",
    &[
        number("radius_m", (5e-4, 2.0), "m", "radius of the cylinder"),
        number("length_m", (5e-4, 10.0), "m", "length with the joint straight (h)"),
        number("offset_m", (0.0, 2.0), "m", "distance of the chamber's axis from the joint's (r)"),
        number("volume_m3", (1e-8, 10.0), "m^3 (1 litre is 0.001)", "constant volume, instead of the others"),
    ],
);

const DISCHARGE_COEFFICIENT: Key =
    number("discharge_coefficient", (0.05, 1.5), "", "C_d; 1 where areas are effective ones");
const CRITICAL_RATIO: Key = number("critical_ratio", (0.05, 0.7), "", "b of ISO 6358: 0.2 to 0.5 for valves");

static VALVE: Table =
    table("valve", "what is fixed of the flow through a valve", &[DISCHARGE_COEFFICIENT, CRITICAL_RATIO]);

/// Both keys, so that nobody has to know whether a missing one is that of `[valve]` or the usual
/// one.
static OWN_VALVE: Table = table(
    "valve",
    "the flow through these valves, instead of the table above it in the file's hierarchy",
    &[required(DISCHARGE_COEFFICIENT), required(CRITICAL_RATIO)],
);

static CONTROLLER: Table = table(
    "controller",
    "the pressure loop on the board, in 10-bit counts",
    &[
        required(number("rate_hz", (1.0, 100_000.0), "Hz", "rate of the board's loop")),
        required(number("kp", (1e-6, 1e6), "drive counts per pressure count", "proportional gain")),
        number("kd", (0.0, 1e6), "drive counts per count", "gain on the change between two samples"),
        required(number("saturation", (1e-6, 1e6), "drive counts", "drive at which the valve is fully open")),
        number("filter", (0.0, 0.9999), "", "weight of the previous sample; 0 for no filter"),
    ],
);

static SENSOR: Table = table(
    "sensor",
    "the pressure sensors and their converter: the calibration of every channel without its own",
    &[
        Key {
            name: "bits",
            kind: Kind::Whole { low: 4, high: 24, unit: "bit" },
            required: true,
            meaning: "resolution of the converter; 10 on the bus",
        },
        ZERO_COUNTS,
        KPA_PER_COUNT,
    ],
);

/// The file.
pub(crate) static FILE: Table = Table {
    name: "",
    meaning: "a PneuDrive rig: bus, limits, calibration, names, and what the machine is made of",
    keys: &[],
    tables: &[&BUS, &DISPLAY, &LIMITS, &SUPPLY, &AMBIENT, &CHAMBER, &VALVE, &CONTROLLER, &SENSOR, &BOARDS],
    numbered: None,
};
