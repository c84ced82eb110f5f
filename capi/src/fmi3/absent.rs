//! What the standard knows and a unit of chambers does not have: it answers `fmi3Error`. Importers
//! look these names up all the same.

use std::ffi::{c_char, c_void};

use super::functions::{Instance, Status};

/// Functions with these arguments that answer an error.
macro_rules! absent {
    ($arguments:tt: $($name:ident)*) => {
        $(absent!(@one $name $arguments);)*
    };
    (@one $name:ident ($($argument:ty),*)) => {
        /// Not there.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name($(_: $argument),*) -> Status {
            Status::Error
        }
    };
}

type Sizes = *const usize;
type References = *const u32;

// Values of other types: instance, references and their number, values and their number.
absent! { (*mut Instance, References, usize, *mut c_void, usize):
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32 fmi3GetUInt32 fmi3GetInt64
    fmi3GetUInt64 fmi3GetBoolean fmi3GetString
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64
    fmi3SetUInt64 fmi3SetBoolean fmi3SetString
}
absent! { (*mut Instance, References, usize, Sizes, *mut c_void, usize): fmi3GetBinary fmi3SetBinary }
absent! { (*mut Instance, References, usize, *mut c_void):
fmi3GetClock fmi3SetClock fmi3GetShiftDecimal fmi3SetIntervalDecimal fmi3SetShiftDecimal }
absent! { (*mut Instance, References, usize, *mut c_void, *mut c_void):
fmi3GetIntervalDecimal fmi3GetShiftFraction fmi3SetIntervalFraction fmi3SetShiftFraction }
absent! { (*mut Instance, References, usize, *mut c_void, *mut c_void, *mut c_void): fmi3GetIntervalFraction }
// Dependencies and derivatives.
absent! { (*mut Instance, u32, *mut usize): fmi3GetNumberOfVariableDependencies }
absent! { (*mut Instance, u32, *mut c_void, *mut c_void, *mut c_void, *mut c_void, usize):
fmi3GetVariableDependencies }
absent! { (*mut Instance, References, usize, References, usize, *const f64, usize, *mut f64, usize):
fmi3GetDirectionalDerivative fmi3GetAdjointDerivative }
absent! { (*mut Instance, References, usize, *const i32, *mut f64, usize): fmi3GetOutputDerivatives }
// Modes that there are not.
absent! { (*mut Instance):
fmi3EnterConfigurationMode fmi3ExitConfigurationMode fmi3EnterEventMode fmi3EnterStepMode
fmi3EvaluateDiscreteStates fmi3EnterContinuousTimeMode }
absent! { (*mut Instance, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64): fmi3UpdateDiscreteStates }
// Model exchange and scheduled execution.
absent! { (*mut Instance, bool, *mut bool, *mut bool): fmi3CompletedIntegratorStep }
absent! { (*mut Instance, f64): fmi3SetTime }
absent! { (*mut Instance, *mut f64, usize):
fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators fmi3GetContinuousStates
fmi3GetNominalsOfContinuousStates }
absent! { (*mut Instance, *mut usize): fmi3GetNumberOfEventIndicators fmi3GetNumberOfContinuousStates }
absent! { (*mut Instance, u32, f64): fmi3ActivateModelPartition }

/// There is no model exchange.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateModelExchange(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: *const c_void,
) -> *mut Instance {
    std::ptr::null_mut()
}

/// There is no scheduled execution.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub extern "C" fn fmi3InstantiateScheduledExecution(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: *mut c_void,
    _: *const c_void,
    _: *const c_void,
    _: *const c_void,
    _: *const c_void,
) -> *mut Instance {
    std::ptr::null_mut()
}
