//! Colours that differ for colour-blind readers too: the palette of Okabe and Ito (2008), darkened
//! where thin lines on white need it.

/// A line's or a mark's colour, by meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// What was measured.
    Measured,
    /// What was commanded.
    Command,
    /// First of several results.
    Blue,
    /// Second.
    Orange,
    /// Third.
    Green,
    /// Fourth.
    Purple,
    /// Fifth, and warnings.
    Red,
}

impl Colour {
    /// Colours for results, in order of use.
    pub const RESULTS: [Self; 5] = [Self::Blue, Self::Orange, Self::Green, Self::Purple, Self::Red];

    /// Red, green and blue, 0 to 255.
    #[must_use]
    pub const fn rgb(self) -> (u8, u8, u8) {
        match self {
            Self::Measured => (30, 30, 30),
            Self::Command => (150, 150, 150),
            Self::Blue => (0, 114, 178),
            Self::Orange => (213, 120, 0),
            Self::Green => (0, 138, 100),
            Self::Purple => (170, 90, 140),
            Self::Red => (200, 50, 30),
        }
    }

    /// As CSS writes it.
    #[must_use]
    pub fn css(self) -> String {
        let (r, g, b) = self.rgb();
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
