//! The functions for C. `include/pneudrive.h` is made from them.
//!
//! Pointers that a function needs may not be null: it then answers `PNEUDRIVE_STATUS_ARGUMENT`. A
//! panic inside, which would be a defect, becomes `PNEUDRIVE_STATUS_DEFECT`.

// What a caller passes across the border cannot be checked by the compiler.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::channel::Channel;
use crate::error::StepError;
use crate::inputs::{Control, Inputs};
use crate::outputs::Outputs;
use crate::partials::Partials;

/// What a function answers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A null pointer, or memory of the wrong size.
    Argument = 1,
    /// The parameter file, the channel or the step cannot be used; the message says why.
    File = 2,
    /// An input is not finite, or the volume is not positive. Nothing was changed.
    Input = 3,
    /// The channel was neither started nor given a state.
    NotStarted = 4,
    /// The pressure runs away: start the channel anew, or give it a state.
    RunsAway = 5,
    /// A defect of this library; the channel must not be used any more.
    Defect = 6,
}

impl From<StepError> for Status {
    fn from(error: StepError) -> Self {
        match error {
            StepError::Input { .. } => Self::Input,
            StepError::NotStarted => Self::NotStarted,
            StepError::RunsAway => Self::RunsAway,
            StepError::State { .. } => Self::Argument,
        }
    }
}

fn guarded(act: impl FnOnce() -> Status) -> Status {
    catch_unwind(AssertUnwindSafe(act)).unwrap_or(Status::Defect)
}

fn answer<T>(result: Result<T, StepError>) -> Status {
    result.map_or_else(Status::from, |_| Status::Ok)
}

/// Version of this interface: the first number of a change that old callers do not survive is the
/// thousands.
#[unsafe(no_mangle)]
pub extern "C" fn pneudrive_abi_version() -> u32 {
    1000
}

/// Sets up a channel, as in "b0c2", of a parameter file that `pneudrive-model fit` or `diagnose`
/// wrote, for steps of `step_s` seconds, and puts a pointer to it into `channel`; `control` is a
/// `PneudriveControl`. Where that is not possible, `channel` becomes null and `message` (if not
/// null) gets a sentence that says why, cut off at `message_size` bytes including its final zero.
/// The texts are UTF-8.
///
/// # Safety
/// `file` and `name` are texts that end with a zero; `channel` points to a pointer, `message` to
/// `message_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_create(
    file: *const c_char,
    name: *const c_char,
    step_s: f64,
    control: u32,
    channel: *mut *mut Channel,
    message: *mut c_char,
    message_size: usize,
) -> Status {
    guarded(|| {
        if file.is_null() || name.is_null() || channel.is_null() {
            return Status::Argument;
        }
        // A number: C may pass one that is none of the kinds.
        let Some(control) = Control::of(control) else { return Status::Argument };
        // SAFETY: the caller promises texts with a final zero and room for a pointer.
        let (file, name) = unsafe {
            *channel = std::ptr::null_mut();
            (CStr::from_ptr(file).to_string_lossy(), CStr::from_ptr(name).to_string_lossy())
        };
        match Channel::create(Path::new(&*file), &name, step_s, control) {
            Ok(created) => {
                // SAFETY: as above.
                unsafe { *channel = Box::into_raw(Box::new(created)) };
                Status::Ok
            }
            Err(error) => {
                // SAFETY: the caller promises so much room.
                unsafe { say(&error.to_string(), message, message_size) };
                Status::File
            }
        }
    })
}

/// Writes a text with a final zero, as much of it as there is room for.
///
/// # Safety
/// `message` is null or points to `size` bytes.
unsafe fn say(text: &str, message: *mut c_char, size: usize) {
    if message.is_null() || size == 0 {
        return;
    }
    let mut length = text.len().min(size - 1);
    while !text.is_char_boundary(length) {
        length -= 1;
    }
    // SAFETY: `length` bytes of the text and a zero fit into `size` bytes.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr().cast(), message, length);
        *message.add(length) = 0;
    }
}

/// Frees a channel. Null is allowed.
///
/// # Safety
/// `channel` is from `pneudrive_create` and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_destroy(channel: *mut Channel) {
    if !channel.is_null() {
        // SAFETY: it was made by `Box::into_raw`, and is given up here.
        drop(unsafe { Box::from_raw(channel) });
    }
}

/// Calls with a channel and another pointer, neither of them null.
macro_rules! with {
    ($channel:ident, $other:ident, $act:expr) => {
        guarded(|| {
            if $channel.is_null() || $other.is_null() {
                return Status::Argument;
            }
            // SAFETY: the caller promises a channel from `pneudrive_create` that no other thread
            // uses now.
            $act(unsafe { &mut *$channel })
        })
    };
}

