//! On a flash that is cut at every bit of an erase and of a program.

use super::*;
use crate::BoardConfig;
use std::vec::Vec;

/// Two slots, and a supply that ends after so many bits.
#[derive(Clone)]
struct Nor {
    slots: [Vec<u8>; 2],
    /// Bits that can still change; `None` for ever.
    left: Option<usize>,
    /// In which order bits change: by this stride through the slot, which is odd.
    stride: usize,
    stuck: bool,
}

impl Nor {
    fn new() -> Self {
        Self { slots: [std::vec![0xff; SLOT], std::vec![0xff; SLOT]], left: None, stride: 1, stuck: false }
    }

    /// Changes the bits in which `wanted` differs, one by one.
    fn change(&mut self, slot: Slot, wanted: &[u8]) -> bool {
        let bits = 8 * wanted.len();
        for step in 0..bits {
            let bit = step * self.stride % bits;
            let (byte, mask) = (bit / 8, 1 << (bit % 8));
            if (self.slots[slot.index()][byte] ^ wanted[byte]) & mask == 0 {
                continue;
            }
            match &mut self.left {
                Some(0) => return false,
                Some(left) => *left -= 1,
                None => {}
            }
            self.slots[slot.index()][byte] ^= mask;
        }
        true
    }
}

impl Flash for Nor {
    fn read(&self, slot: Slot) -> [u8; RECORD] {
        *self.slots[slot.index()].first_chunk().unwrap()
    }

    fn erase(&mut self, slot: Slot) -> bool {
        self.change(slot, &[0xff; SLOT])
    }

    fn program(&mut self, slot: Slot, record: &[u8; RECORD]) -> bool {
        // A program can only clear bits.
        let old = self.read(slot);
        let mut wanted: Vec<u8> = record.iter().zip(old).map(|(new, old)| new & old).collect();
        if self.stuck {
            wanted[100] &= 0xfe;
        }
        self.change(slot, &wanted)
    }
}

fn compiled() -> ParameterSet {
    ParameterSet::of(&BoardConfig::ORIGINAL)
}

fn with(changes: &[(Parameter, u32)]) -> ParameterSet {
    let mut set = compiled();
    for (parameter, value) in changes {
        set.set(*parameter, *value);
    }
    set
}

#[test]
fn what_is_saved_is_loaded_and_slots_take_turns() {
    let mut flash = Nor::new();
    let mut stored = Stored::load(&flash);
    assert_eq!(stored, Stored::NOTHING);
    for number in 1..=5 {
        let set = with(&[(Parameter::Kp, number), (Parameter::Address, 7)]);
        stored = stored.save(&mut flash, &set, &compiled()).unwrap();
        assert_eq!(Stored::load(&flash), stored);
        assert_eq!((stored.over(&compiled()), stored.number()), (set, number));
        assert_eq!(stored.slot, Some(if number % 2 == 1 { Slot::A } else { Slot::B }));
    }
    let reset = stored.save(&mut flash, &compiled(), &compiled()).unwrap();
    assert!(!reset.changes_anything() && reset.number() == 6);
    assert_eq!(Stored::load(&flash).over(&compiled()), compiled());
}

#[test]
fn what_is_kept_already_is_not_written_again() {
    let mut flash = Nor::new();
    let set = with(&[(Parameter::Kd, 3)]);
    let stored = Stored::NOTHING.save(&mut flash, &set, &compiled()).unwrap();
    flash.left = Some(0);
    assert_eq!(stored.save(&mut flash, &set, &compiled()), Ok(stored));
}

/// The supply ends after each bit that changes, in three orders of the bits: the old values or the
/// new ones, never others.
#[test]
fn a_power_cut_at_any_bit_leaves_the_old_or_the_new() {
    let (old, new) =
        (with(&[(Parameter::Kp, 77)]), with(&[(Parameter::Kp, 78), (Parameter::HoldTime, 9_000)]));
    let (mut cuts, mut news) = (0, 0);
    for stride in [1, 33, 2_049] {
        let mut flash = Nor { stride, ..Nor::new() };
        // Both slots written, so that the erase has something to do.
        let mut stored = Stored::NOTHING;
        for set in [with(&[(Parameter::Kp, 76)]), old] {
            stored = stored.save(&mut flash, &set, &compiled()).unwrap();
        }
        for left in 0.. {
            let mut cut = Nor { left: Some(left), ..flash.clone() };
            let done = stored.save(&mut cut, &new, &compiled()).is_ok();
            let found = Stored::load(&cut).over(&compiled());
            assert!(found == old || found == new, "after {left} bits: {found:?}");
            assert!(!done || found == new);
            // And whatever the cut left, the next change is kept.
            cut.left = None;
            let next = with(&[(Parameter::Kp, 79)]);
            let saved = Stored::load(&cut).save(&mut cut, &next, &compiled()).unwrap();
            assert_eq!((Stored::load(&cut), saved.over(&compiled())), (saved, next));
            cuts += 1;
            if done {
                news += 1;
                break;
            }
        }
    }
    assert!(cuts > 600 && news == 3, "{cuts} cuts");
}

#[test]
fn a_flash_that_holds_something_else_is_noticed_and_the_old_values_stay() {
    let mut flash = Nor::new();
    let stored = Stored::NOTHING.save(&mut flash, &with(&[(Parameter::Kp, 5)]), &compiled()).unwrap();
    flash.stuck = true;
    assert_eq!(stored.save(&mut flash, &with(&[(Parameter::Kp, 6)]), &compiled()), Err(WriteFailed));
    assert_eq!(Stored::load(&flash), stored);
}

#[test]
fn any_flipped_bit_is_no_record() {
    let mut flash = Nor::new();
    Stored::NOTHING.save(&mut flash, &with(&[(Parameter::Kp, 5)]), &compiled()).unwrap();
    for bit in 0..8 * RECORD {
        let mut flipped = flash.clone();
        flipped.slots[0][bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Stored::load(&flipped), Stored::NOTHING, "bit {bit}");
    }
}
