//! What a unit answers.

use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use super::unit::Unit;

/// `fmi3Status`, as far as a unit of chambers answers it: it has neither remarks (1) nor steps that
/// it does not take (2).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Not possible; the instance goes on.
    Error = 3,
    /// The instance cannot go on.
    Fatal = 4,
}

type Log = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

/// An instance with the importer's means to be told something.
pub struct Instance {
    unit: Unit,
    environment: *mut c_void,
    log: Option<Log>,
}

impl Instance {
    fn say(&self, text: &str) {
        // SAFETY: the importer's function and environment, as given at instantiation.
        unsafe { tell(self.log, self.environment, text) };
    }
}

/// # Safety
/// `log` and `environment` belong together.
unsafe fn tell(log: Option<Log>, environment: *mut c_void, text: &str) {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    if let Some(log) = log {
        // SAFETY: as the caller's.
        unsafe { log(environment, Status::Error, c"logStatusError".as_ptr(), text.as_ptr()) };
    }
}

/// Runs with the instance; what goes wrong is told to the importer.
///
/// # Safety
/// `instance` is null or from `fmi3InstantiateCoSimulation`, and no other thread uses it now.
pub unsafe fn with(instance: *mut Instance, act: impl FnOnce(&mut Unit) -> Result<(), String>) -> Status {
    // SAFETY: the importer promises it.
    let Some(instance) = (unsafe { instance.as_mut() }) else { return Status::Error };
    match catch_unwind(AssertUnwindSafe(|| act(&mut instance.unit))) {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(words)) => {
            instance.say(&words);
            Status::Error
        }
        Err(_) => Status::Fatal,
    }
}

/// # Safety
/// `text` is null or ends with a zero.
unsafe fn text(text: *const c_char) -> String {
    if text.is_null() {
        String::new()
    } else {
        // SAFETY: the importer promises it.
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    }
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Nothing is logged but what goes wrong.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut Instance,
    _on: bool,
    _count: usize,
    _categories: *const *const c_char,
) -> Status {
    // SAFETY: the importer's instance.
    unsafe { with(instance, |_| Ok(())) }
}

/// Makes an instance of the unit whose resources are in a folder; null where that is not possible.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediates: usize,
    environment: *mut c_void,
    log: Option<Log>,
    _update: *const c_void,
) -> *mut Instance {
    // SAFETY: texts of the importer.
    let (token, resources) = unsafe { (text(token), text(resources)) };
    match catch_unwind(|| Unit::new(Path::new(&resources), &token)) {
        Ok(Ok(unit)) => Box::into_raw(Box::new(Instance { unit, environment, log })),
        Ok(Err(words)) => {
            // SAFETY: the importer's.
            unsafe { tell(log, environment, &words) };
            std::ptr::null_mut()
        }
        Err(_) => std::ptr::null_mut(),
    }
}

/// Frees an instance.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut Instance) {
    if !instance.is_null() {
        // SAFETY: made by `Box::into_raw`, and given up here.
        drop(unsafe { Box::from_raw(instance) });
    }
}

/// Start values may be set now. The start time is kept until the end of the initialization.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut Instance,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_s: f64,
    _stop_defined: bool,
    _stop_s: f64,
) -> Status {
    // SAFETY: the importer's instance.
    unsafe { with(instance, |unit| unit.set_start_time(start_s)) }
}

/// The start is over.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut Instance) -> Status {
    // SAFETY: the importer's instance.
    unsafe { with(instance, Unit::begin) }
}

/// Nothing is left to be done.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut Instance) -> Status {
    // SAFETY: the importer's instance.
    unsafe { with(instance, |_| Ok(())) }
}

/// As it was instantiated.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut Instance) -> Status {
    let reset = |unit: &mut Unit| {
        unit.reset();
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, reset) }
}

/// Values of variables.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut Instance,
    references: *const u32,
    count: usize,
    values: *mut f64,
    room: usize,
) -> Status {
    let get = |unit: &mut Unit| {
        if room < count || references.is_null() || values.is_null() {
            return Err("fmi3GetFloat64: room for fewer values than there are references".to_owned());
        }
        for k in 0..count {
            // SAFETY: `count` references and at least as many values, says the importer.
            let (reference, value) = unsafe { (*references.add(k), &mut *values.add(k)) };
            let found = unit.get(reference);
            *value = found.ok_or_else(|| format!("fmi3GetFloat64: no value reference {reference}"))?;
        }
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, get) }
}

/// Sets variables.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut Instance,
    references: *const u32,
    count: usize,
    values: *const f64,
    given: usize,
) -> Status {
    let set = |unit: &mut Unit| {
        if given < count || references.is_null() || values.is_null() {
            return Err("fmi3SetFloat64: fewer values than references".to_owned());
        }
        for k in 0..count {
            // SAFETY: `count` references and at least as many values, says the importer.
            let (reference, value) = unsafe { (*references.add(k), *values.add(k)) };
            unit.set(reference, value)?;
        }
        Ok(())
    };
    // SAFETY: the importer's instance.
    unsafe { with(instance, set) }
}

/// Advances to the next communication point. There are no events, and no early return.
///
/// # Safety
/// As the standard says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut Instance,
    from_s: f64,
    length_s: f64,
    _no_rollback: bool,
    event: *mut bool,
    terminate: *mut bool,
    early: *mut bool,
    reached_s: *mut f64,
) -> Status {
    for flag in [event, terminate, early] {
        if !flag.is_null() {
            // SAFETY: the importer's.
            unsafe { *flag = false };
        }
    }
    // SAFETY: the importer's instance.
    let status = unsafe { with(instance, |unit| unit.advance(from_s, length_s)) };
    if !reached_s.is_null() {
        // SAFETY: the importer's.
        unsafe { *reached_s = if status == Status::Ok { from_s + length_s } else { from_s } };
    }
    status
}
