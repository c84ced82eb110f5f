/// The kinds of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FaultKind {
    /// One data bit of a character is inverted; no receiver notices.
    BitFlip,
    /// A character is lost.
    Drop,
    /// A character comes twice.
    Duplicate,
    /// The adapter holds a character back, and with it all that follow.
    Delay,
    /// The host hears its own bytes.
    Echo,
    /// One random character that nobody sent.
    Stray,
    /// A burst of random characters that spoils what is being said.
    Noise,
    /// A board is off the bus for a while (powered, hearing nothing, heard by nobody).
    Unplug,
    /// A board sends without end for a while.
    Babble,
    /// A board loses its supply for a while: valves vent, and it starts from reset.
    PowerCycle,
}

/// What the rate of a fault counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateUnit {
    /// Probability for each character, 0 to 1.
    Character,
    /// Probability for each uninterrupted run of host bytes, 0 to 1.
    Request,
    /// Mean number of times a second.
    Second,
}

impl FaultKind {
    /// Every kind, in the order of the list that `pneudrive-sim faults` prints.
    pub const ALL: [Self; 10] = [
        Self::BitFlip,
        Self::Drop,
        Self::Duplicate,
        Self::Delay,
        Self::Echo,
        Self::Stray,
        Self::Noise,
        Self::Unplug,
        Self::Babble,
        Self::PowerCycle,
    ];

    /// The name on the command line and in the counters.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BitFlip => "bit_flip",
            Self::Drop => "drop",
            Self::Duplicate => "duplicate",
            Self::Delay => "delay",
            Self::Echo => "echo",
            Self::Stray => "stray",
            Self::Noise => "noise",
            Self::Unplug => "unplug",
            Self::Babble => "babble",
            Self::PowerCycle => "power_cycle",
        }
    }

    /// What its rate counts.
    pub const fn rate_unit(self) -> RateUnit {
        match self {
            Self::BitFlip | Self::Drop | Self::Duplicate | Self::Delay => RateUnit::Character,
            Self::Echo => RateUnit::Request,
            Self::Stray | Self::Noise | Self::Unplug | Self::Babble | Self::PowerCycle => RateUnit::Second,
        }
    }

    /// How long it lasts unless `ms=` says otherwise, ns; `None` where it has no duration.
    pub const fn default_duration_ns(self) -> Option<u64> {
        match self {
            Self::BitFlip | Self::Drop | Self::Duplicate | Self::Echo | Self::Stray => None,
            // The late answer after which the original host lost step with its boards.
            Self::Delay => Some(3_200_000),
            Self::Noise => Some(1_000_000),
            Self::Unplug => Some(1_000_000_000),
            Self::Babble => Some(50_000_000),
            Self::PowerCycle => Some(500_000_000),
        }
    }

    /// Whether `on=requests` or `on=answers` makes sense.
    pub const fn has_path(self) -> bool {
        matches!(self.rate_unit(), RateUnit::Character)
    }

    /// Whether `board=` makes sense.
    pub const fn has_board(self) -> bool {
        matches!(self, Self::Unplug | Self::Babble | Self::PowerCycle)
    }

    /// One line on what it does.
    pub const fn summary(self) -> &'static str {
        match self {
            Self::BitFlip => "one data bit of a character is inverted",
            Self::Drop => "a character is lost",
            Self::Duplicate => "a character comes twice",
            Self::Delay => "the adapter holds a character back, and all that follow it",
            Self::Echo => "the host hears its own bytes",
            Self::Stray => "one random character that nobody sent",
            Self::Noise => "a burst of random characters, on top of what is being said",
            Self::Unplug => "a board is off the bus: powered, but deaf and mute",
            Self::Babble => "a board sends random characters without end",
            Self::PowerCycle => "a board loses its supply: valves vent, it starts from reset",
        }
    }

    /// A specification to copy.
    pub const fn example(self) -> &'static str {
        match self {
            Self::BitFlip => "bit_flip=1e-4,on=answers",
            Self::Drop => "drop=0.001",
            Self::Duplicate => "duplicate@2.5,on=requests",
            Self::Delay => "delay@1.0,on=answers,ms=3.2",
            Self::Echo => "echo=1",
            Self::Stray => "stray=10",
            Self::Noise => "noise=2,ms=0.5",
            Self::Unplug => "unplug@3,board=1,ms=800",
            Self::Babble => "babble=0.2,board=0,ms=20",
            Self::PowerCycle => "power_cycle@5,board=2",
        }
    }
}

impl RateUnit {
    /// As it stands in the list.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Character => "probability for each character",
            Self::Request => "probability for each request",
            Self::Second => "times a second",
        }
    }
}
