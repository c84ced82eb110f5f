#!/bin/sh
# The tables of docs/diagnosis-trust.md, "Two machines, eight loads each": the eight runs of each
# ventilator together, and every run alone with the valves of the other seven. Ten minutes on two
# cores.
# usage: PNEUDRIVE_DATA=... diagnose_ventilator_machine.sh OUT
set -eu
: "${PNEUDRIVE_DATA:?set PNEUDRIVE_DATA to the folder that holds respiraworks/}"
here=$(cd "$(dirname "$0")" && pwd)
model=${PNEUDRIVE_MODEL:-pneudrive-model}
out=$1
mkdir -p "$out"
together() {
    folder=$1
    shift
    "$model" diagnose "$@" --rig "$rig" --loads differ --out "$out/$folder" >"$out/log" 2>&1 || { cat "$out/log"; exit 1; }
}
names='[.causes[] | ([.effect] + .equivalent | map("`" + . + "`") | join(" or "))] | join("; ")'
number='def n: . * 1000 | round / 1000 | tostring;'
for valve in solenoid pinch_valve; do
    rig=$here/ventilator_$valve.toml
    data=$PNEUDRIVE_DATA/respiraworks/$valve
    together "$valve-all" "$data"/run?.csv
    jq -r --arg valve "$valve" "$number"' "\($valve): named \('"$names"'); all fitted together \(.machine.joint_rmse_before_kpa | n) to \(.machine.joint_rmse_after_kpa | n) kPa, with the valves of the others \(.baseline.test_rmse_kpa | n) to \(.unexplained.test_rmse_kpa | n) kPa"' "$out/$valve-all/report.json"
    jq -r "$number"' def size: if . == null then "" elif .ci95 == null then (.value | n) + " (not determined)" else "\(.value | n) [\(.ci95[0] | n), \(.ci95[1] | n)]" end;
        .machine.recordings[] | "| \(.file | split("/") | last) | \(.test_rmse_before_kpa | n) to \(.test_rmse_after_kpa | n) | \(.load.b0c0["line_restriction.resistance"] | size) | \(.load.b0c0["chamber_volume.ratio"] | size) |"' "$out/$valve-all/report.json"
    for k in 1 2 3 4 5 6 7 8; do
        together "$valve-but$k" "$data"/run[!$k].csv
        if [ $k -eq 1 ]; then machine=$valve-but1/extended-run2.toml; else machine=$valve-but$k/extended-run1.toml; fi
        "$model" diagnose "$data/run$k.csv" --rig "$rig" --machine "$out/$machine" --out "$out/$valve$k" >"$out/log" 2>&1 || { cat "$out/log"; exit 1; }
        jq -r --arg run "$valve $k, valves known" "$number"' "| \($run) | \(.verdict | gsub("_"; " ")) | \('"$names"') | \(.baseline.test_rmse_kpa | n) to \(.unexplained.test_rmse_kpa | n) |"' "$out/$valve$k/report.json"
    done
done
rm -f "$out/log"
