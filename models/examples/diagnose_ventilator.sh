#!/bin/sh
# The table of docs/diagnosis-trust.md: all sixteen ventilator runs diagnosed.
# usage: PNEUDRIVE_DATA=... diagnose_ventilator.sh OUT [MORE ARGUMENTS OF diagnose]
set -eu
: "${PNEUDRIVE_DATA:?set PNEUDRIVE_DATA to the folder that holds respiraworks/}"
here=$(cd "$(dirname "$0")" && pwd)
model=${PNEUDRIVE_MODEL:-pneudrive-model}
out=$1
shift
mkdir -p "$out"
echo '| run | solenoid | error before and after, kPa | pinch valve | error before and after, kPa |'
echo '|--:|---|--:|---|--:|'
for k in 1 2 3 4 5 6 7 8; do
    row="| $k |"
    for valve in solenoid pinch_valve; do
        "$model" diagnose "$PNEUDRIVE_DATA/respiraworks/$valve/run$k.csv" --rig "$here/ventilator_$valve.toml" \
            --out "$out/$valve$k" "$@" >"$out/log" 2>&1 || { cat "$out/log"; exit 1; }
        row="$row $(jq -r '
            def names: .effect as $e | [$e] + .equivalent | map("`" + . + "`") | join(" or ");
            def kpa: . * 1000 | round / 1000 | tostring;
            "\(.verdict | gsub("_"; " "))\([.causes[] | ": " + names] | join("; ")) | \(.baseline.test_rmse_kpa | kpa) to \(.unexplained.test_rmse_kpa | kpa)\(.unexplained.correction | if . then ", corrected \(.test_rmse_after_kpa | kpa)" else "" end) |"
        ' "$out/$valve$k/report.json")"
    done
    echo "$row"
done
rm -f "$out/log"
