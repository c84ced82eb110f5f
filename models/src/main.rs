//! `pneudrive-model`: the command line of the modelling toolkit.

fn main() {}
