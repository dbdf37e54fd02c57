#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md from scenarios/straight.toml and straight-incra1.toml: each effect off and on.
#
#   docs/gallery.sh [FOLDER]      (docs/gallery)
#
# A minute after the program is built. The CPU renderer makes them, so they are the same to the bit everywhere.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-docs/gallery}
mkdir -p "$out"
cargo build --release --locked --quiet
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shot NAME SCENARIO [option…]: one frame, in a duct with an elbow ahead. It is bright, so that what is faint is seen on a page.
shot() {
    local name=$1 scenario=$2
    shift 2
    target/release/ductloop render "scenarios/$scenario.toml" --renderer cpu --quiet --out "$work/$name.png" \
        --set sensor.exposure=12 --set sensor.light.at_exposure_ms=1.2 --set 'duct.run=[{straight_m=2.2},{elbow_deg=90},{straight_m=2.0}]' "$@"
    mv "$work/$name.png" "$out/$name.png"
}
here=(--pose 1.2,0.03,0.10,4,0,0)
still=(--no-noise "${here[@]}")
end=(--set 'duct.run=[{straight_m=2.2}]')

shot plain straight "${still[@]}"
shot incra1 straight-incra1 --at-s 0 --no-noise
shot noise straight "${here[@]}"
shot speckle-off straight "${here[@]}" --set sensor.light.speckle_contrast=0
shot speckle-on straight "${here[@]}" --set sensor.light.speckle_contrast=0.5
shot speckle-coarse straight "${here[@]}" --set sensor.light.speckle_contrast=0.5 --set sensor.light.speckle_grain_px=4
shot psf-off straight "${still[@]}" --set sensor.lens.psf_sigma_px=0
shot psf-on straight "${still[@]}" --set sensor.lens.psf_sigma_px=1.2
shot vignetting-off straight "${still[@]}" --set sensor.lens.vignetting=false
shot distortion-on straight "${still[@]}" --set 'sensor.camera.distortion=[-0.25,0.05,0,0,0]'
shot defocus-on straight "${still[@]}" --set sensor.lens.aperture_mm=8 --set sensor.lens.focus_m=0.3
shot motion-off straight --at-s 1 --no-noise --set start.heading_deg=20 --set sensor.exposure=30 --set sensor.light.at_exposure_ms=10 --set sensor.lens.motion_blur=false
shot motion-on straight --at-s 1 --no-noise --set start.heading_deg=20 --set sensor.exposure=30 --set sensor.light.at_exposure_ms=10
shot cylinder straight "${still[@]}" --set sensor.light.fan_profile=cylinder
for surface in galvanised-dusty galvanised-spangled painted greasy rubber; do
    shot "$surface" straight "${still[@]}" --set "duct.surface=$surface"
done
shot ghosts-off straight "${still[@]}" "${end[@]}" --set duct.surface=mirror --set sensor.light.at_exposure_ms=0.4
shot ghosts-on straight "${still[@]}" "${end[@]}" --set duct.surface=mirror --set sensor.light.at_exposure_ms=0.4 --set sensor.light.ghosts=true
shot bounce-off straight "${still[@]}" --set duct.surface=painted --set sensor.light.at_exposure_ms=0.8 --set sensor.light.headlamp_peak_dn=0
shot bounce-on straight "${still[@]}" --set duct.surface=painted --set sensor.light.at_exposure_ms=0.8 --set sensor.light.headlamp_peak_dn=0 --set sensor.light.bounce=true
shot headlamp-off straight "${still[@]}" --set sensor.light.headlamp_peak_dn=0
shot daylight straight "${still[@]}" "${end[@]}" --set sensor.light.ambient_dn=60
shot dark-off straight "${here[@]}" --set sensor.exposure=30 --set sensor.light.stripe_peak_dn=0 --set sensor.light.headlamp_peak_dn=0
shot dark-on straight "${here[@]}" --set sensor.exposure=30 --set sensor.light.stripe_peak_dn=0 --set sensor.light.headlamp_peak_dn=0 \
    --set sensor.ccd.dark_current_e_s=130000 --set sensor.ccd.dsnu_e=300 --set sensor.ccd.hot_pixels=0.002 --set sensor.ccd.hot_pixel_e_s=400000
shot blooming-off straight "${still[@]}" --set sensor.light.at_exposure_ms=0.15 --set sensor.light.headlamp_peak_dn=0
shot blooming-on straight "${still[@]}" --set sensor.light.at_exposure_ms=0.15 --set sensor.light.headlamp_peak_dn=0 --set sensor.ccd.blooming=0.5
target/release/ductloop render scenarios/straight.toml --renderer cpu --quiet --out "$work/truth.png" --truth "${still[@]}"
mv "$work/truth.truth.png" "$out/truth.png"
