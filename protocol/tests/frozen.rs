//! How requests with bytes that are frozen are held to them.

use pneudrive_protocol::pages::PageEntry;
use pneudrive_protocol::{Address, Asked, PageRequest, RequestDecoder, Sequence};

/// A request with sequence number 9 to board 2 must be these bytes, and be read back from them.
#[track_caller]
pub fn assert_stands(entry: PageEntry, bytes: [u8; 10]) {
    let board = Address::of_board(2);
    let request = PageRequest::new(board, entry, Sequence::new(9));
    assert_eq!(request.encode(), bytes, "{entry:?}");
    let mut decoder = RequestDecoder::new(board);
    let asked = bytes.into_iter().find_map(|byte| decoder.push(byte));
    assert_eq!(asked, Some(Asked::Page(request)));
    assert_eq!(request.entry(), Some(entry));
}
