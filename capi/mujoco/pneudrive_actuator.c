/* MuJoCo actuator plugin: a calibrated chamber in the place of the built-in first-order cylinder.
 *
 * Its activation is the pressure in the chamber (kPa gauge); everything else that the chamber
 * remembers is plugin state, so that mj_getState, mj_copyData and rollouts hold it all. Length and
 * velocity of the actuator give the chamber's volume and its rate, area and pressure the force: a
 * positive force lengthens the actuator.
 *
 * Build (build.sh beside this file): against the headers of the MuJoCo that loads it.
 * docs/export.md has the attributes.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <mujoco/mujoco.h>

#include "pneudrive.h"

/* A pressure that differs by more than this from what the last step left was set by the user. */
#define SET_BY_USER_KPA 1e-6
/* A chamber keeps this share of its volume when its actuator is pressed to nothing. */
#define LEAST_VOLUME 0.05

enum { PARAMETERS, CHANNEL, CONTROL, AREA, LENGTH, SUPPLY, ATTRIBUTES };

static const char *const ATTRIBUTE[ATTRIBUTES] = {
    "parameters", "channel", "control", "area", "length", "supply",
};

/* One chamber of one mjData. What it remembers is in the mjData's plugin state, not here. */
typedef struct {
    PneudriveChannel *channel;
    PneudriveInputs nominal;
    PneudriveControl control;
    int actuator;      /* its number in the model */
    double area_m2;    /* of the piston */
    double length_m;   /* of the actuator where the volume is the parameter file's */
    int stepped;       /* is the channel at the end of the step whose rate was last asked for? */
    int size;          /* numbers in a state */
} Chamber;

static const char *attribute(const mjModel *m, int instance, int which) {
    const char *value = mj_getPluginConfig(m, instance, ATTRIBUTE[which]);
    return value ? value : "";
}

/* A number, or `otherwise` where the attribute is not given. */
static double number(const mjModel *m, int instance, int which, double otherwise) {
    const char *text = attribute(m, instance, which);
    char *end;
    double value = strtod(text, &end);
    if (*text == '\0') {
        return otherwise;
    }
    while (*end == ' ') {
        end++;
    }
    if (*end != '\0' || !isfinite(value)) {
        mju_error("pneudrive.chamber: %s=\"%s\" is not a number", ATTRIBUTE[which], text);
    }
    return value;
}

static PneudriveControl control_of(const mjModel *m, int instance) {
    const char *text = attribute(m, instance, CONTROL);
    if (*text == '\0' || strcmp(text, "set_point") == 0) {
        return PNEUDRIVE_CONTROL_SET_POINT;
    }
    if (strcmp(text, "drive") != 0) {
        mju_error("pneudrive.chamber: control=\"%s\"; it is \"set_point\" (kPa) or \"drive\" (-1 to 1)", text);
    }
    return PNEUDRIVE_CONTROL_DRIVE;
}

/* A channel as the attributes say; mju_error where that is not possible. */
static PneudriveChannel *create(const mjModel *m, int instance) {
    char message[500];
    PneudriveChannel *channel;
    const char *file = attribute(m, instance, PARAMETERS), *name = attribute(m, instance, CHANNEL);
    if (*file == '\0') {
        mju_error("pneudrive.chamber: the attribute parameters names no file; `pneudrive-model fit` or `diagnose` writes one");
    }
    if (pneudrive_create(file, *name ? name : "b0c0", m->opt.timestep, control_of(m, instance), &channel, message,
                         sizeof message) != PNEUDRIVE_STATUS_OK) {
        mju_error("pneudrive.chamber: %s", message);
    }
    return channel;
}

static int nstate(const mjModel *m, int instance) {
    PneudriveChannel *channel = create(m, instance);
    int size = (int)pneudrive_state_size(channel);
    pneudrive_destroy(channel);
    return size;
}

/* The one actuator of an instance. */
static int actuator_of(const mjModel *m, int instance) {
    int found = -1;
    for (int i = 0; i < m->nu; i++) {
        if (m->actuator_plugin[i] == instance) {
            if (found >= 0) {
                mju_error("pneudrive.chamber: a chamber is one actuator; actuators %d and %d share an instance", found, i);
            }
            found = i;
        }
    }
    if (found < 0) {
        mju_error("pneudrive.chamber: no actuator uses instance %d", instance);
    }
    if (m->actuator_actnum[found] != 1) {
        mju_error("pneudrive.chamber: the actuator needs actdim=\"1\": its activation is the pressure");
    }
    return found;
}

static int init(const mjModel *m, mjData *d, int instance) {
    if (m->opt.integrator == mjINT_RK4) {
        mju_error("pneudrive.chamber: a board's loop takes whole steps, which the integrator RK4 divides; "
                  "use implicitfast, implicit or Euler");
    }
    int actuator = actuator_of(m, instance);
    double area_m2 = number(m, instance, AREA, 0.0), length_m = number(m, instance, LENGTH, 0.0);
    double supply_kpa = number(m, instance, SUPPLY, NAN);
    PneudriveControl control = control_of(m, instance);
    if (!(area_m2 > 0.0)) {
        mju_error("pneudrive.chamber: the attribute area (of the piston, m^2) must be given and positive");
    }
    Chamber *chamber = calloc(1, sizeof *chamber);
    if (!chamber) {
        return -1;
    }
    chamber->channel = create(m, instance);
    chamber->size = (int)pneudrive_state_size(chamber->channel);
    pneudrive_nominal(chamber->channel, &chamber->nominal);
    if (!isnan(supply_kpa)) {
        chamber->nominal.supply_kpa = supply_kpa;
    }
    chamber->actuator = actuator;
    chamber->area_m2 = area_m2;
    chamber->length_m = length_m;
    chamber->control = control;
    d->plugin_data[instance] = (uintptr_t)chamber;
    return 0;
}

