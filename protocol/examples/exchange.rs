//! One exchange byte by byte, in both packet formats, and how a receiver that has lost a byte finds
//! the next packet.
//!
//! `cargo run -p pneudrive-protocol --example exchange`

use pneudrive_protocol::{
    Address, AnswerDecoder, Asked, CheckedPacket, Counts, Direction, Echo, Heard, Packet, RequestDecoder,
    SensorScale, Sequence,
};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let scale = SensorScale::ORIGINAL;
    let own = Address::of_board(1);
    let mut board = RequestDecoder::new(own);

    println!("a host commands 100 kPa in all four chambers of board 1:");
    let request = Packet { address: own, values: [scale.counts(100.0)?; 4] };
    let answer = exchange(&mut board, &request.encode(), own)?;
    let mut host = AnswerDecoder::new(request, Echo::Absent);
    show(scale, answer.into_iter().find_map(|byte| host.push(byte)));

    println!("the same with a check sum and a number:");
    let checked = CheckedPacket { packet: request, sequence: Sequence::default() };
    let answer = exchange(&mut board, &checked.encode(Direction::Request), own)?;
    let mut host = AnswerDecoder::for_checked(checked, Echo::Absent);
    show(scale, answer.into_iter().find_map(|byte| host.push(byte)));

    println!("a request whose first byte is lost, and the next one after an idle gap:");
    let bytes = checked.encode(Direction::Request);
    let lost = bytes[1..].iter().find_map(|&byte| board.push(byte));
    println!("  nine bytes: {lost:?}");
    board.line_idle();
    exchange(&mut board, &bytes, own)?;
    Ok(())
}

/// The board hears `request` and answers what it measures: 0 kPa.
fn exchange(board: &mut RequestDecoder, request: &[u8], own: Address) -> Result<[u8; 10], Box<dyn Error>> {
    println!("  request {request:02X?}");
    match request.iter().find_map(|&byte| board.push(byte)) {
        Some(Asked::Pressures(asked)) => {
            let answer = asked.answer(own, [Counts::ATMOSPHERE; 4]);
            println!("  answer  {answer:02X?}");
            Ok(answer)
        }
        other => Err(format!("the board heard {other:?}").into()),
    }
}

fn show(scale: SensorScale, heard: Option<Heard>) {
    match heard {
        Some(Heard::Answer(pressures)) => {
            println!("  measured {:.1?} kPa", pressures.map(|counts| scale.kpa(counts)));
        }
        other => println!("  no answer: {other:?}"),
    }
}
