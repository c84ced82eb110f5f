#!/bin/sh
# Builds the actuator plugin against the headers and the library of a Python's mujoco package:
#     sh build.sh PYTHON [FOLDER]
# FOLDER has pneudrive.h and libpneudrive_capi.so; it is this one unless it is given. For another
# machine, CC is its compiler and MUJOCO the folder of its mujoco package, as
# `pip download --platform` and unzip leave it: PYTHON is not asked then.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
folder=${2:-$here}
mujoco=${MUJOCO:-$("${1:-python3}" -c 'import mujoco, os; print(os.path.dirname(mujoco.__file__))')}
library=$(ls "$mujoco"/libmujoco.so* | head -n 1)
"${CC:-cc}" -shared -fPIC -O2 -Wall -Wextra -Werror "$here/pneudrive_actuator.c" -o "$folder/libpneudrive_actuator.so" \
    -isystem "$mujoco/include" -I"$folder" "$library" -L"$folder" -lpneudrive_capi -Wl,-rpath,'$ORIGIN' -Wl,-rpath,"$mujoco"
echo "built $folder/libpneudrive_actuator.so"
