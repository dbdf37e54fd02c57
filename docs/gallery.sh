#!/usr/bin/env bash
# Makes the pictures of README.md, docs/perceive.md and docs/gallery.md from scenarios/straight.toml and others beside it: each effect off and on.
#
#   docs/gallery.sh [FOLDER]      (docs; they go to FOLDER/images and FOLDER/gallery)
#
# A few seconds after the program is built. The CPU renderer makes them, so they are the same to the bit on every x86-64 machine.
set -euo pipefail
cd "$(dirname "$0")/.."
docs=${1:-docs}
out=$docs/gallery
mkdir -p "$out" "$docs/images"
cargo build --release --locked --quiet --bin ductloop --example enlarge
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# README's, by the command that stands there.
target/release/ductloop render scenarios/straight-offset.toml --at-s 0.6 --lines --renderer cpu --quiet --out "$docs/images/straight-offset.png"
rm "$docs/images/straight-offset.json"

# That of docs/perceive.md.
target/release/ductloop render scenarios/straight-offset.toml --at-s 0.6 --renderer cpu --quiet --out "$work/frame.png"
target/release/ductloop perceive "$work/frame.png" --quiet --out "$work/perceived"
mv "$work/perceived/frame.overlay.png" "$docs/images/perceived.png"

# raw NAME SCENARIO [option…]: one frame into the working folder.
raw() {
    local name=$1 scenario=$2
    shift 2
    target/release/ductloop render "scenarios/$scenario.toml" --renderer cpu --quiet --out "$work/$name.png" "$@"
}

# shot NAME SCENARIO [option…]: one frame, in a duct with an elbow ahead. It is bright, so that what is faint is seen on a page.
bright=(--set sensor.exposure=12 --set sensor.light.at_exposure_ms=1.2 --set sensor.light.headlamp_peak_dn=30)
shot() {
    local name=$1 scenario=$2
    shift 2
    raw "$name" "$scenario" "${bright[@]}" --set 'duct.run=[{straight_m=2.2},{elbow_deg=90},{straight_m=2.0}]' "$@"
    mv "$work/$name.png" "$out/$name.png"
}

# cut NAME WINDOW TIMES [BLACK,WHITE]: a window of a picture that was made, enlarged, its grey values stretched.
cut() {
    mv "$out/$1.png" "$work/$1.whole.png"
    target/release/examples/enlarge "$work/$1.whole.png" "$out/$1.png" "${@:2}"
}

here=(--pose 1.2,0.03,0.10,4,0,0)
still=(--no-noise "${here[@]}")
cross=60,190,160,120
lamp=(--set sensor.light.headlamp_peak_dn=60)
end=(--set 'duct.run=[{straight_m=2.2}]')
joints=(--set 'duct.run=[{straight_m=1.6},{straight_m=0.3},{straight_m=0.4},{straight_m=2.0}]')

shot plain straight "${still[@]}"
shot incra1 straight-incra1 --at-s 0 --no-noise
shot noise straight "${here[@]}"

# Lens, exposure.
shot psf-off straight "${still[@]}" --set sensor.lens.psf_sigma_px=0
shot psf-on straight "${still[@]}" --set sensor.lens.psf_sigma_px=1.2
for name in psf-off psf-on; do cut "$name" "$cross" 4; done
# As much light in each, and so little that no pixel is full.
for width in 0.1:600 0.5:120 2.0:30; do
    shot "thin-${width%:*}" straight "${still[@]}" --set "sensor.line.width_mm=${width%:*}" --set sensor.line.growth_mrad=0 \
        --set "sensor.light.stripe_peak_dn=${width#*:}" --set sensor.lens.psf_sigma_px=0.3
    cut "thin-${width%:*}" "$cross" 4
done
shot vignetting-off straight "${still[@]}" --set sensor.lens.vignetting=false
shot distortion-on straight "${still[@]}" --set 'sensor.camera.distortion=[-0.25,0.05,0,0,0]'
shot defocus-on straight "${still[@]}" --set sensor.lens.aperture_mm=8 --set sensor.lens.focus_m=0.3
shot exposure-short straight "${still[@]}" --set sensor.exposure=4
turning=(--at-s 1 --no-noise "${lamp[@]}" --set start.heading_deg=20 --set sensor.exposure=30 --set sensor.light.at_exposure_ms=3)
turning+=(--set duct.surface=galvanised-spangled)
shot motion-off straight "${turning[@]}" --set sensor.lens.motion_blur=false
shot motion-on straight "${turning[@]}"
for name in motion-off motion-on; do cut "$name" 320,0,320,240 2; done

# Automatic exposure: in a duct of steel and in one of black rubber, all four stretched alike.
for surface in galvanised rubber; do
    raw "fixed-$surface" straight --at-s 2 --set "duct.surface=$surface"
    raw "auto-$surface" straight --at-s 2 --set "duct.surface=$surface" --set sensor.exposure=auto
    mv "$work/fixed-$surface.png" "$work/auto-$surface.png" "$out/"
    for way in fixed auto; do cut "$way-$surface" 0,0,640,480 1 0,120; done
done
raw auto-sheet straight --at-s 0,0.0667,0.1333,0.2,0.3,0.5 --set sensor.exposure=auto --set sensor.light.stripe_peak_dn=5000 \
    --set sensor.light.headlamp_peak_dn=500
mv "$work/auto-sheet.png" "$out/"

