//! Whatever is said on a bus that keeps the two rules of `false_address`, a board of the original
//! kind finds its address only where a packet with it begins.

use pneudrive_protocol::false_address::{GUARD, needs_guard, without_false_address};
use pneudrive_protocol::{
    Address, AnswerDecoder, CHANNELS, CheckedPacket, Counts, Direction, Echo, FrameFinder, Heard, PACKET_LEN,
    Packet, RequestDecoder, Sequence,
};
use proptest::collection::vec;
use proptest::prelude::*;

/// Boards that the original's address switch selects.
const ORIGINALS: u8 = 4;

/// A packet on the wire and who says it: `None` is the host.
struct Said {
    speaker: Option<u8>,
    bytes: Vec<u8>,
    /// Whether a packet, with its address, begins here.
    packet: bool,
}

/// An exchange: the board asked, commands, pressures, and the number of a checked one.
type Exchange = (u8, [Counts; CHANNELS], [Counts; CHANNELS], Option<u8>);

fn encode(packet: Packet, sequence: Option<u8>, direction: Direction) -> Vec<u8> {
    match sequence {
        None => packet.encode().to_vec(),
        Some(n) => CheckedPacket { packet, sequence: Sequence::new(n) }.encode(direction).to_vec(),
    }
}

/// What stands on the wire for these exchanges.
fn conversation(exchanges: &[Exchange]) -> Vec<Said> {
    let mut said: Vec<Said> = Vec::new();
    for &(board, commands, pressures, sequence) in exchanges {
        let address = Address::of_board(board);
        if needs_guard(said.last().and_then(|said| said.bytes.last().copied())) {
            said.push(Said { speaker: None, bytes: vec![GUARD], packet: false });
        }
        let request = Packet { address, values: without_false_address(commands) };
        let answer = Packet { address, values: pressures };
        said.push(Said { speaker: None, bytes: encode(request, sequence, Direction::Request), packet: true });
        said.push(Said {
            speaker: Some(board),
            bytes: encode(answer, sequence, Direction::Answer),
            packet: true,
        });
    }
    said
}

/// Every pair of bytes that is the address of a board of the original kind, as that board hears the
/// wire (not itself), is the beginning of a packet.
fn assert_no_false_address(said: &[Said]) {
    for own in 0..ORIGINALS {
        let (mut before, mut heard) = (None, 0);
        for part in said.iter().filter(|part| part.speaker != Some(own)) {
            for (index, &byte) in part.bytes.iter().enumerate() {
                if before.map(|before| u16::from_be_bytes([before, byte]))
                    == Some(Address::of_board(own).word())
                {
                    assert!(part.packet && index == 1, "board {own}: byte {index} of {:02X?}", part.bytes);
                    heard += 1;
                }
                before = Some(byte);
            }
        }
        let meant = said
            .iter()
            .filter(|part| part.speaker != Some(own) && part.packet && part.bytes[1] == 0xFF - own);
        assert_eq!(heard, meant.count(), "board {own} finds every packet that has its address");
    }
}

fn counts(value: u16) -> Counts {
    Counts::new(value).unwrap()
}

/// All commands of channel 3, in every format, before all ends of an answer, before a request to
/// every board.
#[test]
fn no_pair_across_two_packets_is_an_address_that_is_not_meant() {
    for command in 0..=1023 {
        for asked in 0..ORIGINALS {
            for sequence in [None, Some(0), Some(7), Some(15)] {
                for pressure in [command, 255, 1023, 510] {
                    for next in 0..ORIGINALS {
                        let values = [counts(command); CHANNELS];
                        let exchange = (asked, values, [counts(pressure); CHANNELS], sequence);
                        let other = (next, values, values, None);
                        assert_no_false_address(&conversation(&[exchange, other]));
                    }
                }
            }
        }
    }
}

/// Each of the two rules is needed: what they prevent is a false address to the same assertion.
#[test]
fn without_either_rule_there_is_a_false_address() {
    let packet = |value| Packet { address: Address::of_board(1), values: [counts(value); CHANNELS] };
    let said = |speaker, value: u16| Said { speaker, bytes: packet(value).encode().to_vec(), packet: true };
    let conversations = [[said(None, 511), said(Some(1), 300)], [said(Some(1), 511), said(None, 300)]];
    for conversation in conversations {
        let found = std::panic::catch_unwind(|| assert_no_false_address(&conversation));
        assert!(found.is_err());
    }
}

fn any_counts() -> impl Strategy<Value = Counts> {
    prop_oneof![0..=1023_u16, Just(255), Just(511), Just(767), Just(1023)].prop_map(counts)
}

fn any_exchange() -> impl Strategy<Value = Exchange> {
    let four = || [any_counts(), any_counts(), any_counts(), any_counts()];
    (0..ORIGINALS, four(), four(), prop::option::of(0..16_u8))
}

proptest! {
    #[test]
    fn no_conversation_holds_an_address_that_is_not_meant(exchanges in vec(any_exchange(), 1..20)) {
        assert_no_false_address(&conversation(&exchanges));
    }

    /// Guard bytes cost nobody a packet: boards that keep alignment, with and without a silence
    /// after the guard.
    #[test]
    fn a_guard_byte_costs_no_packet(exchanges in vec(any_exchange(), 1..20), silence in any::<bool>()) {
        let mut finder = FrameFinder::new();
        let mut own = RequestDecoder::new(Address::of_board(2));
        let (mut packets, mut requests) = (0, 0);
        let said = conversation(&exchanges);
        for part in said.iter().filter(|part| part.speaker != Some(2)) {
            if silence && !part.packet {
                finder.restart();
                own.line_idle();
            }
            for &byte in &part.bytes {
                packets += usize::from(finder.push(byte).is_some());
                requests += usize::from(own.push(byte).is_some());
            }
            if silence && !part.packet {
                finder.restart();
                own.line_idle();
            }
        }
        prop_assert_eq!(packets, said.iter().filter(|part| part.packet && part.speaker != Some(2)).count());
        // Once it has been asked in checked packets it ignores others.
        let mut checks = false;
        let heard = exchanges.iter().filter(|(board, .., sequence)| {
            let obeyed = *board == 2 && (sequence.is_some() || !checks);
            checks |= *board == 2 && sequence.is_some();
            obeyed
        });
        prop_assert_eq!(requests, heard.count());
    }

    /// An adapter that echoes returns the guard, at once or together with the request.
    #[test]
    fn the_echo_of_a_guard_byte_is_skipped(command in any_counts(), pressure in any_counts(), echoed in any::<bool>()) {
        let address = Address::of_board(1);
        let request = Packet { address, values: [command; CHANNELS] };
        let mut decoder = AnswerDecoder::new(request, Echo::Present).after_guard();
        let guard: &[u8] = if echoed { &[GUARD] } else { &[] };
        let answer = Packet { address, values: [pressure; CHANNELS] };
        let bytes = [guard, &request.encode(), &answer.encode()].concat();
        let heard: Vec<_> = bytes.iter().filter_map(|&byte| decoder.push(byte)).collect();
        prop_assert_eq!(heard, vec![Heard::Answer(answer.values)]);
        prop_assert!(!decoder.echo_damaged() && decoder.echo_left() == 0);
        prop_assert_eq!(bytes.len(), 2 * PACKET_LEN + usize::from(echoed));
    }
}
