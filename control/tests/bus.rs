//! The bus responder: what is answered, with what, and what is not.

use crate::common::{Bench, counts, packet};
use pneudrive_control::{BoardConfig, Micros};
use pneudrive_protocol::{Baud, CheckedPacket, Direction, Packet, Sequence};

#[test]
fn the_answer_carries_the_pressures_of_the_last_control_step() {
    let mut bench = Bench::new(BoardConfig { filter_previous: 0, ..BoardConfig::default() }, 2);
    bench.read(300);
    bench.step();
    bench.read(400);
    assert_eq!(bench.request([102; 4]), Some([300; 4]));
    bench.step();
    assert_eq!(bench.request([102; 4]), Some([400; 4]));
}

#[test]
fn commands_take_effect_in_the_next_control_step() {
    let mut bench = Bench::running();
    bench.request([103, 112, 92, 102]).unwrap();
    assert_eq!(bench.step(), [10, 100, -100, 0]);
}

#[test]
fn an_idle_gap_of_three_characters_starts_a_frame_and_a_shorter_pause_does_not() {
    let request = packet(0, [200; 4]).encode();
    for pause_us in 0..=40 {
        // Five bytes, a pause, a whole request.
        let mut cut = Bench::running();
        cut.bytes(&request[..5]);
        cut.wait_us(pause_us);
        let found = cut.bytes(&request).len();
        // The same request with a pause in it.
        let mut paused = Bench::running();
        paused.bytes(&request[..5]);
        paused.wait_us(pause_us);
        let whole = paused.bytes(&request[5..]).len();
        match pause_us {
            0..25 => assert_eq!(whole, 1, "a pause of {pause_us} us"),
            25..30 => {}
            _ => assert_eq!((found, whole), (1, 0), "a gap of {pause_us} us"),
        }
    }
}

#[test]
fn a_gap_that_the_caller_reports_counts_whatever_the_stamps_say() {
    let request = packet(0, [200; 4]).encode();
    // Nine bytes and the first of the next request would make a valid packet.
    let mut told = Bench::running();
    told.bytes(&request[..9]);
    told.board.line_idle(Micros::new(told.now_us));
    assert_eq!(told.bytes(&request).len(), 1);
    assert_eq!(told.board.status().commands, [counts(200); 4]);

    let mut untold = Bench::running();
    untold.bytes(&request[..9]);
    assert_eq!(untold.bytes(&request[..1]).len(), 1, "what would happen otherwise");
    assert_eq!(untold.board.status().commands[3], counts(255));
}

#[test]
fn a_damaged_byte_costs_its_frame_and_is_counted() {
    let request = packet(0, [200; 4]).encode();
    let mut bench = Bench::running();
    bench.bytes(&request[..9]);
    bench.wait_us(10);
    bench.board.line_error(Micros::new(bench.now_us));
    assert_eq!(bench.bytes(&request[9..]), []);
    assert_eq!(bench.board.status().counters.line_errors, 1);
    assert!(bench.request([200; 4]).is_some());
}

#[test]
fn only_the_board_with_the_address_answers() {
    for own in [0, 1, 2, 3, 255] {
        let mut bench = Bench::new(BoardConfig::default(), own);
        bench.step();
        for asked in 0..=255 {
            let answers = bench.bytes(&packet(asked, [300; 4]).encode());
            let expected = if asked == own { vec![packet(own, [102; 4])] } else { vec![] };
            assert_eq!(answers, expected, "board {own}, request to {asked}");
            bench.wait_us(150);
        }
    }
}

/// Four boards polled without any pause: the wire's limit.
#[test]
fn back_to_back_polling_of_four_boards_loses_nothing() {
    let mut benches = [0, 1, 2, 3].map(|board| Bench::new(BoardConfig::default(), board));
    for bench in &mut benches {
        bench.step();
    }
    for cycle in 0..100_u16 {
        for asked in 0..4 {
            let say = |benches: &mut [Bench; 4], bytes: [u8; 10], speaker: Option<u8>| -> Vec<Packet> {
                let mut answers = Vec::new();
                for (own, bench) in (0..).zip(benches) {
                    if speaker == Some(own) {
                        bench.wait_us(100);
                    } else {
                        answers.extend(bench.bytes(&bytes));
                    }
                }
                answers
            };
            let request = packet(asked, [cycle, 255, 511, 1023]).encode();
            let answers = say(&mut benches, request, None);
            // All boards' clocks are one: the answer begins after 14 us.
            benches.iter_mut().for_each(|bench| bench.wait_us(14));
            assert_eq!(answers, [packet(asked, [102; 4])]);
            assert_eq!(say(&mut benches, answers[0].encode(), Some(asked)), []);
        }
    }
}