# Lasers.
shot cylinder straight "${still[@]}" --set sensor.light.fan_profile=cylinder
shot laser-off straight "${still[@]}" --set sensor.laser.high.power=0
shot growth-off straight "${still[@]}" --set sensor.line.growth_mrad=0
shot growth-on straight "${still[@]}" --set sensor.line.growth_mrad=12
for name in growth-off growth-on; do cut "$name" 0,130,320,240 2; done
shot speckle-off straight "${here[@]}" --set sensor.light.speckle_contrast=0
shot speckle-on straight "${here[@]}" --set sensor.light.speckle_contrast=0.5
shot speckle-coarse straight "${here[@]}" --set sensor.light.speckle_contrast=0.5 --set sensor.light.speckle_grain_px=4
for name in speckle-off speckle-on speckle-coarse; do cut "$name" "$cross" 4; done
object=(--set 'duct.object=[{name="brick",at_m=1.7,left_m=0.09,size_m=[0.06,0.12,0.105],turned_deg=20}]')
shot object-unshaded straight "${still[@]}" "${object[@]}" --set sensor.light.shadows=false
shot object straight "${still[@]}" "${object[@]}"

# Surfaces.
for surface in galvanised-dusty galvanised-spangled painted greasy; do
    shot "$surface" straight "${still[@]}" --set "duct.surface=$surface"
done
shot rubber straight "${still[@]}" --set duct.surface=rubber --set sensor.light.at_exposure_ms=0.1
spangled=("${lamp[@]}" --set duct.surface=galvanised-spangled)
shot spangle-off straight "${still[@]}" "${spangled[@]}" --set surface.galvanised-spangled.spangle=0
shot spangle-on straight "${still[@]}" "${spangled[@]}" --set surface.galvanised-spangled.spangle=0.3 \
    --set surface.galvanised-spangled.spangle_mm=20
shot seams-off straight "${still[@]}" "${lamp[@]}" "${joints[@]}"
shot seams-on straight "${still[@]}" "${lamp[@]}" "${joints[@]}" --set surface.galvanised.seam_mm=6
shot beads-on straight "${still[@]}" "${lamp[@]}" "${joints[@]}" --set duct.bead_mm=8
mirror=(--set duct.surface=mirror --set sensor.light.at_exposure_ms=0.05)
shot ghosts-off straight "${still[@]}" "${end[@]}" "${mirror[@]}"
shot ghosts-on straight "${still[@]}" "${end[@]}" "${mirror[@]}" --set sensor.light.ghosts=true
painted=(--set duct.surface=painted --set sensor.light.at_exposure_ms=0.1 --set sensor.light.headlamp_peak_dn=0)
shot bounce-off straight "${still[@]}" "${painted[@]}"
shot bounce-on straight "${still[@]}" "${painted[@]}" --set sensor.light.bounce=true

# Other light.
shot headlamp-off straight "${still[@]}" --set sensor.light.headlamp_peak_dn=0
shot daylight straight "${still[@]}" "${end[@]}" --set sensor.light.ambient_dn=60

# CCD: each kind of noise alone, in a window of the same size, enlarged.
alone=(--set sensor.light.speckle_contrast=0 --set sensor.ccd.prnu=0 --set sensor.ccd.read_noise_e=0)
quiet=("${alone[@]}" --set sensor.ccd.full_well_e=1000000)
floor=240,330,160,120
shot ccd-ideal straight "${here[@]}" "${quiet[@]}"
shot ccd-shot straight "${here[@]}" "${alone[@]}" --set sensor.ccd.full_well_e=1000
shot ccd-prnu straight "${here[@]}" "${quiet[@]}" --set sensor.ccd.prnu=0.1
for name in ccd-ideal ccd-shot ccd-prnu; do cut "$name" "$floor" 4; done
dark=(--set sensor.exposure=30 --set sensor.light.stripe_peak_dn=0 --set sensor.light.headlamp_peak_dn=0)
shot ccd-dark straight "${here[@]}" "${alone[@]}" "${dark[@]}"
shot ccd-read straight "${here[@]}" "${alone[@]}" "${dark[@]}" --set sensor.ccd.read_noise_e=300
shot ccd-dsnu straight "${here[@]}" "${alone[@]}" "${dark[@]}" --set sensor.ccd.dsnu_e=300
shot ccd-current straight "${here[@]}" "${alone[@]}" "${dark[@]}" --set sensor.ccd.dark_current_e_s=30000
shot ccd-hot straight "${here[@]}" "${alone[@]}" "${dark[@]}" --set sensor.ccd.hot_pixels=0.005 --set sensor.ccd.hot_pixel_e_s=50000
shot ccd-offset straight "${here[@]}" "${alone[@]}" "${dark[@]}" --set sensor.ccd.black_level_dn=20
for name in ccd-dark ccd-read ccd-dsnu ccd-current ccd-hot ccd-offset; do cut "$name" "$floor" 4 0,32; done
# The headlamp's faint light on the wall, 12 grey values of 8 bits from black to white.
faint=(--set sensor.light.stripe_peak_dn=0 --set sensor.light.headlamp_peak_dn=4)
for bits in 8:8,20 10:32,80 12:128,321; do
    shot "bits-${bits%:*}" straight "${still[@]}" "${faint[@]}" --bits "${bits%:*}"
    cut "bits-${bits%:*}" 0,120,320,240 2 "${bits#*:}"
done
full=(--set sensor.light.at_exposure_ms=0.15 --set sensor.light.headlamp_peak_dn=0)
shot blooming-off straight "${still[@]}" "${full[@]}"
shot blooming-on straight "${still[@]}" "${full[@]}" --set sensor.ccd.blooming=0.5

raw truth straight --truth "${bright[@]}" --set 'duct.run=[{straight_m=2.2},{elbow_deg=90},{straight_m=2.0}]' "${still[@]}" "${object[@]}" \
    --set "duct.object[0].surface=painted"
mv "$work/truth.truth.png" "$out/truth.png"
