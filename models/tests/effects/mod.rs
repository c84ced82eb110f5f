//! The catalogue of effects, entry by entry: absent at its null value, differentiated exactly, and
//! true to a law of physics.

mod bench;
mod derivatives;
mod null;
mod physics;
mod random;