static void destroy(mjData *d, int instance) {
    Chamber *chamber = (Chamber *)d->plugin_data[instance];
    if (chamber) {
        pneudrive_destroy(chamber->channel);
        free(chamber);
        d->plugin_data[instance] = 0;
    }
}

static void copy(mjData *to, const mjModel *m, const mjData *from, int instance) {
    (void)from; /* its state is copied by MuJoCo */
    if (!to->plugin_data[instance]) {
        init(m, to, instance);
    }
}

/* A state of zeros is one that was not started: it starts at the activation. */
static void reset(const mjModel *m, double *state, void *data, int instance) {
    (void)m, (void)instance;
    memset(state, 0, sizeof *state * (size_t)((Chamber *)data)->size);
}

static PneudriveInputs inputs_of(const Chamber *chamber, const mjModel *m, const mjData *d) {
    PneudriveInputs inputs = chamber->nominal;
    int i = chamber->actuator;
    double control = d->ctrl[i];
    if (m->actuator_ctrllimited[i]) {
        control = mju_clip(control, m->actuator_ctrlrange[2 * i], m->actuator_ctrlrange[2 * i + 1]);
    }
    if (chamber->control == PNEUDRIVE_CONTROL_DRIVE) {
        inputs.fill = mju_clip(control, -1.0, 1.0);
    } else {
        inputs.set_point_kpa = control;
    }
    double rest = chamber->nominal.volume_m3;
    double volume = rest + chamber->area_m2 * (d->actuator_length[i] - chamber->length_m);
    inputs.volume_m3 = mju_max(volume, LEAST_VOLUME * rest);
    inputs.volume_rate_m3_s = volume > LEAST_VOLUME * rest ? chamber->area_m2 * d->actuator_velocity[i] : 0.0;
    return inputs;
}

/* Steps from the state in `d` with this pressure in the chamber. Returns that at the end, kPa. */
static double step(Chamber *chamber, const mjModel *m, mjData *d, int instance, double kpa) {
    PneudriveInputs inputs = inputs_of(chamber, m, d);
    PneudriveOutputs outputs;
    const double *state = d->plugin_state + m->plugin_stateadr[instance];
    PneudriveStatus status = pneudrive_restore(chamber->channel, state, (size_t)chamber->size);
    if (status == PNEUDRIVE_STATUS_OK && state[0] == 0.0) {
        status = pneudrive_start(chamber->channel, kpa, &inputs, &outputs);
    } else if (status == PNEUDRIVE_STATUS_OK && fabs(kpa - state[PNEUDRIVE_STATE_PRESSURE]) > SET_BY_USER_KPA) {
        status = pneudrive_set_pressure(chamber->channel, kpa);
    }
    if (status == PNEUDRIVE_STATUS_OK) {
        status = pneudrive_step(chamber->channel, &inputs, &outputs);
    }
    if (status != PNEUDRIVE_STATUS_OK) {
        /* MuJoCo warns of what is not finite and resets. */
        return NAN;
    }
    return outputs.pressure_kpa;
}

static void act_dot(const mjModel *m, mjData *d, int instance) {
    Chamber *chamber = (Chamber *)d->plugin_data[instance];
    int address = m->actuator_actadr[chamber->actuator];
    double kpa = d->act[address];
    d->act_dot[address] = (step(chamber, m, d, instance, kpa) - kpa) / m->opt.timestep;
    chamber->stepped = 1;
}

static void compute(const mjModel *m, mjData *d, int instance, int capability) {
    (void)capability;
    Chamber *chamber = (Chamber *)d->plugin_data[instance];
    double kpa = d->act[m->actuator_actadr[chamber->actuator]];
    d->actuator_force[chamber->actuator] = 1e3 * chamber->area_m2 * kpa;
}

static void advance(const mjModel *m, mjData *d, int instance) {
    Chamber *chamber = (Chamber *)d->plugin_data[instance];
    /* The rate of the step that ends now was the last to be asked for. Where actuation is disabled
     * it was not: the chamber stands still. */
    if (chamber->stepped) {
        pneudrive_save(chamber->channel, d->plugin_state + m->plugin_stateadr[instance], (size_t)chamber->size);
        chamber->stepped = 0;
    }
}

mjPLUGIN_LIB_INIT {
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "pneudrive.chamber";
    plugin.capabilityflags = mjPLUGIN_ACTUATOR;
    plugin.nattribute = ATTRIBUTES;
    plugin.attributes = ATTRIBUTE;
    plugin.nstate = nstate;
    plugin.init = init;
    plugin.destroy = destroy;
    plugin.copy = copy;
    plugin.reset = reset;
    plugin.actuator_act_dot = act_dot;
    plugin.compute = compute;
    plugin.advance = advance;
    mjp_registerPlugin(&plugin);
}
