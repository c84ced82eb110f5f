use crate::{Address, Counts};
use thiserror::Error;

/// Valves and chambers on one board.
pub const CHANNELS: usize = 4;
/// Bytes of a packet: one address word and four value words.
pub const PACKET_LEN: usize = 2 * (1 + CHANNELS);

/// A request (values are commands) or an answer (values are pressures).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Packet {
    /// The board that is asked, or that answers.
    pub address: Address,
    /// Commands or pressures of channels 0 to 3, in ADC counts.
    pub values: [Counts; CHANNELS],
}

/// Ten bytes that are no packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PacketError {
    /// The first word's high byte is not 0xFF.
    #[error("expected an address word 0xFF00 to 0xFFFF, got 0x{word:04X}")]
    NotAnAddress {
        /// The word that stands where the address should be.
        word: u16,
    },
    /// A value has more than 10 bits.
    #[error("expected value {index} to be 0 to 1023, got {word}")]
    ValueOutOfRange {
        /// Which of the four values, 0 to 3.
        index: usize,
        /// The word that stands there.
        word: u16,
    },
}

impl Packet {
    /// The ten bytes on the wire.
    pub fn encode(&self) -> [u8; PACKET_LEN] {
        let mut bytes = [0; PACKET_LEN];
        bytes[..2].copy_from_slice(&self.address.word().to_be_bytes());
        for (slot, value) in bytes[2..].chunks_exact_mut(2).zip(self.values) {
            slot.copy_from_slice(&value.get().to_be_bytes());
        }
        bytes
    }

    /// Reads ten bytes as a packet.
    pub fn decode(bytes: &[u8; PACKET_LEN]) -> Result<Self, PacketError> {
        let word = |index: usize| u16::from_be_bytes([bytes[2 * index], bytes[2 * index + 1]]);
        let address = Address::from_word(word(0)).ok_or(PacketError::NotAnAddress { word: word(0) })?;
        let mut values = [Counts::MIN; CHANNELS];
        for (index, value) in values.iter_mut().enumerate() {
            *value = Counts::new(word(index + 1))
                .map_err(|refused| PacketError::ValueOutOfRange { index, word: refused.value })?;
        }
        Ok(Self { address, values })
    }
}
