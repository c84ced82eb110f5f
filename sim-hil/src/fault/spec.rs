use super::kind::RateUnit;
use super::{FaultError, FaultKind};
use std::str::FromStr;

/// One fault to inject: `KIND=RATE` or `KIND@SECONDS`, then options `,ms=`, `,on=`, `,board=`.
///
/// ```
/// use pneudrive_sim::fault::{FaultKind, FaultSpec, When};
///
/// let spec: FaultSpec = "unplug@3,board=1,ms=800".parse()?;
/// assert_eq!((spec.kind, spec.when), (FaultKind::Unplug, When::At { time_ns: 3_000_000_000 }));
/// assert_eq!((spec.board, spec.duration_ns), (Some(1), 800_000_000));
/// # Ok::<(), pneudrive_sim::fault::FaultError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FaultSpec {
    /// What happens.
    pub kind: FaultKind,
    /// How often, or when.
    pub when: When,
    /// Which way, for faults of the adapter.
    pub path: Path,
    /// Position of the board, for faults of a board; `None` draws one each time.
    pub board: Option<usize>,
    /// How long it lasts, or holds back, ns; 0 for kinds without duration.
    pub duration_ns: u64,
}

/// How often, or when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum When {
    /// At random, in the unit of [`FaultKind::rate_unit`].
    Rate(f64),
    /// Once, at this time; an adapter's fault meets the first character from then on.
    At {
        /// ns of virtual time.
        time_ns: u64,
    },
}

/// Which way through the host's adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Path {
    /// Both ways.
    #[default]
    Both,
    /// From the host to the boards.
    Requests,
    /// From the boards to the host.
    Answers,
}

impl Path {
    pub(super) fn covers(self, other: Self) -> bool {
        self == Self::Both || self == other
    }
}

impl FaultSpec {
    /// Longest duration and latest time, s.
    const SECONDS_MAX: f64 = 1e6;
    /// Most episodes a second; more than one a character time at 1 Mbaud would be no episodes any
    /// more.
    const PER_SECOND_MAX: f64 = 1e5;

    fn option(&mut self, text: &str) -> Result<(), FaultError> {
        let kind = self.kind;
        let refuse = || FaultError::Option { kind, option: text.to_owned(), expected: options_of(kind) };
        let (name, value) = text.split_once('=').ok_or_else(refuse)?;
        match name {
            "ms" if kind.default_duration_ns().is_some() => {
                self.duration_ns = seconds(value, 1e-3).filter(|&ns| ns > 0).ok_or_else(refuse)?;
            }
            "on" if kind.has_path() => {
                self.path = match value {
                    "requests" => Path::Requests,
                    "answers" => Path::Answers,
                    "both" => Path::Both,
                    _ => return Err(refuse()),
                };
            }
            "board" if kind.has_board() => self.board = Some(value.parse().map_err(|_| refuse())?),
            _ => return Err(refuse()),
        }
        Ok(())
    }
}

impl FromStr for FaultSpec {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        let (head, options) = text.split_once(',').map_or((text, None), |(head, rest)| (head, Some(rest)));
        let mark = head.find(['=', '@']).ok_or_else(|| FaultError::Form { text: text.to_owned() })?;
        let (name, value) = (&head[..mark], &head[mark + 1..]);
        let kind = kind_by_name(name)?;
        let when = if head.as_bytes()[mark] == b'@' {
            let time =
                seconds(value, 1.0).ok_or_else(|| FaultError::Time { kind, value: value.to_owned() })?;
            When::At { time_ns: time }
        } else {
            When::Rate(rate(kind, value)?)
        };
        let duration_ns = kind.default_duration_ns().unwrap_or(0);
        let mut spec = Self { kind, when, path: Path::Both, board: None, duration_ns };
        for option in options.into_iter().flat_map(|options| options.split(',')) {
            spec.option(option)?;
        }
        Ok(spec)
    }
}

fn kind_by_name(name: &str) -> Result<FaultKind, FaultError> {
    if let Some(kind) = FaultKind::ALL.into_iter().find(|kind| kind.name() == name) {
        return Ok(kind);
    }
    let similarity = |kind: &FaultKind| strsim::jaro_winkler(kind.name(), name);
    let nearest = FaultKind::ALL.into_iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    Err(FaultError::UnknownKind {
        name: name.to_owned(),
        nearest: nearest.map_or("bit_flip", FaultKind::name),
    })
}

fn rate(kind: FaultKind, value: &str) -> Result<f64, FaultError> {
    let (max, expected) = match kind.rate_unit() {
        RateUnit::Character => (1.0, "a probability for each character, 0 to 1"),
        RateUnit::Request => (1.0, "a probability for each request, 0 to 1"),
        RateUnit::Second => (FaultSpec::PER_SECOND_MAX, "a number of times a second, 0 to 1e5"),
    };
    let rate = value.parse::<f64>().ok().filter(|rate| (0.0..=max).contains(rate));
    rate.ok_or_else(|| FaultError::Rate { kind, value: value.to_owned(), expected })
}

/// A number of `unit` seconds as ns.
fn seconds(value: &str, unit: f64) -> Option<u64> {
    let seconds = value.parse::<f64>().ok()? * unit;
    (0.0..=FaultSpec::SECONDS_MAX).contains(&seconds).then(|| (seconds * 1e9).round() as u64)
}

fn options_of(kind: FaultKind) -> String {
    let mut options = Vec::new();
    if kind.default_duration_ns().is_some() {
        options.push("ms=NUMBER above 0");
    }
    if kind.has_path() {
        options.push("on=requests, on=answers, on=both");
    }
    if kind.has_board() {
        options.push("board=POSITION");
    }
    if options.is_empty() { "none".to_owned() } else { options.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        text.parse::<FaultSpec>().unwrap_err().to_string()
    }

    #[test]
    fn every_example_in_the_list_parses_to_its_own_kind() {
        for kind in FaultKind::ALL {
            assert_eq!(kind.example().parse::<FaultSpec>().unwrap().kind, kind);
        }
    }

    #[test]
    fn refusals_say_what_would_be_right() {
        assert_eq!(
            refusal("bitflip=0.1"),
            "there is no fault 'bitflip'; the nearest is 'bit_flip' (pneudrive-sim faults lists them all)"
        );
        assert_eq!(
            refusal("drop"),
            "fault 'drop' is neither KIND=RATE nor KIND@SECONDS, as in bit_flip=1e-4 or unplug@3,board=1"
        );
        assert_eq!(
            refusal("drop=2"),
            "fault drop: rate '2' must be a probability for each character, 0 to 1"
        );
        assert_eq!(
            refusal("noise=NaN"),
            "fault noise: rate 'NaN' must be a number of times a second, 0 to 1e5"
        );
        assert_eq!(refusal("stray@-1"), "fault stray: time '-1' must be a number of seconds from 0 to 1e6");
        assert_eq!(refusal("echo=1,board=2"), "fault echo: option 'board=2' must be one of none");
        assert_eq!(
            refusal("unplug=1,ms=0"),
            "fault unplug: option 'ms=0' must be one of ms=NUMBER above 0, board=POSITION"
        );
        assert!(refusal("drop=0.1,on=sideways").contains("on=requests, on=answers, on=both"));
        assert!(refusal("drop=0.1,").contains("option ''"));
    }
}
