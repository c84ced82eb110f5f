//! How a board wires the chip, in one place: the counterpart of `firmware/src/pins.rs`.
//!
//! The valve pins have pull-ups on the board (vent while nothing drives them), the switch closes to
//! ground, and a divider brings the sensor's 0 to 5 V to the ADC's 0 to 3.3 V in proportion, both
//! supplies being each other's reference: the ADC's 12-bit code is the sensor's share of its
//! supply.

/// I2C block of the connector.
pub(super) const I2C_BLOCK: usize = 0;
/// Its data line.
pub(super) const I2C_SDA: usize = 4;
/// Its clock line.
pub(super) const I2C_SCL: usize = 5;
/// The supply pressure's converter, ADDR at ground.
pub(super) const SUPPLY_ADDRESS: u8 = 0x48;
/// The IMU, SDO at ground.
pub(super) const IMU_ADDRESS: u8 = 0x68;
/// UART of the bus.
pub(super) const BUS_UART: usize = 0;
/// DIR pins of valves 0 to 3.
pub(super) const DIR: [usize; 4] = [7, 9, 11, 13];
/// PWM pins of valves 0 to 3.
pub(super) const PWM: [usize; 4] = [6, 8, 10, 12];
/// The address switch, first and second; closed is low and adds 1 and 2 to the address.
pub(super) const SWITCH: [usize; 2] = [14, 15];
/// ADC channels of pressures 0 to 3.
pub(super) const PRESSURE: [usize; 4] = [0, 1, 2, 3];
