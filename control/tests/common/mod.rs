//! A board on a bench: a bus at 1 Mbaud, and one sample for all four sensors.

use pneudrive_control::{AdcSample, Answer, Board, BoardConfig, Micros, ValveDrive};
use pneudrive_protocol::{Address, CHANNELS, Counts, Packet};

/// Time of a character at 1 Mbaud, us.
pub const CHARACTER_US: u64 = 10;
/// Time between two control steps, us.
pub const STEP_US: u64 = 1_000;

pub struct Bench {
    pub board: Board,
    /// Time of the last byte or control step, us.
    pub now_us: u64,
    /// What the four sensors read.
    pub samples: [AdcSample; CHANNELS],
}

pub fn counts(value: u16) -> Counts {
    Counts::new(value).unwrap()
}

pub fn packet(board: u8, values: [u16; CHANNELS]) -> Packet {
    Packet { address: Address::of_board(board), values: values.map(counts) }
}

impl Bench {
    pub fn new(config: BoardConfig, board: u8) -> Self {
        let board = Board::new(config, Address::of_board(board)).unwrap();
        Self { board, now_us: 0, samples: [AdcSample::from(Counts::ATMOSPHERE); CHANNELS] }
    }

    /// Past the power-up vent, with its first request answered.
    pub fn running() -> Self {
        let mut bench = Self::new(BoardConfig::default(), 0);
        bench.steps(2_001);
        bench.request([102; CHANNELS]).unwrap();
        bench
    }

    /// All four sensors read this from now on.
    pub fn read(&mut self, value: u16) {
        self.samples = [AdcSample::from(counts(value)); CHANNELS];
    }

    pub fn wait_us(&mut self, us: u64) {
        self.now_us += us;
    }

    /// One control step, one period after the last.
    pub fn step(&mut self) -> [i16; CHANNELS] {
        self.now_us += STEP_US;
        self.board.control_step(Micros::new(self.now_us), self.samples).map(ValveDrive::get)
    }

    /// This many control steps; gives the last drives.
    pub fn steps(&mut self, steps: usize) -> [i16; CHANNELS] {
        (0..steps).map(|_| self.step()).last().unwrap()
    }

    /// Bytes back to back; gives every answer to unchecked requests.
    pub fn bytes(&mut self, bytes: &[u8]) -> Vec<Packet> {
        self.raw_bytes(bytes).iter().map(|answer| Packet::decode(answer).unwrap()).collect()
    }

    /// Bytes back to back; gives every answer as it is sent.
    pub fn raw_bytes(&mut self, bytes: &[u8]) -> Vec<Answer> {
        let mut answers = Vec::new();
        for &byte in bytes {
            self.now_us += CHARACTER_US;
            if let Some(answer) = self.board.receive_byte(Micros::new(self.now_us), byte) {
                answers.push(answer);
            }
        }
        answers
    }

    /// A request to the board, and time for its answer; gives the pressures answered.
    pub fn request(&mut self, commands: [u16; CHANNELS]) -> Option<[u16; CHANNELS]> {
        let own = self.board.address();
        let request = Packet { address: own, values: commands.map(counts) };
        let answers = self.bytes(&request.encode());
        assert!(answers.len() <= 1);
        self.wait_us(100 + 50);
        answers.first().map(|answer| {
            assert_eq!(answer.address, own);
            answer.values.map(Counts::get)
        })
    }
}
