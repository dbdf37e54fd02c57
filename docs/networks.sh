#!/bin/sh
# Draws the plans of docs/networks.md into docs/images: each fitting between two straights, and a network of all of them.
set -eu
cd "$(dirname "$0")/.."
ductloop=${DUCTLOOP:-target/release/ductloop}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# name, the fitting, straight behind it or not, ports with branches, turn
fitting() {
    {
        printf 'format = 1\nkind = "scenario"\nname = "%s"\n[robot]\npreset = "incra1"\n[sensor]\npreset = "wide"\n' "$1"
        printf '[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 0.9 }, %s%s]\n' "$2" "$3"
        for port in $4; do
            printf '[[duct.branch]]\nfrom = "%s-1.%s"\nrun = [{ straight_m = 0.5 }]\n' "$1" "$port"
        done
        if [ -n "$5" ]; then printf '[route]\nturns = ["%s"]\n' "$5"; fi
        printf '[finish]\nbefore_end_m = 0.25\n'
    } > "$work/$1.toml"
    "$ductloop" check "$work/$1.toml" --plan "docs/images/fitting-$1.svg" --quiet
}
on=', { straight_m = 0.5 }'
fitting elbow '{ elbow_deg = 90 }' "$on" '' ''
fitting mitre '{ mitre_deg = -60 }' "$on" '' ''
fitting vaned '{ vaned_deg = 90 }' "$on" '' ''
fitting transition '{ transition_m = 0.6, to_width_m = 0.3, align = "left" }' "$on" '' ''
fitting offset '{ offset_m = 0.4 }' "$on" '' ''
fitting slope '{ slope_deg = 8, length_m = 1.2 }' "$on" '' ''
fitting tee '{ tee = "left" }' "$on" left left
fitting bullhead '{ bullhead_m = 0.5 }' '' 'left right' left
fitting side-branch '{ side_branch = "right", branch_width_m = 0.4 }' "$on" right right
fitting wye '{ wye_deg = 45 }' '' 'left right' left
fitting cross '{ cross_m = 0.5 }' "$on" 'left right' right
fitting damper '{ damper = "open" }' "$on" '' ''
fitting grille '{ grille = "left" }' "$on" '' ''
fitting drop '{ drop_m = 0.4, hole_width_m = 0.35 }' "$on" '' ''
"$ductloop" check docs/network.toml --plan docs/images/network.svg --quiet
