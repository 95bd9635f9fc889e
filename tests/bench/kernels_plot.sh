#!/bin/sh
# Draws what kernels.c kept with --csv: our speed over Embree's, a bar a ray set, a group a scene. Needs gnuplot.
# usage: kernels_plot.sh CSV PNG
[ $# = 2 ] || { echo 'usage: kernels_plot.sh CSV PNG' >&2; exit 2; }
[ -r "$1" ] || { echo "kernels_plot.sh: cannot read $1" >&2; exit 1; }
grep -q ',embree,' "$1" || { echo "nothing of Embree's in $1: no plot"; exit 0; }
command -v gnuplot > /dev/null || { echo 'gnuplot is not here: no plot'; exit 0; }
awk -F, 'BEGIN { split("primary,diffuse 1,diffuse 2,shadow 0,shadow 1", sets, ",") }
    { speed[$1, $2, $3] = $4; if (!seen[$1]++) scene[++n] = $1 }
    END { for (i = 1; i <= n; i++) {
        printf "%s", scene[i]
        for (k = 1; k <= 5; k++) { e = speed[scene[i], sets[k], "embree"]; printf " %s", e ? speed[scene[i], sets[k], "pt"] / e : "NaN" }
        printf "\n" } }' "$1" > "$2.dat"
gnuplot <<END
set terminal pngcairo size 900,360 font "sans,11"
set output "$2"
set style data histogram
set style histogram clustered gap 1
set style fill solid 0.9 border rgb "white"
set yrange [0:*]
set grid ytics lc rgb "#dddddd"
set border 3
set xtics nomirror; set ytics nomirror
set key outside right top
set ylabel "rays a second, pt.h / Embree 3.13"
set arrow from graph 0, first 1 to graph 1, first 1 nohead lc rgb "black" dt 2
plot for [k=2:6] "$2.dat" using k:xtic(1) title word("primary diffuse-1 diffuse-2 shadow-0 shadow-1", k-1)
END
rm -f "$2.dat"
