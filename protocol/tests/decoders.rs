//! What boards and hosts rely on when they listen to a shared, noisy line.

use pneudrive_protocol::pages::PageEntry;
use pneudrive_protocol::{
    Address, AnswerDecoder, Asked, CHANNELS, CheckedPacket, Counts, Direction, Echo, Heard, Packet,
    PacketFormat, PageRequest, Request, RequestDecoder, Sequence,
};
use proptest::collection::vec;
use proptest::prelude::*;

fn counts() -> impl Strategy<Value = Counts> {
    // Values whose low byte is 0xFF are the ones that look like addresses; make them common.
    prop_oneof![0..=1023u16, Just(0x0FF), Just(0x1FF), Just(0x2FF), Just(0x3FF)]
        .prop_map(|v| Counts::new(v).unwrap())
}

fn packet(boards: std::ops::RangeInclusive<u8>) -> impl Strategy<Value = Packet> {
    (boards, [counts(), counts(), counts(), counts()])
        .prop_map(|(board, values)| Packet { address: Address::of_board(board), values })
}

/// What a board takes for requests to itself in `bytes`.
fn heard(decoder: &mut RequestDecoder, bytes: &[u8]) -> Vec<[Counts; CHANNELS]> {
    bytes.iter().filter_map(|&byte| decoder.push(byte)?.pressures()).map(|request| request.commands).collect()
}

fn checked(packet: Packet, sequence: u8, direction: Direction) -> [u8; 10] {
    CheckedPacket { packet, sequence: Sequence::new(sequence) }.encode(direction)
}

fn wire(packets: &[Packet]) -> Vec<u8> {
    packets.iter().flat_map(Packet::encode).collect()
}

