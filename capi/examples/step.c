/* A chamber follows a step of its set point: prints time and pressure as CSV.
 *
 *     cc step.c -I. -L. -lpneudrive_capi -Wl,-rpath,'$ORIGIN' -o step
 *     ./step parameters.toml b0c0 150 > step.csv
 *
 * beside what `pneudrive-model export c` writes; in a clone, with -I../include
 * -L../../target/release instead.
 */
#include <stdio.h>
#include <stdlib.h>

#include "pneudrive.h"

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "usage: step PARAMETERS.toml CHANNEL SET_POINT_KPA\n");
        return 2;
    }
    char message[500];
    PneudriveChannel *channel;
    if (pneudrive_create(argv[1], argv[2], 0.001, PNEUDRIVE_CONTROL_SET_POINT, &channel, message, sizeof message) !=
        PNEUDRIVE_STATUS_OK) {
        fprintf(stderr, "%s\n", message);
        return 2;
    }

    PneudriveInputs inputs;
    PneudriveOutputs outputs;
    pneudrive_nominal(channel, &inputs);
    pneudrive_start(channel, 0.0, &inputs, &outputs);
    inputs.set_point_kpa = atof(argv[3]);
    printf("t_s,p_kpa,reading_kpa,drive\n");
    for (int step = 0; step < 2000; step++) {
        if (pneudrive_step(channel, &inputs, &outputs) != PNEUDRIVE_STATUS_OK) {
            fprintf(stderr, "the simulation ends at %g s\n", outputs.time_s);
            pneudrive_destroy(channel);
            return 1;
        }
        printf("%.3f,%.6f,%.6f,%.4f\n", outputs.time_s, outputs.pressure_kpa, outputs.reading_kpa, outputs.drive);
    }
    pneudrive_destroy(channel);
    return 0;
}
