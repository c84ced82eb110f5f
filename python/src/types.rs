//! What arrays and dictionaries are called in the type stubs: the NumPy bindings say nothing about
//! it.

use numpy::ndarray::{Dimension, Ix1, Ix2};
use numpy::{Element, PyArray};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pyo3::{Borrowed, type_hint_identifier, type_hint_subscript, type_hint_union};
use std::convert::Infallible;
use std::marker::PhantomData;

const ARRAY_LIKE: PyStaticExpr = type_hint_identifier!("numpy.typing", "ArrayLike");

/// Something with a name in stubs.
pub trait Named {
    const NAME: PyStaticExpr;
}

impl Named for f64 {
    const NAME: PyStaticExpr = type_hint_identifier!("numpy", "float64");
}

impl Named for bool {
    const NAME: PyStaticExpr = type_hint_identifier!("numpy", "bool_");
}

/// An array that is returned: `NDArray[float64]`.
pub struct Array<'py, T, D>(pub Bound<'py, PyArray<T, D>>);

/// Floats of shape (n,).
pub type Vector<'py> = Array<'py, f64, Ix1>;

/// Floats of shape (n, m).
pub type Matrix<'py> = Array<'py, f64, Ix2>;

impl<'py, T: Element + Named, D: Dimension> IntoPyObject<'py> for Array<'py, T, D> {
    type Target = PyArray<T, D>;
    type Output = Bound<'py, Self::Target>;
    type Error = Infallible;

    const OUTPUT_TYPE: PyStaticExpr =
        type_hint_subscript!(type_hint_identifier!("numpy.typing", "NDArray"), T::NAME);

    fn into_pyobject(self, _: Python<'py>) -> Result<Self::Output, Infallible> {
        Ok(self.0)
    }
}

/// A dictionary from names to values of type `V`.
pub struct Dict<'py, V>(pub Bound<'py, PyDict>, PhantomData<V>);

impl<'py, V> Dict<'py, V> {
    pub fn new(dict: Bound<'py, PyDict>) -> Self {
        Self(dict, PhantomData)
    }
}

impl<'py, V: IntoPyObject<'py>> IntoPyObject<'py> for Dict<'py, V> {
    type Target = PyDict;
    type Output = Bound<'py, PyDict>;
    type Error = Infallible;

    const OUTPUT_TYPE: PyStaticExpr = type_hint_subscript!(
        type_hint_identifier!("builtins", "dict"),
        type_hint_identifier!("builtins", "str"),
        V::OUTPUT_TYPE
    );

    fn into_pyobject(self, _: Python<'py>) -> Result<Self::Output, Infallible> {
        Ok(self.0)
    }
}

/// An argument that NumPy can make an array of.
pub struct ArrayLike<'py>(pub Bound<'py, PyAny>);

impl<'py> FromPyObject<'_, 'py> for ArrayLike<'py> {
    type Error = Infallible;

    const INPUT_TYPE: PyStaticExpr = ARRAY_LIKE;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> Result<Self, Infallible> {
        Ok(Self(object.to_owned()))
    }
}

/// An argument that is array-like, or a dictionary from names to such.
pub struct NamedArrays<'py>(pub Bound<'py, PyAny>);

impl<'py> FromPyObject<'_, 'py> for NamedArrays<'py> {
    type Error = Infallible;

    const INPUT_TYPE: PyStaticExpr = type_hint_union!(
        ARRAY_LIKE,
        type_hint_subscript!(
            type_hint_identifier!("builtins", "dict"),
            type_hint_identifier!("builtins", "str"),
            ARRAY_LIKE
        )
    );

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> Result<Self, Infallible> {
        Ok(Self(object.to_owned()))
    }
}