proptest! {
    #[test]
    fn packets_come_back(packet in packet(0..=255)) {
        prop_assert_eq!(Packet::decode(&packet.encode()), Ok(packet));
    }

    #[test]
    fn any_bytes_never_panic(bytes in vec(any::<u8>(), 0..200), board in any::<u8>(), request in packet(0..=255), echo in any::<bool>()) {
        heard(&mut RequestDecoder::new(Address::of_board(board)), &bytes);
        let mut decoder = AnswerDecoder::new(request, if echo { Echo::Present } else { Echo::Absent });
        for byte in bytes {
            decoder.push(byte);
        }
        prop_assert!(decoder.stray_bytes() <= 200);
    }

    #[test]
    fn a_valid_frame_after_an_idle_gap_is_found(garbage in vec(any::<u8>(), 0..50), request in packet(0..=255)) {
        let mut decoder = RequestDecoder::new(request.address);
        heard(&mut decoder, &garbage);
        decoder.line_idle();
        prop_assert_eq!(heard(&mut decoder, &request.encode()), vec![request.values]);
    }

    /// However many frames follow each other without a gap, each is taken for what it is: a low
    /// byte 0xFF before somebody's 0xFF.. address never is the start of a frame, for none of the
    /// 256 addresses.
    #[test]
    fn an_aligned_stream_is_never_misread(packets in vec(packet(0..=255), 1..20), board in any::<u8>()) {
        let own = Address::of_board(board);
        let mine: Vec<_> = packets.iter().filter(|p| p.address == own).map(|p| p.values).collect();
        let mut decoder = RequestDecoder::new(own);
        prop_assert_eq!(heard(&mut decoder, &wire(&packets)), mine);
        prop_assert_eq!(decoder.statistics().discarded_bytes, 0);
    }

    /// Joining in the middle of a conversation between the other boards of a four-board bus, with
    /// no gap at all, a board never hears a request to itself.
    #[test]
    fn joining_late_never_invents_a_request(packets in vec(packet(0..=3), 2..20), own in 0u8..=3, cut in 0usize..10) {
        let others: Vec<_> = packets.into_iter().filter(|p| p.address.board() != own).collect();
        let bytes = wire(&others);
        let mut decoder = RequestDecoder::new(Address::of_board(own));
        prop_assert_eq!(heard(&mut decoder, bytes.get(cut..).unwrap_or(&[])), Vec::<[Counts; CHANNELS]>::new());
    }

    /// One byte lost anywhere: all frames but the one that lost it (and at most the one behind it)
    /// are still heard.
    #[test]
    fn one_lost_byte_costs_at_most_two_frames(packets in vec(packet(0..=3), 3..20), lost in any::<prop::sample::Index>()) {
        let mut bytes = wire(&packets);
        let at = lost.index(bytes.len());
        bytes.remove(at);
        let frames: u32 = (0..=3).map(|board| {
            let mut decoder = RequestDecoder::new(Address::of_board(board));
            heard(&mut decoder, &bytes).len() as u32
        }).sum();
        prop_assert!(frames + 2 >= packets.len() as u32, "{frames} of {}", packets.len());
    }

    /// Both formats and pages on one bus, back to back: nobody is misread, answers are not
    /// requests, and a page request says nothing of the host.
    #[test]
    fn a_mixed_stream_is_never_misread(frames in vec((packet(0..=127), 0u8..16, 0u8..5), 1..20), board in 0u8..=127) {
        let own = Address::of_board(board);
        let mut bytes = Vec::new();
        let mut mine = Vec::new();
        let mut host_checks = false;
        for (packet, sequence, kind) in frames {
            let to_me = packet.address == own;
            let format = match kind {
                0 => { bytes.extend(packet.encode()); PacketFormat::Unchecked }
                1 => { bytes.extend(checked(packet, sequence, Direction::Request)); PacketFormat::Checked(Sequence::new(sequence)) }
                2 => { bytes.extend(checked(packet, sequence, Direction::Answer)); continue }
                3 => {
                    let page = PageRequest::new(packet.address, PageEntry::State, Sequence::new(sequence));
                    bytes.extend(page.encode());
                    mine.extend(to_me.then_some(Asked::Page(page)));
                    continue;
                }
                _ => {
                    let page = PageRequest::new(packet.address, PageEntry::State, Sequence::new(sequence));
                    bytes.extend(page.answer(Some(packet.values)).encode());
                    continue;
                }
            };
            if to_me && !(host_checks && format == PacketFormat::Unchecked) {
                host_checks |= format != PacketFormat::Unchecked;
                mine.push(Asked::Pressures(Request { commands: packet.values, format }));
            }
        }
        let mut decoder = RequestDecoder::new(own);
        let heard: Vec<_> = bytes.into_iter().filter_map(|byte| decoder.push(byte)).collect();
        prop_assert_eq!(heard, mine);
        prop_assert_eq!(decoder.statistics().discarded_bytes, 0);
    }

    #[test]
    fn a_stray_byte_before_the_answer_costs_nothing(stray in any::<u8>(), request in packet(0..=3), values in [counts(), counts(), counts(), counts()]) {
        let mut decoder = AnswerDecoder::new(request, Echo::Absent);
        let mut bytes = vec![stray];
        bytes.extend(Packet { values, ..request }.encode());
        let heard: Vec<_> = bytes.into_iter().filter_map(|byte| decoder.push(byte)).collect();
        prop_assert_eq!(heard, vec![Heard::Answer(values)]);
    }
}

/// The original's defect, as it was seen: set points of 511 (0x01FF) on board 1, then board 1's
/// address again. Board 0 took `FF FF FE ..` for its own address.
#[test]
fn the_originals_false_address_is_not_ours() {
    let to_board_1 = Packet { address: Address::of_board(1), values: [Counts::new(511).unwrap(); CHANNELS] };
    let mut board_0 = RequestDecoder::new(Address::of_board(0));
    for _ in 0..4088 {
        assert!(heard(&mut board_0, &to_board_1.encode()).is_empty());
    }
    assert_eq!(board_0.statistics().packets, 4088);
}

#[test]
fn a_byte_with_a_framing_error_ends_its_frame() {
    let request = Packet { address: Address::of_board(0), values: [Counts::ATMOSPHERE; CHANNELS] };
    let mut decoder = RequestDecoder::new(request.address);
    heard(&mut decoder, &request.encode()[..4]);
    decoder.line_error();
    assert!(heard(&mut decoder, &request.encode()[4..]).is_empty());
    decoder.line_idle();
    assert_eq!(heard(&mut decoder, &request.encode()), [request.values]);
}

