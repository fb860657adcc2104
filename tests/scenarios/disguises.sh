#!/bin/bash
# One recording is written in the forms in which different people's programs would write it; the verdict and its values stay the same. Files
# that cannot be read are refused, and the message states the remedy.
. tests/scenarios/lib

disguises() { "$python" tests/scenarios/disguises.py "$@"; }
cat >"$work/axis.yaml" <<E
mechanism: axis
axis: {mass_kg: 200, gravity_mps2: 0, middle_m: 0}
actuator: {stroke_m: 0.4}
hydraulics: {viscous_n_s_per_m: 0}
tests: {order: [x], frequency_hz: 2, amplitude_m: 0.02, settle_s: 2, ramp_s: 2.5, duration_s: 11, ramp_out_s: 2}
loop: {period_s: 0.002}
E

map_of() { cat "$work/$1.map"; }
# imported NAME LOG: imports the disguise with the map that belongs to it.
imported() {
    local map
    map=$(map_of "$1")
    "$hexid" import "$work/$1" -c "$work/axis.yaml" -o "$2" ${map:+--map "$map"}
}
read_in() {
    mkdir "$work/$1" && disguises write "$1" "$work/$1" >"$work/$1.map" || return 1
    imported "$1" "$work/$1.lcm" >"$work/$1.said" 2>&1 || { cat "$work/$1.said"; return 1; }
}
same_verdict() {
    read_in "$1" || return 1
    "$hexid" gap --measured "$work/$1.lcm" -c "$work/axis.yaml" -o "$work/$1.gap" --json "$work/$1.json" >"$work/$1.out" 2>&1
    disguises right "$work/$1.json" >"$work/$1.found" || { cat "$work/$1.said" "$work/$1.out"; return 1; }
    echo "# $1: $(cat "$work/$1.found")" >>"$work/figures"
}
for name in $(disguises list); do
    if built_with 'asan|tsan' && [ "$name" != plain ]; then # the search is the same for all, and only the import differs
        claim "$name: read" read_in "$name"
    else
        claim "$name: 80 N of dry friction, within 5 %" same_verdict "$name"
    fi
done
cat "$work/figures"

says() { grep -q -- "$1" "$work/$2.said" || { cat "$work/$2.said"; return 1; }; }
claim "head lines and the line of units are said" says "3 lines of text before the names left out; a.csv: line 6 has the units" instrument
claim "a repeated channel is said, with its rate and delay" says "force_n is repeated 5 times, at 100 Hz in rows of 500 Hz: .*mean delay of 4 ms" repeated
claim "so is the clock that made the rows" says "rows are those of force_n, 200 Hz" clocks
claim "and the zero of a speed, with what it would have made of the position" says "less 1.5 mm/s (its mean at rest), 30 mm over the record" speed
claim "and that an axis turns" says "at a lever of 1 m" turning