/// Fills in the inputs of a channel at rest: no drive, a set point of 0 kPa, the rig's supply
/// pressure and the volume of the straight joint, no neighbours.
///
/// # Safety
/// Pointers from `pneudrive_create` and to inputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_nominal(channel: *mut Channel, inputs: *mut Inputs) -> Status {
    with!(channel, inputs, |channel: &mut Channel| {
        // SAFETY: the caller promises inputs.
        unsafe { *inputs = *channel.nominal() };
        Status::Ok
    })
}

/// Begins at rest at a pressure; the inputs hold at the beginning. `outputs` may be null.
///
/// # Safety
/// Pointers from `pneudrive_create`, to inputs, and to outputs or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_start(
    channel: *mut Channel,
    pressure_kpa: f64,
    inputs: *const Inputs,
    outputs: *mut Outputs,
) -> Status {
    with!(channel, inputs, |channel: &mut Channel| {
        // SAFETY: the caller promises inputs, and outputs or null.
        unsafe {
            let status = answer(channel.start(pressure_kpa, &*inputs));
            give(channel, outputs);
            status
        }
    })
}

/// Advances by one step over which the inputs hold. `outputs` may be null.
///
/// # Safety
/// Pointers from `pneudrive_create`, to inputs, and to outputs or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_step(
    channel: *mut Channel,
    inputs: *const Inputs,
    outputs: *mut Outputs,
) -> Status {
    with!(channel, inputs, |channel: &mut Channel| {
        // SAFETY: the caller promises inputs, and outputs or null.
        unsafe {
            let status = answer(channel.step(&*inputs));
            give(channel, outputs);
            status
        }
    })
}

/// Writes where the channel stands.
///
/// # Safety
/// `outputs` is null or points to outputs.
unsafe fn give(channel: &Channel, outputs: *mut Outputs) {
    if !outputs.is_null() {
        // SAFETY: the caller promises it.
        unsafe { *outputs = *channel.outputs() };
    }
}

/// Moves the pressure in the chamber; what the sensor delivers moves with it.
///
/// # Safety
/// A pointer from `pneudrive_create`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_set_pressure(channel: *mut Channel, pressure_kpa: f64) -> Status {
    guarded(|| {
        if channel.is_null() {
            return Status::Argument;
        }
        // SAFETY: the caller promises a channel that no other thread uses now.
        answer(unsafe { &mut *channel }.set_pressure(pressure_kpa))
    })
}

/// Numbers in a state; 0 of a null pointer.
///
/// # Safety
/// A pointer from `pneudrive_create`, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_state_size(channel: *const Channel) -> usize {
    if channel.is_null() {
        return 0;
    }
    // SAFETY: the caller promises a channel.
    unsafe { &*channel }.state_size()
}

/// Writes the whole state into `size` numbers, `pneudrive_state_size` of them. A channel of the
/// same file, name, step and control that takes it goes on with the same numbers.
///
/// # Safety
/// A pointer from `pneudrive_create`, and room for `size` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_save(channel: *mut Channel, state: *mut f64, size: usize) -> Status {
    guarded(|| {
        if channel.is_null() || state.is_null() {
            return Status::Argument;
        }
        // SAFETY: the caller promises a channel that no other thread uses now, and room for so many
        // numbers.
        let (channel, state) = unsafe { (&mut *channel, std::slice::from_raw_parts_mut(state, size)) };
        answer(channel.save(state))
    })
}

/// Takes a state back. After one of zeros the channel must be started.
///
/// # Safety
/// A pointer from `pneudrive_create`, and `size` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_restore(channel: *mut Channel, state: *const f64, size: usize) -> Status {
    guarded(|| {
        if channel.is_null() || state.is_null() {
            return Status::Argument;
        }
        // SAFETY: the caller promises a channel that no other thread uses now, and so many numbers.
        let (channel, state) = unsafe { (&mut *channel, std::slice::from_raw_parts(state, size)) };
        answer(channel.restore(state))
    })
}

/// Gives the derivatives of the pressure at the end of a step from here. The channel stays where it
/// is. It takes 14 steps' time.
///
/// # Safety
/// Pointers from `pneudrive_create`, to inputs, and to partials.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pneudrive_partials(
    channel: *mut Channel,
    inputs: *const Inputs,
    partials: *mut Partials,
) -> Status {
    if inputs.is_null() {
        return Status::Argument;
    }
    with!(channel, partials, |channel: &mut Channel| {
        // SAFETY: the caller promises inputs.
        match channel.partials(unsafe { &*inputs }) {
            Ok(found) => {
                // SAFETY: the caller promises room for them.
                unsafe { *partials = found };
                Status::Ok
            }
            Err(error) => error.into(),
        }
    })
}
