/* A calibrated pneumatic chamber, step by step: the C interface of PneuDrive's models
 * (docs/export.md).
 *
 * Pressures are gauge, in kPa. After pneudrive_create nothing allocates memory, blocks or prints.
 * A channel is used by one thread at a time; different channels by as many threads as there are.
 *
 * Made from the Rust sources by a test: do not edit. */

#ifndef PNEUDRIVE_H
#define PNEUDRIVE_H

#include <stddef.h>
#include <stdint.h>

// In an input's `repeats`: the sample at the start of the step repeats the one before it.
#define PNEUDRIVE_REPEATS_START 1

// In an input's `repeats`: the sample at the end of the step repeats the one at its start.
#define PNEUDRIVE_REPEATS_END 2

// In an input's `repeats`: the sample one step after the end of the step repeats the one at its
// end.
#define PNEUDRIVE_REPEATS_AFTER 4

// Where a saved state has the pressure in the chamber, kPa gauge. Its first number is 0 where the
// channel was not started.
#define PNEUDRIVE_STATE_PRESSURE 3

// What a function answers.
typedef enum {
  // Done.
  PNEUDRIVE_STATUS_OK = 0,
  // A null pointer, or memory of the wrong size.
  PNEUDRIVE_STATUS_ARGUMENT = 1,
  // The parameter file, the channel or the step cannot be used; the message says why.
  PNEUDRIVE_STATUS_FILE = 2,
  // An input is not finite, or the volume is not positive. Nothing was changed.
  PNEUDRIVE_STATUS_INPUT = 3,
  // The channel was neither started nor given a state.
  PNEUDRIVE_STATUS_NOT_STARTED = 4,
  // The pressure runs away: start the channel anew, or give it a state.
  PNEUDRIVE_STATUS_RUNS_AWAY = 5,
  // A defect of this library; the channel must not be used any more.
  PNEUDRIVE_STATUS_DEFECT = 6,
} PneudriveStatus;

// What drives a channel.
typedef enum {
  // What drove it when it was calibrated.
  PNEUDRIVE_CONTROL_AS_CALIBRATED = 0,
  // The valve's drive.
  PNEUDRIVE_CONTROL_DRIVE = 1,
  // The set point, through the board's loop; the parameter file's rig must have the tables
  // controller and sensor.
  PNEUDRIVE_CONTROL_SET_POINT = 2,
} PneudriveControl;

// A calibrated channel that is simulated step by step. Nothing but [`create`](Channel::create) and
// [`of`](Channel::of) allocates.
typedef struct PneudriveChannel PneudriveChannel;

// What holds over a step. `pneudrive_nominal` fills it in.
typedef struct {
  // Drive of the spool, -1 (vent) to 1 (fill), or of the fill valve, 0 to 1. Not read where a
  // set point drives.
  double fill;
  // Drive of the vent valve, 0 to 1, where it is one of its own.
  double vent;
  // Set point, kPa gauge; read where it drives the channel. The board follows it from its second
  // loop in the step on.
  double set_point_kpa;
  // Supply pressure, kPa gauge, mean over the step.
  double supply_kpa;
  // Volume of the chamber as its joint stands, m^3, mean over the step; positive.
  double volume_m3;
  // Rate of that volume, m^3/s.
  double volume_rate_m3_s;
  // Pressure of the chamber opposite at the start and at the end of the step, kPa gauge: for the
  // effect chamber_coupling, which stands for a joint that nobody simulates. NaN: there is none,
  // or the volume above says it all.
  double opposite_kpa[2];
  // Reading of the channel that the board's converter samples before this one, at the start and
  // at the end of the step, kPa gauge: for the effect sensor_crosstalk. NaN: unknown.
  double sampled_before_kpa[2];
  // What the other channels draw from the same supply, mm^2 Pa: the sum of their `draw`. For the
  // effect supply_sag.
  double others_draw;
  // Which samples of the sensor were missed and repeat the one before: bits 1 (at the start of
  // the step), 2 (at its end) and 4 (one step later). For the effect stale_samples.
  uint32_t repeats;
} PneudriveInputs;

// The channel at the end of a step. Pressures are gauge, in kPa.
typedef struct {
  // Time since the start, s.
  double time_s;
  // Pressure in the chamber.
  double pressure_kpa;
  // Pressure at the valve: another one where there is a tube between them.
  double port_kpa;
  // What the board reports.
  double reading_kpa;
  // Temperature of the gas, K: ambient, unless the effect heat_exchange is part of the model.
  double temperature_k;
  // Position of the spool (-1 to 1) or the fill valve (0 to 1), behind all effects; NaN of a
  // regulator.
  double fill;
  // Position of the vent valve; minus that of the one spool.
  double vent;
  // Drive before effects, mean over the step, -1 to 1; fill minus vent where there are two
  // valves. NaN of a fitted regulator.
  double drive;
  // Flow drawn from the supply, mean over the step, mm^2 Pa (area by flow pressure); NaN where
  // the model was saved by `fit`.
  double draw;
  // Rate of the pressure in the chamber, mean over the step, kPa/s.
  double rate_kpa_s;
} PneudriveOutputs;

