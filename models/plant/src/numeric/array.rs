//! Arrays filled in place.

/// Like [`std::array::from_fn`], but surely inlined. Code that is left in a function of its own is
/// compiled for the oldest processor, outside the versions with wider vectors. Give the closure
/// `#[inline(always)]` too.
#[inline(always)]
pub(crate) fn filled<T: Copy, const N: usize>(blank: T, mut value: impl FnMut(usize) -> T) -> [T; N] {
    let mut array = [blank; N];
    let mut i = 0;
    while i < N {
        array[i] = value(i);
        i += 1;
    }
    array
}
