//! States of a unit: kept, taken back, as bytes.

use super::functions::{Instance, Status, with};
use super::unit::Unit;

/// A kept state.
pub type State = Vec<f64>;

/// Keeps the state, in memory that was made before or anew.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: *mut Instance, state: *mut *mut State) -> Status {
    let get = |unit: &mut Unit| {
        let kept = unit.save();
        // SAFETY: the importer's pointer, null or from an earlier call.
        unsafe {
            match (*state).as_mut() {
                Some(before) => *before = kept,
                None => *state = Box::into_raw(Box::new(kept)),
            }
        }
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, get) }
}

/// Takes a state back.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut Instance, state: *mut State) -> Status {
    let set = |unit: &mut Unit| {
        // SAFETY: a state from `fmi3GetFMUState` or `fmi3DeserializeFMUState`.
        let known = unsafe { state.as_ref() }.is_some_and(|state| unit.restore(state));
        if known { Ok(()) } else { Err("the state is of another unit".to_owned()) }
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, set) }
}

/// Frees a state.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(instance: *mut Instance, state: *mut *mut State) -> Status {
    let free = |_: &mut Unit| {
        // SAFETY: null or from `Box::into_raw`, and given up here.
        unsafe {
            if !state.is_null() && !(*state).is_null() {
                drop(Box::from_raw(*state));
                *state = std::ptr::null_mut();
            }
        }
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, free) }
}

/// Bytes of a state.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: *mut Instance,
    state: *const State,
    size: *mut usize,
) -> Status {
    let measure = |_: &mut Unit| {
        // SAFETY: a state of the importer's, and room for a size.
        unsafe { *size = state.as_ref().map_or(0, |state| 8 * state.len()) };
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, measure) }
}

/// A state as bytes.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut Instance,
    state: *const State,
    bytes: *mut u8,
    size: usize,
) -> Status {
    let serialize = |_: &mut Unit| {
        // SAFETY: a state of the importer's.
        let state = unsafe { state.as_ref() }.ok_or("no state")?;
        if size < 8 * state.len() {
            return Err("fmi3SerializeFMUState: too little room".to_owned());
        }
        for (k, byte) in state.iter().flat_map(|value| value.to_le_bytes()).enumerate() {
            // SAFETY: room for `size` bytes.
            unsafe { *bytes.add(k) = byte };
        }
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, serialize) }
}

/// A state from bytes.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut Instance,
    bytes: *const u8,
    size: usize,
    state: *mut *mut State,
) -> Status {
    let deserialize = |_: &mut Unit| {
        // SAFETY: `size` bytes of the importer's.
        let bytes = unsafe { std::slice::from_raw_parts(bytes, size) };
        let (words, rest) = bytes.as_chunks::<8>();
        if !rest.is_empty() {
            return Err("fmi3DeserializeFMUState: not a state of this unit".to_owned());
        }
        let kept: State = words.iter().map(|word| f64::from_le_bytes(*word)).collect();
        // SAFETY: the importer's pointer, null or from an earlier call.
        unsafe {
            match (*state).as_mut() {
                Some(before) => *before = kept,
                None => *state = Box::into_raw(Box::new(kept)),
            }
        }
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, deserialize) }
}
