//! The integer divider (2.3.1.5). Results are there at once; the chip takes eight cycles, which
//! software waits for.

/// Register offsets (2.3.1.7).
const DIV_UDIVIDEND: u32 = 0x060;
const DIV_UDIVISOR: u32 = 0x064;
const DIV_SDIVIDEND: u32 = 0x068;
const DIV_SDIVISOR: u32 = 0x06c;
const DIV_QUOTIENT: u32 = 0x070;
const DIV_REMAINDER: u32 = 0x074;

const CSR_READY: u32 = 1 << 0;
const CSR_DIRTY: u32 = 1 << 1;

#[derive(Clone, Debug, Default)]
pub(super) struct Divider {
    dividend: u32,
    divisor: u32,
    quotient: u32,
    remainder: u32,
    /// Written since QUOTIENT was last read: an interrupt handler must save the results.
    dirty: bool,
}

impl Divider {
    pub fn read(&mut self, offset: u32) -> u32 {
        match offset {
            DIV_UDIVIDEND | DIV_SDIVIDEND => self.dividend,
            DIV_UDIVISOR | DIV_SDIVISOR => self.divisor,
            DIV_QUOTIENT => {
                self.dirty = false;
                self.quotient
            }
            DIV_REMAINDER => self.remainder,
            _ => CSR_READY | if self.dirty { CSR_DIRTY } else { 0 },
        }
    }

    pub fn write(&mut self, offset: u32, value: u32) {
        self.dirty = true;
        match offset {
            DIV_UDIVIDEND => {
                self.dividend = value;
                self.divide_unsigned();
            }
            DIV_UDIVISOR => {
                self.divisor = value;
                self.divide_unsigned();
            }
            DIV_SDIVIDEND => {
                self.dividend = value;
                self.divide_signed();
            }
            DIV_SDIVISOR => {
                self.divisor = value;
                self.divide_signed();
            }
            DIV_QUOTIENT => self.quotient = value,
            DIV_REMAINDER => self.remainder = value,
            _ => {}
        }
    }

    /// Division by zero gives all ones and the dividend.
    fn divide_unsigned(&mut self) {
        self.quotient = self.dividend.checked_div(self.divisor).unwrap_or(u32::MAX);
        self.remainder = self.dividend.checked_rem(self.divisor).unwrap_or(self.dividend);
    }

    /// Division by zero gives 1 with the opposite sign of the dividend (-1 for zero) and the
    /// dividend.
    fn divide_signed(&mut self) {
        let (dividend, divisor) = (self.dividend.cast_signed(), self.divisor.cast_signed());
        if divisor == 0 {
            self.quotient = if dividend < 0 { 1 } else { u32::MAX };
            self.remainder = self.dividend;
        } else {
            self.quotient = dividend.wrapping_div(divisor).cast_unsigned();
            self.remainder = dividend.wrapping_rem(divisor).cast_unsigned();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signed(dividend: i32, divisor: i32) -> (i32, i32) {
        let mut divider = Divider::default();
        divider.write(DIV_SDIVIDEND, dividend.cast_unsigned());
        divider.write(DIV_SDIVISOR, divisor.cast_unsigned());
        (divider.read(DIV_QUOTIENT).cast_signed(), divider.read(DIV_REMAINDER).cast_signed())
    }

    fn unsigned(dividend: u32, divisor: u32) -> (u32, u32) {
        let mut divider = Divider::default();
        divider.write(DIV_UDIVIDEND, dividend);
        divider.write(DIV_UDIVISOR, divisor);
        (divider.read(DIV_QUOTIENT), divider.read(DIV_REMAINDER))
    }

    #[test]
    fn quotients_round_towards_zero() {
        assert_eq!(signed(-7, 2), (-3, -1));
        assert_eq!(signed(7, -2), (-3, 1));
        assert_eq!(signed(i32::MIN, -1), (i32::MIN, 0));
        assert_eq!(unsigned(0xffff_fff9, 2), (0x7fff_fffc, 1));
    }

    #[test]
    fn division_by_zero_follows_the_datasheet() {
        assert_eq!(unsigned(5, 0), (u32::MAX, 5));
        assert_eq!(signed(5, 0), (-1, 5));
        assert_eq!(signed(-5, 0), (1, -5));
    }

    #[test]
    fn reading_the_quotient_clears_dirty() {
        let mut divider = Divider::default();
        divider.write(DIV_UDIVIDEND, 1);
        assert_eq!(divider.read(0x78), CSR_READY | CSR_DIRTY);
        divider.read(DIV_QUOTIENT);
        assert_eq!(divider.read(0x78), CSR_READY);
    }
}
