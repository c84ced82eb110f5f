/// A 4-bit counter: an answer carries that of its request, so late, repeated and crossed answers
/// are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Sequence(u8);

impl Sequence {
    /// The number of different values.
    pub const MODULUS: u8 = 16;

    /// `number` modulo 16.
    pub const fn new(number: u8) -> Self {
        Self(number % Self::MODULUS)
    }

    /// 0 to 15.
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The one after it; 15 is followed by 0.
    #[must_use]
    pub const fn next(self) -> Self {
        Self::new(self.0 + 1)
    }
}
