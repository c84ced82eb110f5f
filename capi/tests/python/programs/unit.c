/* An importer of an FMI 3.0 unit in thirty lines: each channel follows steps of its set point.
 * Prints the pressures, exactly.
 *
 *     cc unit.c -ldl -o unit && ./unit LIBRARY RESOURCES TOKEN CHANNELS
 */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* Value references, as models/src/export/fmi.rs numbers them. */
enum { BLOCK = 100, SET_POINT = 0, PRESSURE = 7 };

typedef void *(*Instantiate)(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *, size_t,
                             void *, void *, void *);
typedef int (*Enter)(void *, bool, double, double, bool, double);
typedef int (*Exit)(void *);
typedef int (*Get)(void *, const uint32_t *, size_t, double *, size_t);
typedef int (*Set)(void *, const uint32_t *, size_t, const double *, size_t);
typedef int (*DoStep)(void *, double, double, bool, bool *, bool *, bool *, double *);

static void *library;

static void *find(const char *name) {
    void *function = dlsym(library, name);
    if (!function) {
        fprintf(stderr, "%s\n", dlerror());
        exit(2);
    }
    return function;
}

static void log_message(void *environment, int status, const char *category, const char *message) {
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static void require(int status, const char *what) {
    if (status != 0) {
        fprintf(stderr, "%s answers %d\n", what, status);
        exit(1);
    }
}

int main(int argc, char **argv) {
    if (argc != 5 || !(library = dlopen(argv[1], RTLD_NOW))) {
        fprintf(stderr, "usage: unit LIBRARY RESOURCES TOKEN CHANNELS (%s)\n", argc == 5 ? dlerror() : "");
        return 2;
    }
    int channels = atoi(argv[4]);
    void *unit = ((Instantiate)find("fmi3InstantiateCoSimulation"))("unit", argv[3], argv[2], false, false, false, false,
                                                                   NULL, 0, NULL, (void *)log_message, NULL);
    if (!unit) {
        return 1;
    }
    require(((Enter)find("fmi3EnterInitializationMode"))(unit, false, 0, 0, false, 0), "fmi3EnterInitializationMode");
    require(((Exit)find("fmi3ExitInitializationMode"))(unit), "fmi3ExitInitializationMode");
    Set set = (Set)find("fmi3SetFloat64");
    Get get = (Get)find("fmi3GetFloat64");
    DoStep step = (DoStep)find("fmi3DoStep");
    for (int k = 0; k < 3000; k++) {
        for (int channel = 0; channel < channels; channel++) {
            uint32_t reference = (channel + 1) * BLOCK + SET_POINT;
            double kpa = 40.0 + 60.0 * ((k / 250 + channel) % 4);
            require(set(unit, &reference, 1, &kpa, 1), "fmi3SetFloat64");
        }
        bool event, terminate, early;
        double reached;
        require(step(unit, k * 0.001, 0.001, false, &event, &terminate, &early, &reached), "fmi3DoStep");
        for (int channel = 0; channel < channels; channel++) {
            uint32_t reference = (channel + 1) * BLOCK + PRESSURE;
            double kpa;
            require(get(unit, &reference, 1, &kpa, 1), "fmi3GetFloat64");
            printf("%.17g%c", kpa, channel + 1 < channels ? ' ' : '\n');
        }
    }
    ((void (*)(void *))find("fmi3FreeInstance"))(unit);
    return 0;
}
