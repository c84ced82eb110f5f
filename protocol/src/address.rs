use core::fmt;

/// The bus address of one board: the word 0xFFFF - n for board n.
///
/// The high byte is always 0xFF, which no data word has (values end at 1023, checked frames at
/// 0x7FFF), so a whole word tells an address from data. A single byte does not: data words may end
/// in 0xFF.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
// As the board's number.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Address(u8);

impl Address {
    /// The high byte of every address word.
    pub const HIGH_BYTE: u8 = 0xFF;

    /// Address of board `board`. The boards' two-way switch selects 0 to 3; the bus has room
    /// for 256.
    pub const fn of_board(board: u8) -> Self {
        Self(board)
    }

    /// Address of the board whose two-way switch stands so: both open is board 0, the first closed
    /// adds 1, the second adds 2.
    pub const fn of_switch(first_closed: bool, second_closed: bool) -> Self {
        Self(first_closed as u8 | (second_closed as u8) << 1)
    }

    /// The board's number, 0 to 255.
    pub const fn board(self) -> u8 {
        self.0
    }

    /// The word on the wire, 0xFFFF - n.
    pub const fn word(self) -> u16 {
        0xFFFF - self.0 as u16
    }

    /// The address that `word` stands for, or `None` where its high byte is not 0xFF.
    pub const fn from_word(word: u16) -> Option<Self> {
        if word >> 8 == Self::HIGH_BYTE as u16 { Some(Self((0xFFFF - word) as u8)) } else { None }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "board {} (0x{:04X})", self.0, self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::Address;

    #[test]
    fn the_four_switch_positions_are_the_top_four_words() {
        let words = [0, 1, 2, 3].map(|n| Address::of_board(n).word());
        assert_eq!(words, [0xFFFF, 0xFFFE, 0xFFFD, 0xFFFC]);
    }

    #[test]
    fn the_switch_counts_in_binary() {
        let positions = [(false, false), (true, false), (false, true), (true, true)];
        assert_eq!(positions.map(|(first, second)| Address::of_switch(first, second).board()), [0, 1, 2, 3]);
    }

    #[test]
    fn every_word_is_an_address_or_not() {
        for word in 0..=u16::MAX {
            match Address::from_word(word) {
                Some(address) => assert_eq!(address.word(), word),
                None => assert!(word < 0xFF00),
            }
        }
    }
}
