use super::{Character, Heard};
use pneudrive_protocol::{Address, Baud};

/// A board on the virtual bus: the control crate run natively, or an emulated chip with our
/// firmware in it.
///
/// The bus calls in order of virtual time. At every event it first [`advance`](Self::advance)s all
/// nodes to that time, then takes what they began to [`transmit`](Self::transmit), then lets them
/// [`receive`](Self::receive) what ended.
///
/// A node may run ahead of what it can hear by at most one character: a start bit that falls at `s`
/// is heard at its stop bit, one character later. So a node whose next event is unknown (a chip
/// executing code) names `now` plus anything up to one character as its next event, and nothing is
/// ever heard too late.
pub trait BusNode {
    /// The address it answers to; the referee compares.
    fn address(&self) -> Address;

    /// The line rate at which it speaks and listens; `None` is that of the rig.
    fn baud(&self) -> Option<Baud> {
        None
    }

    /// From now on the shortest character on the bus takes this long, ns.
    fn set_shortest_character(&mut self, _ns: u64) {}

    /// When it must next be advanced even if nothing is heard, ns; at or after the time it was last
    /// advanced to.
    fn next_event_ns(&self) -> u64;

    /// Runs it up to and including `now_ns`; `air` has the pressures at its sensors and takes its
    /// drives.
    fn advance(&mut self, now_ns: u64, air: &mut dyn Air);

    /// The next character whose start bit has fallen, at most one character before the time it was
    /// advanced to.
    fn transmit(&mut self) -> Option<Character>;

    /// A stop bit ended at `now_ns`. A board does not hear itself.
    fn receive(&mut self, now_ns: u64, heard: Heard);

    /// The supply of the board (not of the air) goes off or comes back, at `now_ns`. Off, it
    /// neither hears nor speaks and its valves vent; back on, it starts from reset.
    fn set_powered(&mut self, powered: bool, now_ns: u64, air: &mut dyn Air);
}

/// How a board's joint is bent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointNow {
    /// Bending angles `q_u`, `q_v`, rad.
    pub angles_rad: [f64; 2],
    /// Their rates, rad/s.
    pub rates_rad_s: [f64; 2],
}

/// What a board has on its pneumatic side: four sensors and four valves, and what parts on its I2C
/// connector measure.
pub trait Air {
    /// The sensors of the board at position `board` as 12-bit ratiometric codes (0 to 4095 over 0
    /// to 5 V), at `now_ns`.
    ///
    /// Calls come in order of time.
    fn sample(&mut self, board: u8, now_ns: u64) -> [u16; 4];

    /// Sets a board's valve drives from `now_ns` on: -1 (vent fully) to 1 (fill fully).
    fn drive(&mut self, board: u8, now_ns: u64, drives: [f64; 4]);

    /// The pressure that the valves draw from, above the atmosphere, Pa, at `now_ns`; `None` where
    /// there is no supply.
    fn supply_pa(&mut self, _now_ns: u64) -> Option<f64> {
        None
    }

    /// How the joint of the board at position `board` is bent at `now_ns`. At rest where there is
    /// none.
    fn joint(&mut self, _board: u8, _now_ns: u64) -> JointNow {
        JointNow::default()
    }

    /// Does a part of the work that lies before `until_ns` in advance, about one integration step;
    /// says whether any is left. Drives do not change before `until_ns`, so that this changes no
    /// result, only when it is computed.
    fn work_ahead(&mut self, _until_ns: u64) -> bool {
        false
    }
}
