use super::scripts;
use bolero::check;
use pneudrive_control::{AdcSample, Board, BoardConfig, ChannelStatus, Micros};
use pneudrive_protocol::pages::{Counter, PageEntry};
use pneudrive_protocol::{
    Address, CheckedPacket, Counts, Direction, PACKET_LEN, Packet, PageRequest, Sequence,
};

/// What five bytes do to a board: what happens, after how long, and with what.
fn act(board: &mut Board, now: &mut u64, act: [u8; 5]) {
    let [kind, time, a, b, c] = act;
    // Within a character, around a gap, a loop, a timeout, a clock that jumps, stands still, or
    // goes back.
    let distances = [0, 10, 35, 150, 1_000, 10_000, 600_000, 3_000_000, 1 << 32, 1 << 62, -20, -2_000];
    *now = now.saturating_add_signed(distances[usize::from(time) % distances.len()]);
    let at = Micros::new(*now);
    let values = [u16::from(a) * 4, u16::from(b) * 4, u16::from(c), 1_023].map(Counts::saturating);
    let packet = Packet { address: Address::of_board(a % 2), values };
    let checked = CheckedPacket { packet, sequence: Sequence::new(b) };
    match kind % 10 {
        0 | 1 => frame(board, now, packet.encode()),
        2 | 3 => frame(board, now, checked.encode(Direction::Request)),
        4 => frame(board, now, checked.encode(Direction::Answer)),
        5 => drop(board.receive_byte(at, a)),
        6 => board.line_error(at),
        7 => board.line_idle(at),
        8 => {
            let entries =
                [PageEntry::State, PageEntry::Drives, PageEntry::Counter(Counter::ALL[usize::from(b) % 14])];
            let entry = entries[usize::from(c) % entries.len()];
            frame(board, now, PageRequest::new(packet.address, entry, Sequence::new(b)).encode());
        }
        _ => {
            let codes = [u16::from(a) << 4, u16::from(b) << 4 | 15, u16::from_le_bytes([a, b]), u16::MAX];
            step(board, at, codes.map(AdcSample::from_reading));
        }
    }
}

fn step(board: &mut Board, at: Micros, samples: [AdcSample; 4]) {
    let drives = board.control_step(at, samples);
    let status = board.status();
    for (drive, channel) in drives.into_iter().zip(status.channels) {
        assert!((-400..=400).contains(&drive.get()));
        assert!(
            channel == ChannelStatus::Regulating || drive.get() == -400,
            "{channel:?} is driven by {drive}"
        );
    }
}

fn frame(board: &mut Board, now: &mut u64, bytes: [u8; PACKET_LEN]) {
    let mut answers = 0;
    for byte in bytes {
        *now = now.saturating_add(10);
        if let Some(answer) = board.receive_byte(Micros::new(*now), byte) {
            answers += 1;
            assert_eq!(answer[..2], board.address().word().to_be_bytes());
        }
    }
    assert!(answers <= 1);
}

#[test]
fn arbitrary_bytes_and_times() {
    check!().with_iterations(20_000).with_generator(scripts(400)).for_each(|script: &Vec<u8>| {
        let mut board = Board::new(BoardConfig::default(), Address::of_board(0)).unwrap();
        let mut now = 0;
        for five in script.chunks_exact(5) {
            act(&mut board, &mut now, five.try_into().unwrap());
        }
    });
}

/// A board is made or refused, whatever its configuration; one that is made works.
#[test]
fn arbitrary_configurations() {
    check!().with_iterations(20_000).with_generator(scripts(64)).for_each(|bytes: &Vec<u8>| {
        let mut bytes = bytes.iter().copied().chain(std::iter::repeat(0));
        let mut next = || u16::from_le_bytes([bytes.next().unwrap(), bytes.next().unwrap()]);
        // Each parameter is its default, or anything.
        let mut pick =
            |usual: u64| if next() % 4 == 0 { u64::from(next()) * u64::from(next()) } else { usual };
        let usual = BoardConfig::default();
        let config = BoardConfig {
            answer_delay: Micros::new(pick(14)),
            loop_period: Micros::new(pick(1_000)),
            kp: pick(10) as u16,
            kd: pick(20) as u16,
            saturation: pick(400) as u16,
            filter_previous: pick(210) as u8,
            initial_command: Counts::saturating(pick(102) as u16),
            power_up_vent: Micros::new(pick(0)),
            command_timeout: Micros::new(pick(500_000)),
            hold_time: Micros::new(pick(2_000_000)),
            sensor_min: Counts::saturating(pick(102) as u16),
            sensor_max: Counts::saturating(pick(922) as u16),
            sensor_margin: pick(51) as u16,
            fault_after_steps: pick(10) as u16,
            recover_after_steps: pick(1_000) as u16,
            ..usual
        };
        let Ok(mut board) = Board::new(config, Address::of_board(0)) else { return };
        let period = config.loop_period.get();
        for n in 0..50 {
            let code = (n * 997 % 4_096) as u16;
            step(
                &mut board,
                Micros::new(n * period),
                [code, 4_095 - code, 410, 0].map(AdcSample::from_reading),
            );
        }
    });
}
