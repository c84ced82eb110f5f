//! The arithmetic shared by several encoding classes: AddWithCarry and the shifts (A2.2.1).

use super::{Core, Flags};

impl Flags {
    pub(super) fn n(self) -> bool {
        self.negative >> 31 != 0
    }

    pub(super) fn z(self) -> bool {
        self.nonzero == 0
    }

    pub(super) fn v(self) -> bool {
        self.overflow >> 31 != 0
    }
}

impl Core {
    /// Sets N and Z from a result and hands it on.
    #[inline]
    pub(super) fn set_nz(&mut self, result: u32) -> u32 {
        self.flags.negative = result;
        self.flags.nonzero = result;
        result
    }

    /// AddWithCarry: the sum, with all four flags set.
    #[inline]
    pub(super) fn add_with_carry(&mut self, a: u32, b: u32, carry: bool) -> u32 {
        let (partial, carry_1) = a.overflowing_add(b);
        let (sum, carry_2) = partial.overflowing_add(u32::from(carry));
        self.flags =
            Flags { negative: sum, nonzero: sum, c: carry_1 | carry_2, overflow: (a ^ sum) & (b ^ sum) };
        sum
    }

    /// LSL by 0 to 255; 0 leaves the carry alone.
    #[inline]
    pub(super) fn shift_left(&mut self, value: u32, amount: u32) -> u32 {
        let result = match amount {
            0 => value,
            1..=31 => {
                self.flags.c = value >> (32 - amount) & 1 != 0;
                value << amount
            }
            _ => {
                self.flags.c = amount == 32 && value & 1 != 0;
                0
            }
        };
        self.set_nz(result)
    }

    /// LSR by 0 to 255; 0 leaves the carry alone.
    #[inline]
    pub(super) fn shift_right(&mut self, value: u32, amount: u32) -> u32 {
        let result = match amount {
            0 => value,
            1..=31 => {
                self.flags.c = value >> (amount - 1) & 1 != 0;
                value >> amount
            }
            _ => {
                self.flags.c = amount == 32 && value >> 31 != 0;
                0
            }
        };
        self.set_nz(result)
    }

    /// ASR by 0 to 255; 0 leaves the carry alone, 32 and more give 32 copies of the sign.
    #[inline]
    pub(super) fn shift_right_arithmetic(&mut self, value: u32, amount: u32) -> u32 {
        let signed = value.cast_signed();
        let result = match amount {
            0 => value,
            1..=31 => {
                self.flags.c = value >> (amount - 1) & 1 != 0;
                (signed >> amount).cast_unsigned()
            }
            _ => {
                self.flags.c = signed < 0;
                (signed >> 31).cast_unsigned()
            }
        };
        self.set_nz(result)
    }

    /// ROR by 0 to 255; 0 leaves the carry alone, other multiples of 32 do not.
    #[inline]
    pub(super) fn rotate_right(&mut self, value: u32, amount: u32) -> u32 {
        let result = value.rotate_right(amount & 31);
        if amount != 0 {
            self.flags.c = result >> 31 != 0;
        }
        self.set_nz(result)
    }
}
