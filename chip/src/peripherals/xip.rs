//! XIP_CTRL and the cache between the bus and the serial flash (2.6.3): 16 KiB, two ways, lines of 8 bytes.
//!
//! A line has a valid bit for each of its halves, and a miss fetches one half, because the SSI behind the cache delivers 32 bits at
//! a time. Which way a miss replaces is not documented; here it is the one that was used less recently.

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

#[derive(Clone, Copy, Debug, Default)]
struct Set {
    ways: [Line; 2],
    last_used: u8,
}

/// The XIP_CTRL block with its cache.
#[derive(Clone, Debug)]
pub(crate) struct Xip {
    control: u32,
    hits: u32,
    accesses: u32,
    sets: Box<[Set; SETS]>,
    flushed_at: Ticks,
}

impl Default for Xip {
    fn default() -> Self {
        Xip {
            control: ENABLE | ERROR_ON_BAD_WRITE,
            hits: 0,
            accesses: 0,
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
    /// Reads a word; returns whether the cache had it.
    #[inline]
    pub fn access(&mut self, address: u32) -> bool {
        self.accesses = self.accesses.saturating_add(1);
        if self.has_in_way_used_last(address) {
            self.hits = self.hits.saturating_add(1);
            return true;
        }
        self.access_elsewhere(address)
    }

    /// Nearly all hits, and they change nothing in the cache.
    #[inline]
    fn has_in_way_used_last(&self, address: u32) -> bool {
        let (set, tag, half) = place(address);
        let set = &self.sets[set];
        let line = set.ways[usize::from(set.last_used & 1)];
        line.tag == tag && line.valid & half != 0 && address & NO_LOOKUP == 0 && self.control & ENABLE != 0
    }

    fn access_elsewhere(&mut self, address: u32) -> bool {
        let enabled = self.control & ENABLE != 0;
        let hit = enabled && address & NO_LOOKUP == 0 && self.look_up(address);
        self.hits = self.hits.saturating_add(u32::from(hit));
        if !hit && enabled && address & NO_ALLOCATE == 0 {
            self.fill(address);
        }
        hit
    }

    fn look_up(&mut self, address: u32) -> bool {
        let (set, tag, half) = place(address);
        let set = &mut self.sets[set];
        for (way, line) in (0..).zip(set.ways) {
            if line.tag == tag && line.valid & half != 0 {
                set.last_used = way;
                return true;
            }
        }
        false
    }

    fn fill(&mut self, address: u32) {
        let (set, tag, half) = place(address);
        let set = &mut self.sets[set];
        let same = set.ways.iter().position(|line| line.valid != 0 && line.tag == tag);
        let free = || set.ways.iter().position(|line| line.valid == 0);
        let way = same.or_else(free).unwrap_or(usize::from(set.last_used ^ 1));
        let line = &mut set.ways[way];
        let kept = if same.is_some() { line.valid } else { 0 };
        *line = Line { tag, valid: kept | half };
        set.last_used = way as u8;
    }

    /// A write to a flash address: a matching entry of the cache is given up through the first alias. Returns whether the bus
    /// accepts it.
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

    /// CTR_ACC and CTR_HIT.
    pub fn counters(&self) -> (u32, u32) {
        (self.accesses, self.hits)
    }

    pub fn read(&self, offset: u32, now: Ticks) -> Option<u32> {
        Some(match offset {
            CTRL => self.control,
            // On the chip this read waits for the end of a flush; the wait is not modelled.
            FLUSH => 0,
            // No stream can be started.
            STREAM_CTR => 0,
            STAT => STREAM_FIFO_EMPTY | if now >= self.flushed_at { FLUSH_READY } else { 0 },
            CTR_HIT => self.hits,
            CTR_ACC => self.accesses,
            _ => return None,
        })
    }

    /// `flushed` is when a flush would end that starts now.
    pub fn write(&mut self, offset: u32, write: RegisterWrite, flushed: Ticks) -> Written {
        match offset {
            CTRL => {
                let value = write.onto(self.control) & (ENABLE | ERROR_ON_BAD_WRITE | POWER_DOWN);
                self.control = if value & POWER_DOWN != 0 { value & !ENABLE } else { value };
            }
            FLUSH if write.ones() & 1 != 0 => self.flush(flushed),
            FLUSH | STAT => {}
            CTR_HIT => self.hits = 0,
            CTR_ACC => self.accesses = 0,
            _ => return Written::NotModelled,
        }
        Written::Done
    }
}

#[cfg(test)]
mod tests;
