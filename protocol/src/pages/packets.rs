use super::{Entry, NO_SUCH_ENTRY, PageEntry};
use crate::spare_bits::Kind;
use crate::{Address, CheckedPacket, Counts, PACKET_LEN, Packet, Sequence};

/// A host asks a board for an entry of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PageRequest {
    /// The board that is asked.
    pub address: Address,
    /// Page, 0 to 101.
    page: u8,
    /// Entry in it, 0 to 101.
    entry: u8,
    /// The request's number.
    pub sequence: Sequence,
}

/// A board answers a page request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PageAnswer {
    /// The board.
    pub address: Address,
    /// The entry, or [`NO_SUCH_ENTRY`].
    pub words: Entry,
    /// The request's number.
    pub sequence: Sequence,
}

impl PageRequest {
    /// For this entry.
    pub const fn new(address: Address, entry: PageEntry, sequence: Sequence) -> Self {
        let (page, entry) = entry.numbers();
        Self { address, page, entry, sequence }
    }

    /// What is asked for; `None` if this version knows no such entry.
    pub fn entry(&self) -> Option<PageEntry> {
        PageEntry::of_numbers(self.page, self.entry)
    }

    /// The ten bytes on the wire.
    pub fn encode(&self) -> [u8; PACKET_LEN] {
        CheckedPacket { packet: self.packet(), sequence: self.sequence }.encode_as(Kind::PageRequest)
    }

    /// The answer to it with this entry, or with [`NO_SUCH_ENTRY`].
    pub fn answer(&self, words: Option<Entry>) -> PageAnswer {
        PageAnswer { address: self.address, words: words.unwrap_or(NO_SUCH_ENTRY), sequence: self.sequence }
    }

    /// Its words as they stand in a packet.
    pub(crate) fn packet(&self) -> Packet {
        let word = |number: u8| Counts::saturating(number.into());
        Packet {
            address: self.address,
            values: [word(self.page), word(self.entry), Counts::MIN, Counts::MIN],
        }
    }

    /// `None` if its words are not those of a page request.
    pub(crate) fn of_packet(checked: &CheckedPacket) -> Option<Self> {
        let Packet { address, values: [page, entry, Counts::MIN, Counts::MIN] } = checked.packet else {
            return None;
        };
        let number = |word: Counts| u8::try_from(word.get()).ok().filter(|_| word < Counts::ATMOSPHERE);
        Some(Self { address, page: number(page)?, entry: number(entry)?, sequence: checked.sequence })
    }
}

impl PageAnswer {
    /// The ten bytes on the wire.
    pub fn encode(&self) -> [u8; PACKET_LEN] {
        let packet = Packet { address: self.address, values: self.words };
        CheckedPacket { packet, sequence: self.sequence }.encode_as(Kind::PageAnswer)
    }

    pub(crate) fn of_packet(checked: &CheckedPacket) -> Self {
        Self { address: checked.packet.address, words: checked.packet.values, sequence: checked.sequence }
    }
}
