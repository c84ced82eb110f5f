#!/bin/sh
# The table of docs/models.md: all sixteen ventilator runs, fitted on their first 15 s, judged on
# the rest.
# usage: PNEUDRIVE_DATA=... compare_ventilator.sh OUT [MORE ARGUMENTS OF compare]
set -eu
: "${PNEUDRIVE_DATA:?set PNEUDRIVE_DATA to the folder that holds respiraworks/}"
here=$(cd "$(dirname "$0")" && pwd)
model=${PNEUDRIVE_MODEL:-pneudrive-model}
out=$1
shift
printf '%-18s %8s %10s %10s   %8s %10s %10s\n' 'run' 'linear' 'nonlinear' 'parametric' '1-step' '1-step' '1-step'
for valve in solenoid pinch_valve; do
    for k in 1 2 3 4 5 6 7 8; do
        "$model" compare "$PNEUDRIVE_DATA/respiraworks/$valve/run$k.csv" --rig "$here/ventilator_$valve.toml" \
            --fit-seconds 15 --out "$out/$valve$k" "$@" >"$out.log" 2>&1 || { cat "$out.log"; exit 1; }
        # Rollout RMSE (kPa) and one-step R2 of the three models, from the table of the channel.
        awk -v run="$valve/run$k" '
            $1 ~ /^(linear|nonlinear|parametric)$/ && NF > 9 { rmse = rmse sprintf(" %10s", $3); step = step sprintf(" %10s", $6) }
            END { printf "%-16s%s %s\n", run, rmse, step }' "$out.log"
    done
done
rm -f "$out.log"