/// A board that holds its set points answers with the very bytes of the request.
#[test]
fn an_echo_is_skipped_by_count_because_content_cannot_tell() {
    let request = Packet { address: Address::of_board(2), values: [Counts::ATMOSPHERE; CHANNELS] };
    let mut decoder = AnswerDecoder::new(request, Echo::Present);
    assert!(request.encode().into_iter().all(|byte| decoder.push(byte).is_none()));
    assert!(decoder.echo_left() == 0 && !decoder.echo_damaged());
    let answer: Vec<_> = request.encode().into_iter().filter_map(|byte| decoder.push(byte)).collect();
    assert_eq!(answer, [Heard::Answer(request.values)]);
}

#[test]
fn a_damaged_echo_is_noticed() {
    let request = Packet { address: Address::of_board(2), values: [Counts::ATMOSPHERE; CHANNELS] };
    let mut echo = request.encode();
    echo[3] ^= 0x10;
    let mut decoder = AnswerDecoder::new(request, Echo::Present);
    assert!(echo.into_iter().all(|byte| decoder.push(byte).is_none()));
    assert!(decoder.echo_damaged());
}

#[test]
fn another_boards_answer_is_not_ours() {
    let request = Packet { address: Address::of_board(1), values: [Counts::MIN; CHANNELS] };
    let late = Packet { address: Address::of_board(0), values: [Counts::MAX; CHANNELS] };
    let mut decoder = AnswerDecoder::new(request, Echo::Absent);
    let mut bytes = late.encode().to_vec();
    bytes.extend(request.encode());
    let heard: Vec<_> = bytes.into_iter().filter_map(|byte| decoder.push(byte)).collect();
    assert_eq!(heard, [Heard::Other(late), Heard::Answer(request.values)]);
}

#[test]
fn a_board_answers_in_the_format_it_was_asked_in_and_never_mixes() {
    let request = Packet { address: Address::of_board(0), values: [Counts::ATMOSPHERE; CHANNELS] };
    let pressures = [Counts::MAX; CHANNELS];
    let mut decoder = RequestDecoder::new(request.address);
    let ask = |decoder: &mut RequestDecoder, bytes: [u8; 10]| -> Option<[u8; 10]> {
        let heard = bytes.into_iter().find_map(|byte| decoder.push(byte))?.pressures()?;
        Some(heard.answer(request.address, pressures))
    };
    let answer = Packet { values: pressures, ..request };
    assert_eq!(ask(&mut decoder, request.encode()), Some(answer.encode()));
    let numbered = checked(request, 7, Direction::Request);
    assert_eq!(ask(&mut decoder, numbered), Some(checked(answer, 7, Direction::Answer)));
    // From now on this host is known to check.
    assert_eq!(ask(&mut decoder, request.encode()), None);
    decoder.forget_host();
    assert_eq!(ask(&mut decoder, request.encode()), Some(answer.encode()));
}

/// Late, repeated and crossed answers, and the host's own echo, are told apart from the answer.
#[test]
fn only_the_answer_to_this_very_request_counts() {
    let request = Packet { address: Address::of_board(1), values: [Counts::MIN; CHANNELS] };
    let answer = Packet { values: [Counts::MAX; CHANNELS], ..request };
    let asked = CheckedPacket { packet: request, sequence: Sequence::new(4) };
    let mut decoder = AnswerDecoder::for_checked(asked, Echo::Absent);
    let mut heard = Vec::new();
    for frame in [
        asked.encode(Direction::Request),
        checked(answer, 3, Direction::Answer),
        answer.encode(),
        checked(answer, 4, Direction::Answer),
    ] {
        heard.extend(frame.into_iter().filter_map(|byte| decoder.push(byte)));
    }
    assert_eq!(heard, [Heard::Other(answer), Heard::Other(answer), Heard::Answer(answer.values)]);
}
