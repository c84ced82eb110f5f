//! XIP_CTRL and the cache between the bus and the serial flash (2.6.3): 16 KiB, two ways, lines of
//! 8 bytes.
//!
//! A line has a valid bit for each of its halves, and a miss fetches one half, because the SSI
//! behind the cache delivers 32 bits at a time. Which way a miss replaces is not documented; here
//! it is the one that was used less recently.

use super::{RegisterWrite, Written};
use crate::ticks::Ticks;

/// Register offsets (2.6.3.6).
const CTRL: u32 = 0x00;
const FLUSH: u32 = 0x04;
const STAT: u32 = 0x08;
const CTR_HIT: u32 = 0x0c;
const CTR_ACC: u32 = 0x10;
const STREAM_CTR: u32 = 0x18;

/// CTRL.
const ENABLE: u32 = 1 << 0;
const ERROR_ON_BAD_WRITE: u32 = 1 << 1;
const POWER_DOWN: u32 = 1 << 3;

/// STAT.
const FLUSH_READY: u32 = 1 << 0;
const STREAM_FIFO_EMPTY: u32 = 1 << 1;

/// 16 KiB / 8 bytes a line / 2 ways.
const SETS: usize = 1024;
/// A flush clears one set a cycle (2.6.3.2: "just over 1024 clock cycles").
pub(crate) const FLUSH_CYCLES: u64 = SETS as u64;

/// How an alias of the flash uses the cache (2.6.3.1): bits 25 and 24 of the address.
const NO_ALLOCATE: u32 = 1 << 24;
const NO_LOOKUP: u32 = 1 << 25;

#[derive(Clone, Copy, Debug, Default)]
struct Line {
    tag: u16,
    /// Bit 0 for the lower half, bit 1 for the upper.
    valid: u8,
}

/// The way used last comes first.
#[derive(Clone, Copy, Debug, Default)]
struct Set {
    ways: [Line; 2],
}

/// The XIP_CTRL block with its cache.
#[derive(Clone, Debug)]
pub(crate) struct Xip {
    control: u32,
    /// An access with one of these bits in its address goes past the cache.
    bypass: u32,
    /// Since creation, and when the program cleared the counters.
    accesses: u64,
    misses: u64,
    accesses_cleared: u64,
    hits_cleared: u64,
    sets: Box<[Set; SETS]>,
    flushed_at: Ticks,
}

impl Default for Xip {
    fn default() -> Self {
        Xip {
            control: ENABLE | ERROR_ON_BAD_WRITE,
            bypass: NO_LOOKUP,
            accesses: 0,
            misses: 0,
            accesses_cleared: 0,
            hits_cleared: 0,
            sets: Box::new([Set::default(); SETS]),
            flushed_at: Ticks::ZERO,
        }
    }
}

/// Set, tag and valid bit of an address.
fn place(address: u32) -> (usize, u16, u8) {
    let offset = address & 0xff_ffff;
    ((offset >> 3) as usize % SETS, (offset >> 13) as u16, 1 << (offset >> 2 & 1))
}

impl Xip {
    /// Reads a word; returns whether the cache had it. Nearly all words are in the way used last,
    /// which changes nothing.
    #[inline]
    pub fn access(&mut self, address: u32) -> bool {
        self.accesses += 1;
        let (set, tag, half) = place(address);
        let line = self.sets[set].ways[0];
        line.tag == tag && line.valid & half != 0 && address & self.bypass == 0
            || self.access_elsewhere(address)
    }

    fn access_elsewhere(&mut self, address: u32) -> bool {
        let hit = address & self.bypass == 0 && self.look_up(address);
        self.misses += u64::from(!hit);
        if !hit && self.control & ENABLE != 0 && address & NO_ALLOCATE == 0 {
            self.fill(address);
        }
        hit
    }

    fn look_up(&mut self, address: u32) -> bool {
        let (set, tag, half) = place(address);
        let ways = &mut self.sets[set].ways;
        let hit = ways.iter().position(|line| line.tag == tag && line.valid & half != 0);
        if hit == Some(1) {
            ways.swap(0, 1);
        }
        hit.is_some()
    }

    fn fill(&mut self, address: u32) {
        let (set, tag, half) = place(address);
        let ways = &mut self.sets[set].ways;
        let same = ways.iter().position(|line| line.valid != 0 && line.tag == tag);
        let free = || ways.iter().position(|line| line.valid == 0);
        let way = same.or_else(free).unwrap_or(1);
        let kept = if same.is_some() { ways[way].valid } else { 0 };
        ways[way] = Line { tag, valid: kept | half };
        ways[..=way].rotate_right(1);
    }

    /// A write to a flash address: a matching entry of the cache is given up through the first
    /// alias. Returns whether the bus accepts it.
    pub fn invalidate(&mut self, address: u32) -> bool {
        if address & (NO_ALLOCATE | NO_LOOKUP) != 0 {
            return self.control & ERROR_ON_BAD_WRITE == 0;
        }
        let (set, tag, half) = place(address);
        for line in &mut self.sets[set].ways {
            if line.tag == tag {
                line.valid &= !half;
            }
        }
        true
    }

    /// Empties the cache, which is done at `done`.
    pub fn flush(&mut self, done: Ticks) {
        self.sets.fill(Set::default());
        self.flushed_at = done;
    }

    /// Until then every access waits for a flush.
    pub fn flushed_at(&self) -> Ticks {
        self.flushed_at
    }

    /// CTR_ACC and CTR_HIT, which stop at their ends.
    pub fn counters(&self) -> (u32, u32) {
        let stop = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
        (stop(self.accesses - self.accesses_cleared), stop(self.hits() - self.hits_cleared))
    }

    fn hits(&self) -> u64 {
        self.accesses - self.misses
    }

    pub fn read(&self, offset: u32, now: Ticks) -> Option<u32> {
        Some(match offset {
            CTRL => self.control,
            // On the chip this read waits for the end of a flush; the wait is not modelled.
            FLUSH => 0,
            // No stream can be started.
            STREAM_CTR => 0,
            STAT => STREAM_FIFO_EMPTY | if now >= self.flushed_at { FLUSH_READY } else { 0 },
            CTR_HIT => self.counters().1,
            CTR_ACC => self.counters().0,
            _ => return None,
        })
    }

    /// `flushed` is when a flush would end that starts now.
    pub fn write(&mut self, offset: u32, write: RegisterWrite, flushed: Ticks) -> Written {
        match offset {
            CTRL => {
                let value = write.onto(self.control) & (ENABLE | ERROR_ON_BAD_WRITE | POWER_DOWN);
                self.control = if value & POWER_DOWN != 0 { value & !ENABLE } else { value };
                self.bypass = if self.control & ENABLE != 0 { NO_LOOKUP } else { u32::MAX };
            }
            FLUSH if write.ones() & 1 != 0 => self.flush(flushed),
            FLUSH | STAT => {}
            CTR_HIT => self.hits_cleared = self.hits(),
            CTR_ACC => self.accesses_cleared = self.accesses,
            _ => return Written::NotModelled,
        }
        Written::Done
    }
}

#[cfg(test)]
mod tests;
