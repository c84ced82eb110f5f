use super::{Entry, NO_SUCH_ENTRY, PageEntry};
use crate::spare_bits::Kind;
use crate::{Address, CheckedPacket, Counts, PACKET_LEN, Packet, Seal, Sequence};

/// A host asks a board for an entry of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PageRequest {
    /// The board that is asked.
    pub address: Address,
    /// Page, 0 to 101.
    page: u8,
    /// Entry in it, 0 to 101.
    entry: u8,
    /// The last two digits of a value that is to be set, 0 to 101 each.
    digits: [u8; 2],
    /// The request's number.
    pub sequence: Sequence,
    /// Its place in a session, and `None` outside one.
    pub seal: Option<Seal>,
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
    /// That of the request.
    pub seal: Option<Seal>,
}

impl PageRequest {
    /// For this entry.
    pub const fn new(address: Address, entry: PageEntry, sequence: Sequence) -> Self {
        let [page, entry, high, low] = entry.words();
        Self { address, page, entry, digits: [high, low], sequence, seal: None }
    }

    /// The same in a session, with the seal's number.
    #[must_use]
    pub const fn sealed(self, seal: Seal) -> Self {
        Self { sequence: seal.number().sequence(), seal: Some(seal), ..self }
    }

    /// What is asked for; `None` if this version knows no such entry.
    #[inline]
    pub fn entry(&self) -> Option<PageEntry> {
        let [high, low] = self.digits;
        PageEntry::of_words([self.page, self.entry, high, low])
    }

    /// The ten bytes on the wire.
    pub fn encode(&self) -> [u8; PACKET_LEN] {
        CheckedPacket { packet: self.packet(), sequence: self.sequence }
            .encode_as(Kind::PageRequest, self.seal)
    }

    /// The answer to it with this entry, or with [`NO_SUCH_ENTRY`].
    pub fn answer(&self, words: Option<Entry>) -> PageAnswer {
        let words = words.unwrap_or(NO_SUCH_ENTRY);
        PageAnswer { address: self.address, words, sequence: self.sequence, seal: self.seal }
    }

    /// Its words as they stand in a packet.
    pub(crate) fn packet(&self) -> Packet {
        let word = |number: u8| Counts::saturating(number.into());
        let [high, low] = self.digits;
        Packet { address: self.address, values: [self.page, self.entry, high, low].map(word) }
    }

    /// `None` if its words are not those of a page request.
    pub(crate) fn of_packet(checked: &CheckedPacket, seal: Option<Seal>) -> Option<Self> {
        let Packet { address, values: [page, entry, high, low] } = checked.packet;
        // Each by itself: a loop takes longer than a board has.
        let below = |word: Counts| word < Counts::ATMOSPHERE;
        if !(below(page) && below(entry) && below(high) && below(low)) {
            return None;
        }
        // In range: a byte holds what is less than 102.
        let number = |word: Counts| word.get() as u8;
        let (page, entry, digits) = (number(page), number(entry), [number(high), number(low)]);
        let allowed = digits == [0, 0] || PageEntry::carries_value(page);
        allowed.then_some(Self { address, page, entry, digits, sequence: checked.sequence, seal })
    }
}

impl PageAnswer {
    /// The ten bytes on the wire.
    pub fn encode(&self) -> [u8; PACKET_LEN] {
        let packet = Packet { address: self.address, values: self.words };
        CheckedPacket { packet, sequence: self.sequence }.encode_as(Kind::PageAnswer, self.seal)
    }

    pub(crate) fn of_packet(checked: &CheckedPacket, seal: Option<Seal>) -> Self {
        let Packet { address, values: words } = checked.packet;
        Self { address, words, sequence: checked.sequence, seal }
    }
}
