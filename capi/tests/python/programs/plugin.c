/* A robot with one chamber in MuJoCo: its set point steps. Prints pressure and angle, exactly.
 *
 *     cc plugin.c -I.. libmujoco.so -o plugin && ./plugin LIBRARY ROBOT.xml
 */
#include <stdio.h>

#include <mujoco/mujoco.h>

int main(int argc, char **argv) {
    char message[1000] = "";
    if (argc != 3) {
        fprintf(stderr, "usage: plugin LIBRARY ROBOT.xml\n");
        return 2;
    }
    mj_loadPluginLibrary(argv[1]);
    mjModel *model = mj_loadXML(argv[2], NULL, message, sizeof message);
    if (!model) {
        fprintf(stderr, "%s\n", message);
        return 1;
    }
    mjData *data = mj_makeData(model);
    for (int k = 0; k < 3000; k++) {
        data->ctrl[0] = 40.0 + 60.0 * (k / 250 % 4);
        mj_step(model, data);
        printf("%.17g %.17g\n", data->act[0], data->qpos[0]);
    }
    mj_deleteData(data);
    mj_deleteModel(model);
    return 0;
}
