use super::scripts;
use bolero::check;
use pneudrive_protocol::pages::PageEntry;
use pneudrive_protocol::{
    Address, AnswerDecoder, Asked, CheckedPacket, Counts, Direction, Echo, FrameFinder, Heard, Packet,
    PacketFormat, PageRequest, RequestDecoder, Sequence,
};

fn page_request(board: u8, number: u8) -> PageRequest {
    PageRequest::new(
        Address::of_board(board % 4),
        PageEntry::PostMortemWord(number % 13),
        Sequence::new(number),
    )
}

/// Bytes of a line: raw ones, and whole packets (of some board, some of them damaged), so that
/// decoders get somewhere.
fn line(script: &[u8]) -> Vec<u8> {
    let mut line = Vec::new();
    for piece in script.chunks(4) {
        let &[kind, a, b, c] = piece else {
            line.extend_from_slice(piece);
            continue;
        };
        let values = [u16::from(a) * 4, u16::from(b) << 2 | 3, u16::from(c), 511].map(Counts::saturating);
        let packet = Packet { address: Address::of_board(a % 4), values };
        let checked = CheckedPacket { packet, sequence: Sequence::new(b) };
        let mut bytes = match kind % 8 {
            0 | 1 => packet.encode().to_vec(),
            2 => checked.encode(Direction::Request).to_vec(),
            3 => checked.encode(Direction::Answer).to_vec(),
            4 => page_request(a, b).encode().to_vec(),
            5 => page_request(a, b).answer(Some(values)).encode().to_vec(),
            _ => piece.to_vec(),
        };
        match kind / 8 % 8 {
            0 => bytes[usize::from(c) % 10 % piece.len()] ^= 1 << (b % 8),
            1 => drop(bytes.remove(0)),
            2 => bytes.push(c),
            3 => bytes.truncate(usize::from(c) % 10),
            _ => {}
        }
        line.extend(bytes);
    }
    line
}

/// Every byte is in a packet, in ten whose CRC fitted nothing, discarded, or waiting; of such ten,
/// up to nine have not been counted yet.
#[test]
fn the_frame_finder() {
    check!().with_iterations(20_000).with_generator(scripts(160)).for_each(|script: &Vec<u8>| {
        let mut finder = FrameFinder::new();
        let (mut bytes, mut packets) = (0, 0);
        for byte in line(script) {
            bytes += 1;
            packets += usize::from(finder.push(byte).is_some());
            let statistics = finder.statistics();
            assert_eq!(statistics.packets as usize, packets);
            let tens = packets + statistics.unverified as usize;
            let counted = 10 * tens + statistics.discarded_bytes as usize + finder.pending();
            assert!(counted <= bytes && bytes - counted < 10, "{counted} of {bytes}: {statistics:?}");
            assert!(finder.pending() < 10);
        }
    });
}

/// A board takes only the last ten bytes for a request, and only to itself.
#[test]
fn the_boards_ear() {
    check!().with_iterations(20_000).with_generator(scripts(160)).for_each(|script: &Vec<u8>| {
        let own = Address::of_board(script.first().copied().unwrap_or(0) % 4);
        let mut decoder = RequestDecoder::new(own);
        let mut heard = Vec::new();
        for byte in line(script) {
            heard.push(byte);
            let request = match decoder.push(byte) {
                None => continue,
                Some(Asked::Page(request)) => {
                    assert_eq!(heard[heard.len() - 10..], request.encode());
                    continue;
                }
                Some(Asked::Pressures(request)) => request,
            };
            let packet = Packet { address: own, values: request.commands };
            let sent = match request.format {
                PacketFormat::Unchecked => packet.encode(),
                PacketFormat::Checked(sequence) => {
                    CheckedPacket { packet, sequence }.encode(Direction::Request)
                }
                PacketFormat::Sealed(_) => panic!("no session was offered"),
            };
            assert_eq!(heard[heard.len() - 10..], sent);
        }
    });
}

/// The host takes only an answer of the board and with the number that it asked for.
#[test]
fn the_hosts_ear() {
    check!().with_iterations(20_000).with_generator(scripts(160)).for_each(|script: &Vec<u8>| {
        let (board, number) = (script.first().copied().unwrap_or(0) % 4, script.len() as u8);
        let packet = Packet { address: Address::of_board(board), values: [Counts::ATMOSPHERE; 4] };
        let request = CheckedPacket { packet, sequence: Sequence::new(number) };
        for echo in [Echo::Absent, Echo::Present] {
            let mut ear = AnswerDecoder::for_checked(request, echo);
            let mut heard = Vec::new();
            for byte in line(script) {
                heard.push(byte);
                let Some(Heard::Answer(pressures)) = ear.push(byte) else { continue };
                let packet = Packet { address: packet.address, values: pressures };
                let sent = CheckedPacket { packet, sequence: request.sequence }.encode(Direction::Answer);
                assert_eq!(heard[heard.len() - 10..], sent);
            }
            let mut ear = AnswerDecoder::new(packet, echo);
            for byte in line(script) {
                ear.push(byte);
            }
            assert!(ear.stray_bytes() <= heard.len());
        }
    });
}
