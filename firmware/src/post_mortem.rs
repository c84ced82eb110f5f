//! What is known of the run before: kept in RAM that start-up does not touch, logged after the reset.

use crate::shared;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};
use pneudrive_control::{PostMortem, StopCause};

type Words = [AtomicU32; PostMortem::WORDS];

/// Survives a reset, and holds anything after power-on. Its name is public so that the compiler leaves it in one piece and its section.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".uninit.post_mortem")]
static KEPT_POST_MORTEM: MaybeUninit<Words> = MaybeUninit::uninit();

/// The record of the run before, all zeros if there is none. By this name a debugger finds it.
#[unsafe(no_mangle)]
static LAST_POST_MORTEM: Words = [const { AtomicU32::new(0) }; PostMortem::WORDS];

/// Remembers why the board stops, should it be reset now.
pub fn keep(cause: StopCause) {
    write(kept(), PostMortem { cause, at: shared::now() }.to_words());
}

/// Logs what was kept before this reset, if it was the watchdog's, and forgets it.
pub fn report(reset_by_watchdog: bool) {
    let words = core::array::from_fn(|n| kept()[n].load(Ordering::Relaxed));
    write(kept(), [0; PostMortem::WORDS]);
    if !reset_by_watchdog {
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

fn kept() -> &'static Words {
    // SAFETY: any bits are valid integers, and nothing else refers to this memory.
    unsafe { KEPT_POST_MORTEM.assume_init_ref() }
}

fn write(to: &Words, words: [u32; PostMortem::WORDS]) {
    for (place, word) in to.iter().zip(words) {
        place.store(word, Ordering::Relaxed);
    }
}
