//! What is known of the run before: kept in RAM that start-up does not touch, logged after the
//! reset, and read by hosts as a page.

use crate::shared;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_rp::watchdog::ResetReason;
use pneudrive_protocol::pages::{PostMortem, StopCause};

type Words = [AtomicU32; PostMortem::WORDS];

/// Survives a reset, and holds anything after power-on. Its name is public so that the compiler
/// leaves it in one piece and its section.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".uninit.post_mortem")]
static KEPT_POST_MORTEM: MaybeUninit<Words> = MaybeUninit::uninit();

/// The record of the run before, all zeros if there is none. By this name a debugger finds it.
#[unsafe(no_mangle)]
static LAST_POST_MORTEM: Words = [const { AtomicU32::new(0) }; PostMortem::WORDS];

/// Remembers why the board stops, should it be reset now.
pub fn keep(cause: StopCause) {
    write(kept(), PostMortem { cause, at_us: shared::now().get() }.to_words());
}

/// Resets by the watchdog since power-on, and the same inverted: memory after power-on holds
/// anything else.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".uninit.watchdog_resets")]
static WATCHDOG_RESETS: MaybeUninit<[AtomicU32; 2]> = MaybeUninit::uninit();

/// Logs what was kept before this reset, if the watchdog was not fed, and forgets it; counts the
/// reset. Once a run. A reset that the board has asked for, to start with other parameters, is none
/// of these.
pub fn report(reason: Option<ResetReason>) {
    let words = core::array::from_fn(|n| kept()[n].load(Ordering::Relaxed));
    write(kept(), [0; PostMortem::WORDS]);
    let resets = match reason {
        None => 0,
        Some(ResetReason::Forced) => watchdog_resets(),
        Some(ResetReason::TimedOut) => watchdog_resets().saturating_add(1),
    };
    count_resets(resets);
    if reason != Some(ResetReason::TimedOut) {
        return;
    }
    match PostMortem::from_words(&words) {
        Some(record) => {
            write(&LAST_POST_MORTEM, words);
            defmt::error!("reset by the watchdog: {}", record);
        }
        None => defmt::error!("reset by the watchdog before its first check"),
    }
}

/// The words of the run before, all 0 if nothing is known of it. Valid after [`report`].
pub fn last() -> [u32; PostMortem::WORDS] {
    core::array::from_fn(|n| LAST_POST_MORTEM[n].load(Ordering::Relaxed))
}

/// Resets by the watchdog since power-on. Valid after [`report`].
pub fn watchdog_resets() -> u32 {
    // SAFETY: any bits are valid integers, and nothing else refers to this memory.
    let [count, inverted] = unsafe { WATCHDOG_RESETS.assume_init_ref() };
    let count = count.load(Ordering::Relaxed);
    if inverted.load(Ordering::Relaxed) == !count { count } else { 0 }
}

fn count_resets(resets: u32) {
    // SAFETY: as above.
    let [count, inverted] = unsafe { WATCHDOG_RESETS.assume_init_ref() };
    count.store(resets, Ordering::Relaxed);
    inverted.store(!resets, Ordering::Relaxed);
}

fn kept() -> &'static Words {
    // SAFETY: any bits are valid integers, and nothing else refers to this memory.
    unsafe { KEPT_POST_MORTEM.assume_init_ref() }
}

fn write(to: &Words, words: [u32; PostMortem::WORDS]) {
    for (place, word) in to.iter().zip(words) {
        place.store(word, Ordering::Relaxed);
    }
}
