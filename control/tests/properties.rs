//! Any bytes, at any times, with any samples.

use pneudrive_control::{AdcSample, Board, BoardConfig, BoardState, ChannelStatus, DirPwm, Micros};
use pneudrive_protocol::{Address, Counts, Packet};
use proptest::collection::vec;
use proptest::prelude::*;

/// What can happen to a board.
#[derive(Debug, Clone)]
enum Event {
    Byte(u8),
    Frame(Packet),
    Error,
    Idle,
    Step([u16; 4]),
}

fn any_packet() -> impl Strategy<Value = Packet> {
    (0..4_u8, any::<[u16; 4]>()).prop_map(|(board, values)| Packet {
        address: Address::of_board(board),
        values: values.map(|value| Counts::saturating(value % 1024)),
    })
}

fn any_event() -> impl Strategy<Value = Event> {
    prop_oneof![
        4 => prop_oneof![any::<u8>(), Just(0xFF), 0..4_u8].prop_map(Event::Byte),
        2 => any_packet().prop_map(Event::Frame),
        1 => Just(Event::Error),
        1 => Just(Event::Idle),
        2 => any::<[u16; 4]>().prop_map(Event::Step),
    ]
}

/// Distances between events, us: within a frame, around the gap, and far apart.
fn any_distance() -> impl Strategy<Value = u64> {
    prop_oneof![Just(10), 0..50_u64, 0..5_000_000_u64, any::<u64>()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Nothing panics (overflow checks are on), every answer has the board's own address and form,
    /// every drive is in range, and only the ten last bytes of a request to it make it answer.
    #[test]
    fn whatever_comes_a_board_answers_only_requests_to_it(
        events in vec((any_event(), any_distance()), 0..60),
        own in 0..4_u8,
    ) {
        let mut board = Board::new(BoardConfig::default(), Address::of_board(own)).unwrap();
        let mut now = 0_u64;
        let mut heard: Vec<u8> = Vec::new();
        for (event, distance) in events {
            now = now.saturating_add(distance);
            let bytes = match event {
                Event::Byte(byte) => vec![byte],
                Event::Frame(packet) => packet.encode().to_vec(),
                Event::Error => {
                    board.line_error(Micros::new(now));
                    heard.clear();
                    vec![]
                }
                Event::Idle => {
                    board.line_idle(Micros::new(now));
                    heard.clear();
                    vec![]
                }
                Event::Step(readings) => {
                    let drives = board.control_step(Micros::new(now), readings.map(AdcSample::from_reading));
                    for drive in drives {
                        prop_assert!((-400..=400).contains(&drive.get()));
                        // |coil| / 255 is |drive| / 400, cut off to a whole step.
                        let off = i32::from(DirPwm::from(drive).coil()) * 400 - i32::from(drive.get()) * 255;
                        prop_assert!(off.abs() < 400);
                    }
                    vec![]
                }
            };
            for byte in bytes {
                now = now.saturating_add(10);
                heard.push(byte);
                if let Some(answer) = board.receive_byte(Micros::new(now), byte) {
                    let request: [u8; 10] = heard[heard.len() - 10..].try_into().unwrap();
                    let request = Packet::decode(&request).unwrap();
                    prop_assert_eq!(request.address, Address::of_board(own));
                    prop_assert_eq!(request.values, board.status().commands);
                    let answer = Packet::decode(&answer).unwrap();
                    prop_assert_eq!(answer.address, Address::of_board(own));
                    prop_assert_eq!(answer.values, board.status().pressures);
                }
            }
        }
    }

    /// After any noise, a request that follows an idle gap is answered (unless it speaks into the
    /// answer to a request that the noise contained).
    #[test]
    fn a_request_after_a_gap_is_always_answered(
        noise in vec(any::<u8>(), 0..40),
        gap_us in 30..10_000_u64,
        commands in any::<[u16; 4]>(),
    ) {
        let mut board = Board::new(BoardConfig::default(), Address::of_board(0)).unwrap();
        let mut now = 1_000;
        board.control_step(Micros::new(now), [AdcSample::from(Counts::ATMOSPHERE); 4]);
        let mut answered_noise = false;
        for byte in noise {
            now += 10;
            answered_noise |= board.receive_byte(Micros::new(now), byte).is_some();
        }
        prop_assume!(!answered_noise);
        now += gap_us;
        let values = commands.map(|value| Counts::saturating(value % 1024));
        let mut answers = 0;
        for byte in (Packet { address: Address::of_board(0), values }).encode() {
            now += 10;
            answers += usize::from(board.receive_byte(Micros::new(now), byte).is_some());
        }
        prop_assert_eq!(answers, 1);
        prop_assert_eq!(board.status().commands, values);
    }

    /// A channel that vents for its own or the board's reasons is driven fully, and only then.
    #[test]
    fn the_status_says_what_the_valves_do(
        steps in vec(any::<[u16; 4]>(), 1..200),
        period in 100..20_000_u64,
        request_every in 1..400_usize,
    ) {
        let config = BoardConfig { power_up_vent: Micros::from_millis(100), ..BoardConfig::default() };
        let mut board = Board::new(config, Address::of_board(0)).unwrap();
        for (index, readings) in steps.into_iter().enumerate() {
            let now = Micros::new(period * index as u64);
            if index % request_every == 0 {
                let request = Packet { address: Address::of_board(0), values: [Counts::saturating(300); 4] };
                for byte in request.encode() {
                    board.receive_byte(now, byte);
                }
            }
            let drives = board.control_step(now, readings.map(|code| AdcSample::from_reading(code % 4096)));
            let status = board.status();
            for (drive, channel) in drives.into_iter().zip(status.channels) {
                match channel {
                    ChannelStatus::Regulating => {
                        prop_assert!(matches!(status.state, BoardState::Running | BoardState::Hold));
                    }
                    ChannelStatus::Venting => {
                        prop_assert!(matches!(status.state, BoardState::PowerUpVent | BoardState::Vent));
                        prop_assert_eq!(drive.get(), -400);
                    }
                    ChannelStatus::SensorFault(_) => prop_assert_eq!(drive.get(), -400),
                    ChannelStatus::Disabled => prop_assert!(false, "no channel is disabled"),
                }
            }
        }
    }
}
