//! Arrays filled in place.

/// Up to here an array is filled without a loop: as many as are written out below.
const FEW: usize = 8;

/// Like [`std::array::from_fn`], but surely inlined. Code that is left in a function of its own is
/// compiled for the oldest processor, outside the versions with wider vectors. Give the closure
/// `#[inline(always)]` too.
///
/// Few values are written out: the compiler would unroll their loop, too, but after it has copied
/// the loop to each of a kernel's thousands of operations.
#[inline(always)]
pub(crate) fn filled<T: Copy, const N: usize>(blank: T, mut value: impl FnMut(usize) -> T) -> [T; N] {
    let mut array = [blank; N];
    macro_rules! written_out {
        ($($i:literal)*) => { $(
            if const { N <= FEW && $i < N } {
                array[$i] = value($i);
            }
        )* };
    }
    written_out!(0 1 2 3 4 5 6 7);
    if const { N > FEW } {
        let mut i = 0;
        while i < N {
            array[i] = value(i);
            i += 1;
        }
    }
    array
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_place_gets_its_value_with_and_without_a_loop() {
        fn places<const N: usize>() -> [usize; N] {
            filled(usize::MAX, |i| i)
        }
        assert_eq!(places::<1>(), [0]);
        assert_eq!(places::<4>(), [0, 1, 2, 3]);
        assert_eq!(places::<FEW>(), std::array::from_fn(|i| i));
        assert_eq!(places::<{ FEW + 1 }>(), std::array::from_fn(|i| i));
    }
}
