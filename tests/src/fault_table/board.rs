use super::truth::{SharedTruth, Words};
use pneudrive_protocol::{Address, Asked, Baud, PACKET_LEN, RequestDecoder};
use pneudrive_sim::bus::{Air, BusNode, Character, Heard};
use std::collections::VecDeque;

/// A board, with somebody listening at its connector.
pub(super) struct SpiedBoard {
    board: Box<dyn BusNode + Send>,
    index: usize,
    truth: SharedTruth,
    /// What it heard lately, and when each stop bit ended, ns.
    heard: VecDeque<(u64, u8)>,
    answer: Vec<u8>,
    answer_begins_ns: u64,
    answer_ends_ns: u64,
}

impl SpiedBoard {
    /// Time from power-on to the end of the power-up vent, ns: 2 s after the first control step.
    pub(super) const POWER_UP_NS: u64 = 2_128_000_000;
    /// An answer begins so long after the request that it answers, ns.
    const TURNAROUND_NS: std::ops::Range<u64> = 12_500..21_000;
    const CHARACTER_NS: u64 = 10_000;
    const HEARD_KEPT: usize = 32;

    pub(super) fn new(board: Box<dyn BusNode + Send>, index: usize, truth: SharedTruth) -> Self {
        truth.lock().board_vents(index, 0, Self::POWER_UP_NS);
        Self {
            board,
            index,
            truth,
            heard: VecDeque::new(),
            answer: Vec::new(),
            answer_begins_ns: 0,
            answer_ends_ns: 0,
        }
    }

    /// A board that begins to answer has obeyed a request: the one among what it has heard that
    /// ended a turnaround ago.
    fn answer_begins(&mut self, at_ns: u64) {
        let address = self.board.address();
        let bytes: Vec<u8> = self.heard.iter().map(|&(_, byte)| byte).collect();
        let request = bytes.windows(PACKET_LEN).zip(self.heard.iter().skip(PACKET_LEN - 1)).rev().find_map(
            |(window, &(ended_ns, _))| {
                let fits = Self::TURNAROUND_NS.contains(&at_ns.saturating_sub(ended_ns));
                let words = Words::of(window.try_into().ok()?)?;
                (fits && words.packet.address == address).then_some((words, is_page(address, window)))
            },
        );
        // A page request commands nothing.
        if request.is_some_and(|(_, is_page)| is_page) {
            return;
        }
        let request = request.map(|(words, _)| words);
        self.truth.lock().board_obeys(self.index, at_ns, request);
    }

    fn says(&mut self, character: Character) {
        if self.answer.is_empty() || character.start_ns > self.answer_ends_ns + Self::CHARACTER_NS / 2 {
            self.answer.clear();
            self.answer_begins_ns = character.start_ns;
            self.answer_begins(character.start_ns);
        }
        self.answer_ends_ns = character.start_ns + Self::CHARACTER_NS;
        self.answer.push(character.byte);
        let Ok(bytes) = <&[u8; PACKET_LEN]>::try_from(self.answer.as_slice()) else { return };
        let said = Words::of(bytes);
        self.answer.clear();
        if let Some(words) = said {
            self.truth.lock().board_says(self.index, self.answer_begins_ns, words.packet.values);
        }
    }
}

fn is_page(address: Address, bytes: &[u8]) -> bool {
    let mut decoder = RequestDecoder::new(address);
    matches!(bytes.iter().filter_map(|&byte| decoder.push(byte)).last(), Some(Asked::Page(_)))
}

impl BusNode for SpiedBoard {
    fn address(&self) -> Address {
        self.board.address()
    }

    fn baud(&self) -> Option<Baud> {
        self.board.baud()
    }

    fn set_shortest_character(&mut self, ns: u64) {
        self.board.set_shortest_character(ns);
    }

    fn next_event_ns(&self) -> u64 {
        self.board.next_event_ns()
    }

    fn advance(&mut self, now_ns: u64, air: &mut dyn Air) {
        self.board.advance(now_ns, air);
    }

    fn transmit(&mut self) -> Option<Character> {
        let character = self.board.transmit()?;
        self.says(character);
        Some(character)
    }

    fn receive(&mut self, now_ns: u64, heard: Heard) {
        self.heard.push_back((now_ns, heard.byte));
        if self.heard.len() > Self::HEARD_KEPT {
            self.heard.pop_front();
        }
        self.board.receive(now_ns, heard);
    }

    fn set_powered(&mut self, powered: bool, now_ns: u64, air: &mut dyn Air) {
        let until_ns = if powered { now_ns + Self::POWER_UP_NS } else { u64::MAX };
        self.truth.lock().board_vents(self.index, now_ns, until_ns);
        self.answer.clear();
        self.board.set_powered(powered, now_ns, air);
    }
}
