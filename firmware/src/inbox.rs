//! A new program while it comes over the bus: in RAM, until all of it is there.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use pneudrive_control::update::{INBOX, Piece};

/// What has come of a new program. Start-up leaves it alone: clearing it would take long. A
/// debugger finds it by its name.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".uninit.inbox")]
static UPDATE_INBOX: Inbox = Inbox(UnsafeCell::new(MaybeUninit::uninit()));

struct Inbox(UnsafeCell<MaybeUninit<[u8; INBOX]>>);

// SAFETY: written by the bus interrupt while an update comes, and read by the thread when none
// comes any more: see the two functions.
unsafe impl Sync for Inbox {}

/// Puts a piece where it belongs.
pub fn keep_piece(piece: Piece) {
    let start = UPDATE_INBOX.0.get().cast::<u8>();
    for (n, byte) in (piece.offset..INBOX).zip(piece.bytes) {
        // SAFETY: within the array. The port gives no piece while a commit is pending, which is
        // when the thread reads.
        unsafe { start.add(n).write_volatile(byte) };
    }
}

/// The first `length` bytes of what has come.
pub fn received(length: usize) -> &'static [u8] {
    let start = UPDATE_INBOX.0.get().cast::<u8>();
    // SAFETY: a commit is pending, so nobody writes; and so many bytes have been written.
    unsafe { core::slice::from_raw_parts(start, length.min(INBOX)) }
}