// Derivatives of the pressure at the end of a step: what a controller or a planner linearises
// with. Central differences of two steps each, over 0.1 kPa, 0.001 of full drive, 0.1 % of volume
// and, for the set point, which a board takes in whole counts, 4 kPa.
typedef struct {
  // By the pressure at its start, kPa/kPa.
  double by_pressure;
  // By the drive of the spool or the fill valve, kPa.
  double by_fill;
  // By the drive of the vent valve, kPa; 0 where one spool opens both ports.
  double by_vent;
  // By the set point, kPa/kPa.
  double by_set_point;
  // By the supply pressure, kPa/kPa.
  double by_supply;
  // By the volume, kPa/m^3.
  double by_volume;
  // By the rate of the volume, kPa s/m^3.
  double by_volume_rate;
} PneudrivePartials;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Version of this interface: the first number of a change that old callers do not survive is the
// thousands.
uint32_t pneudrive_abi_version(void);

// Sets up a channel, as in "b0c2", of a parameter file that `pneudrive-model fit` or `diagnose`
// wrote, for steps of `step_s` seconds, and puts a pointer to it into `channel`; `control` is a
// `PneudriveControl`. Where that is not possible, `channel` becomes null and `message` (if not
// null) gets a sentence that says why, cut off at `message_size` bytes including its final zero.
// The texts are UTF-8.
//
// # Safety
// `file` and `name` are texts that end with a zero; `channel` points to a pointer, `message` to
// `message_size` bytes.
PneudriveStatus pneudrive_create(const char *file,
                                 const char *name,
                                 double step_s,
                                 uint32_t control,
                                 PneudriveChannel **channel,
                                 char *message,
                                 size_t message_size);

// Frees a channel. Null is allowed.
//
// # Safety
// `channel` is from `pneudrive_create` and is not used afterwards.
void pneudrive_destroy(PneudriveChannel *channel);

// Fills in the inputs of a channel at rest: no drive, a set point of 0 kPa, the rig's supply
// pressure and the volume of the straight joint, no neighbours.
//
// # Safety
// Pointers from `pneudrive_create` and to inputs.
PneudriveStatus pneudrive_nominal(PneudriveChannel *channel, PneudriveInputs *inputs);

// Begins at rest at a pressure; the inputs hold at the beginning. `outputs` may be null.
//
// # Safety
// Pointers from `pneudrive_create`, to inputs, and to outputs or null.
PneudriveStatus pneudrive_start(PneudriveChannel *channel,
                                double pressure_kpa,
                                const PneudriveInputs *inputs,
                                PneudriveOutputs *outputs);

// Advances by one step over which the inputs hold. `outputs` may be null.
//
// # Safety
// Pointers from `pneudrive_create`, to inputs, and to outputs or null.
PneudriveStatus pneudrive_step(PneudriveChannel *channel,
                               const PneudriveInputs *inputs,
                               PneudriveOutputs *outputs);

// Moves the pressure in the chamber; what the sensor delivers moves with it.
//
// # Safety
// A pointer from `pneudrive_create`.
PneudriveStatus pneudrive_set_pressure(PneudriveChannel *channel, double pressure_kpa);

// Numbers in a state; 0 of a null pointer.
//
// # Safety
// A pointer from `pneudrive_create`, or null.
size_t pneudrive_state_size(const PneudriveChannel *channel);

// Writes the whole state into `size` numbers, `pneudrive_state_size` of them. A channel of the
// same file, name, step and control that takes it goes on with the same numbers.
//
// # Safety
// A pointer from `pneudrive_create`, and room for `size` numbers.
PneudriveStatus pneudrive_save(PneudriveChannel *channel, double *state, size_t size);

// Takes a state back. After one of zeros the channel must be started.
//
// # Safety
// A pointer from `pneudrive_create`, and `size` numbers.
PneudriveStatus pneudrive_restore(PneudriveChannel *channel, const double *state, size_t size);

// Gives the derivatives of the pressure at the end of a step from here. The channel stays where it
// is. It takes 14 steps' time.
//
// # Safety
// Pointers from `pneudrive_create`, to inputs, and to partials.
PneudriveStatus pneudrive_partials(PneudriveChannel *channel,
                                   const PneudriveInputs *inputs,
                                   PneudrivePartials *partials);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* PNEUDRIVE_H */