/// 115,200 baud: 87 us a character, an idle gap of 260 us.
#[test]
fn the_gap_follows_the_baud_rate() {
    let request = packet(0, [200; 4]).encode();
    let answers_with_a_pause = |pause_us: u64| {
        let config = BoardConfig { baud: Baud::new(115_200).unwrap(), ..BoardConfig::default() };
        let mut bench = Bench::new(config, 0);
        bench.step();
        let mut answers = 0;
        for (index, byte) in request.into_iter().enumerate() {
            bench.wait_us(87 + if index == 5 { pause_us } else { 0 });
            answers += usize::from(bench.board.receive_byte(Micros::new(bench.now_us), byte).is_some());
        }
        answers
    };
    assert_eq!(answers_with_a_pause(200), 1);
    assert_eq!(answers_with_a_pause(261), 0);
}

/// A board answers in the format it was asked in, with the request's number; once its host is known
/// to check, an unchecked request is ignored, until the host has been silent for the command
/// timeout.
#[test]
fn a_host_that_checks_is_answered_in_kind() {
    let mut bench = Bench::running();
    let checked = |sequence| CheckedPacket { packet: packet(0, [200; 4]), sequence: Sequence::new(sequence) };
    let answers = bench.raw_bytes(&checked(9).encode(Direction::Request));
    let answer = CheckedPacket::decode(&answers[0], Direction::Answer).unwrap();
    assert_eq!(answer.sequence, Sequence::new(9));
    assert_eq!(bench.board.status().commands, [counts(200); 4]);
    bench.wait_us(1_000);
    assert_eq!(bench.request([300; 4]), None);
    assert_eq!(bench.board.status().commands, [counts(200); 4]);

    let silence = BoardConfig::default().command_timeout.get() / 1_000 + 2;
    for _ in 0..silence {
        bench.step();
    }
    assert!(bench.request([300; 4]).is_some());
}

#[test]
fn a_board_that_cannot_hear_itself_takes_the_next_request_at_once() {
    let request = packet(0, [200; 4]).encode();
    let answers = |hears_itself| {
        let mut bench = Bench::new(BoardConfig { hears_itself, ..BoardConfig::default() }, 0);
        bench.step();
        bench.bytes(&[request, request].concat()).len()
    };
    assert_eq!((answers(true), answers(false)), (1, 2));
}

/// The original's client is obeyed as soon as a host that checks has left, and not before.
#[test]
fn a_host_that_leaves_is_forgotten_at_once() {
    let mut bench = Bench::running();
    bench.read(300);
    bench.steps(100);
    let send = |bench: &mut Bench, packet: Packet, number: u8| {
        let request = CheckedPacket { packet, sequence: Sequence::new(number) };
        let answers = bench.raw_bytes(&request.encode(Direction::Request));
        bench.wait_us(150);
        answers.iter().filter_map(|answer| CheckedPacket::decode(answer, Direction::Answer).ok()).next()
    };
    send(&mut bench, packet(0, [500; 4]), 1).unwrap();
    assert_eq!(bench.steps(3), [400; 4]);
    assert_eq!(bench.request([700; 4]), None, "an unchecked client beside a host that checks");
    let answer = send(&mut bench, packet(0, [0; 4]), 2).unwrap();
    assert_eq!((answer.sequence.get(), answer.packet), (2, packet(0, [300; 4])), "answered, checked");
    assert_eq!(bench.step(), [-400; 4], "it vents");
    assert_eq!(bench.request([500; 4]), Some([300; 4]));
    assert_eq!(bench.step(), [400; 4], "the unchecked client is obeyed");
    // Four commands of 0 counts without a CRC say nothing about the host.
    assert_eq!(bench.request([0; 4]), Some([300; 4]));
    send(&mut bench, packet(0, [500; 4]), 3).unwrap();
    assert_eq!(bench.request([700; 4]), None);
}
