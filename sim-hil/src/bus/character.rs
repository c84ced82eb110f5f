/// A UART character that a party has begun to send.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Character {
    /// Falling edge of the start bit, ns of virtual time.
    pub start_ns: u64,
    /// The eight data bits.
    pub byte: u8,
}

/// A character as a receiver has it, at the end of its stop bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heard {
    /// The eight data bits, right or wrong.
    pub byte: u8,
    /// Whether the receiver flags it (framing error): two drivers fought, or the driver let go too
    /// soon.
    pub damaged: bool,
}

/// Who drives the pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Talker {
    /// The bus master's adapter.
    Host,
    /// The board at this position of the rig.
    Board(usize),
    /// Nobody: coupled-in noise that receivers take for characters.
    Noise,
}

impl std::fmt::Display for Talker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Host => f.write_str("host"),
            Self::Board(index) => write!(f, "board at position {index}"),
            Self::Noise => f.write_str("noise"),
        }
    }
}