there_and_back() {
    rm -rf "$work/whole" "$work/once" "$work/back" && mkdir "$work/whole"
    "$hexid" export "$work/plain.lcm" -o "$work/once" >/dev/null && "$hexid" export "$work/plain.lcm" --format "$1" -o "$work/whole/a.$1" &&
        "$hexid" import "$work/whole/a.$1" -c "$work/once/config.yaml" -o "$work/whole/a.lcm" &&
        "$hexid" export "$work/whole/a.lcm" -o "$work/back" && diff -r "$work/once" "$work/back"
}
for format in mat mcap; do claim "a whole export to $format comes back to the same CSV, byte for byte" there_and_back $format; done
platform() {
    quick --tests x,z --log "$work/run.lcm" >/dev/null 2>&1
    rm -rf "$work/once" "$work/back"
    "$hexid" export "$work/run.lcm" -o "$work/once" && "$hexid" export "$work/run.lcm" --format "$1" -o "$work/run.$1" &&
        "$hexid" import "$work/run.$1" -c "$work/once/config.yaml" -o "$work/run.$1.lcm" && "$hexid" export "$work/run.$1.lcm" -o "$work/back" &&
        diff -r "$work/once" "$work/back" && rm "$work/run.lcm"
}
for format in mat mcap; do claim "so do the tests of a platform, from $format" platform $format; done
missing_length() {
    local file
    rm -rf "$work/hole" "$work/back" && cp -r "$work/once" "$work/hole"
    for file in "$work"/hole/*.csv; do
        awk -F, -v OFS=, '/^#/ || past { print; next } !l2 { for (i = 1; i <= NF; i++) if ($i == "l2_m") l2 = i; print; next } { $l2 = ""; past = 1; print }' \
            "$file" >"$work/row" && mv "$work/row" "$file"
    done
    "$hexid" import "$work/hole" -o "$work/hole.lcm" && "$hexid" export "$work/hole.lcm" --format "$1" -o "$work/hole.$1" &&
        "$hexid" import "$work/hole.$1" -c "$work/once/config.yaml" -o "$work/hole.$1.lcm" && "$hexid" export "$work/hole.$1.lcm" -o "$work/back" &&
        grep -q l6_m "$work"/back/1_*.csv && ! grep 'mechanism: axis' "$work"/back/*.csv
    local status=$?
    rm -f "$work"/hole*.lcm "$work/hole.$1"
    return $status
}
for format in mat mcap; do claim "a platform whose first row lacks a length stays one, from $format" missing_length $format; done

disguises foreign "$work"
claim "MAT 7.3 is refused, with MATLAB's way out" refuses 2 "hdf.mat 7.3 -v7" "$hexid" import "$work/hdf.mat" -o "$work/none.lcm"
claim "a MAT file without vectors is refused" refuses 2 "texts.mat no vector timeseries" "$hexid" import "$work/texts.mat" -o "$work/none.lcm"
claim "a MAT file's names get a proposal" refuses 2 "try t=Time:?,position=Stroke:?,force=Load:?" "$hexid" import "$work/flat.mat" -o "$work/none.lcm"
claim "check takes a MAT file, too" eval '"$hexid" check "$work/flat.mat" -c "$work/axis.yaml" --map "t=Time:s,position=Stroke:cm,force=Load:kN" | grep -q "^  flat.mat  *2000"'
claim "an MCAP file of another encoding is refused, with what it has" refuses 2 "cdr.mcap JSON cdr CSV" "$hexid" import "$work/cdr.mcap" -o "$work/none.lcm"
claim "chunks of lz4 are refused, with the remedy" refuses 2 "lz4.mcap lz4 --compression zstd" "$hexid" import "$work/lz4.mcap" -o "$work/none.lcm"
axis_map=t=clock:s,position=x:m,force=f:N topic_map=t=log_time_s,position=/t300.x:m,force=/t300.f:N
takes() {
    "$hexid" check "$work/$1" -c "$work/axis.yaml" --map "$2" >"$work/said" 2>&1
    grep -q "^  $1  *4000" "$work/said" && grep -q "${3-}" "$work/said" || { cat "$work/said"; return 1; }
}
claim "a wide MAT file has the columns that the map names" takes wide.mat $axis_map
claim "without a map it is refused, with the remedy" refuses 2 "wide.mat at least 512 columns --map" "$hexid" import "$work/wide.mat" -o "$work/none.lcm"
claim "so has one that is too large" takes long.mat $axis_map
claim "a clock is a name with the word time in it that rises" takes timeout.mat position=x:m,force=f:N
claim "more tests than are read are refused as that" refuses 2 "tests.mat more than 100 tests" "$hexid" import "$work/tests.mat" -o "$work/none.lcm"
claim "a wide MCAP file has the columns that the map names, of channel 300 too" takes wide.mcap $topic_map
claim "without a map it is refused, too" refuses 2 "wide.mcap at least 513 columns --map" "$hexid" import "$work/wide.mcap" -o "$work/none.lcm"
claim "an MCAP file without an end is read, and that is said" takes cut.mcap $topic_map "cut.mcap: cut off: read up to there"
claim "a record that is too large is refused" refuses 2 "large.mcap 1099511627776 mcap recover" "$hexid" import "$work/large.mcap" -o "$work/none.lcm"
# Damaged files are read up to the damage or are refused; hexid does not crash.
survives() {
    local file map status
    map=$(map_of "$1")
    mkdir "$work/spoilt.$1"
    disguises spoil "$2" "$work/spoilt.$1" >"$work/spoilt" || return 1
    while read -r file; do
        "$hexid" import "$file" -c "$work/axis.yaml" -o "$work/spoilt.$1/a.lcm" --map "$map" >"$work/said" 2>&1
        status=$?
        [ $status -le 3 ] || { echo "$file: $status"; cat "$work/said"; return 1; }
        rm -f "$work/spoilt.$1"/a.lcm*
    done <"$work/spoilt"
}
claim "damaged MAT files are survived" survives matlab "$work/matlab/a.mat"
claim "damaged MCAP files are survived" survives mcap "$work/mcap/a.mcap"
