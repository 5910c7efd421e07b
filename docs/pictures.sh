#!/bin/sh
# Renders the scenes of scenes/ into docs/pictures/, with the release binary:
#
#     cargo build --release && docs/pictures.sh [NAME…]
#
# CANDELA names another binary. The pictures of `lecture` and `first` are what the README's commands make,
# without a size or an option of their own; the others are
# 480 pixels wide, or 320 where there is so much detail that a larger file would be too large. The charts
# of docs/rgb-or-spectral.md, the contact sheet, the illuminances and the pictures of docs/layers.md and
# docs/shadow-terminator.md are made each time; the latter two need oiiotool, which tests/setup.sh installs.
set -eu
cd "$(dirname "$0")/.."
candela=${CANDELA:-target/release/candela}

work=$(mktemp -d)
# The small copy of a scene stands beside the original, where the paths of its meshes lead on. Its
# name begins with a dot, so that nothing takes it for a scene.
small=scenes/.picture.toml
trap 'rm -rf "$work" "$small"' EXIT
trap 'exit 1' HUP INT TERM

mkdir -p docs/pictures
# One color chart is enough for the gallery.
[ $# -gt 0 ] || set -- $(cd scenes && ls -- *.toml | sed 's/\.toml$//' | grep -v '^colorchecker') colorchecker-f11
chart() { # LAMP TRANSPORT: the color chart under a lamp, its light carried in one way or the other
    # Its patches are even, so that dither would only make the files large.
    "$candela" render "scenes/colorchecker-$1.toml" --transport "$2" -o "$work/chart.exr" --quiet
    "$candela" tonemap "$work/chart.exr" -o "docs/pictures/chart-$1-$2.png" --dither none
}
for lamp in a f11 hp1; do
    chart "$lamp" spectral
    chart "$lamp" rgb
done

oiiotool=target/openimageio/bin/oiiotool
layers=$work/layers.exr
sed 's/^resolution = .*/resolution = [320, 180]/' scenes/lecture.toml > "$small"
"$candela" render "$small" --layers lights,depth,normal --samples 64 -o "$layers" --quiet
"$candela" tonemap "$layers" -o "$work/layer-beauty.png"
for light in key fill front; do
    rgb=R=light_$light.R,G=light_$light.G,B=light_$light.B
    "$oiiotool" "$layers" --ch "$rgb,A" -o "$work/light.exr"
    "$candela" tonemap "$work/light.exr" -o "$work/layer-$light.png"
done
# 4 m are white and 9 m black; N from -1 to 1 is 0 to 1.
"$oiiotool" "$layers" --ch R=Z,G=Z,B=Z --mulc -0.2 --addc 1.8 -d uint8 -o "$work/layer-depth.png"
"$oiiotool" "$layers" --ch R=N.X,G=N.Y,B=N.Z --mulc 0.5 --addc 0.5 -d uint8 -o "$work/layer-normal.png"
"$oiiotool" "$work/layer-beauty.png" "$work/layer-key.png" "$work/layer-fill.png" \
    "$work/layer-front.png" "$work/layer-depth.png" "$work/layer-normal.png" \
    --mosaic:pad=4 3x2 --ch R,G,B -d uint8 -o docs/pictures/layers.png

"$candela" render scenes/lecture.toml --samples 64 -o "$work/lecture.exr" --quiet
"$candela" contact-sheet "$work/lecture.exr" --exposure 1 --width 300 -o docs/pictures/contact-sheet.png

"$candela" render scenes/wall-washer.toml --samples 64 --layers irradiance -o "$work/illuminance.exr" --quiet
"$candela" tonemap "$work/illuminance.exr" --view false-color --unit lx --iso-lines auto --alpha opaque --dither none \
    -o docs/pictures/illuminance.png

# The office from wall to wall: desks have some 500 lx.
"$candela" render scenes/office.toml --set image.resolution=[720,405] --samples 16 --layers irradiance -o "$work/office-illuminance.exr" --quiet
"$candela" tonemap "$work/office-illuminance.exr" --view false-color --unit lx --iso-lines 100,200,300,500,750 \
    --alpha opaque --dither none -o docs/pictures/office-illuminance.png

"$candela" render scenes/moving.toml --set image.resolution=[480,270] --frames 1-24 --samples 64 -o "$work/moving.####.exr" --quiet
"$candela" contact-sheet "$work/moving.####.exr" --width 180 -o docs/pictures/sequence.png

"$candela" render scenes/terms.toml --samples 64 -o "$work/terms.exr" --quiet \
    --layers lights,light-diffuse,light-specular,shadow,diffuse,specular,albedo,irradiance,normal
"$candela" contact-sheet "$work/terms.exr" --layers --width 300 -o docs/pictures/terms-layers.png

# A part of the knot, four times as large, by either rule.
for rule in geometric hanika; do
    sed -e 's/^resolution = .*/resolution = [3840, 2160]/' \
        -e "s/^shadow_terminator = .*/shadow_terminator = \"$rule\"/" scenes/mesh.toml > "$small"
    "$candela" render "$small" --crop 1240,640,1720,1080 --samples 16 -o "$work/terminator.exr" --quiet
    "$candela" tonemap "$work/terminator.exr" -o "$work/terminator.png"
    "$oiiotool" "$work/terminator.png" --cut 480x440+1240+640 --ch R,G,B -d uint8 \
        -o "docs/pictures/terminator-$rule.png"
done

for name; do
    scene=scenes/$name.toml
    frame=1
    case $name in
    lecture | first)
        "$candela" render "$scene" -o "$work/$name.exr" --preview "docs/pictures/$name.png" --quiet
        continue
        ;;
    many-*) width=320 ;;
    room) width=300 ;;
    moving) width=480 frame=18 ;;
    *) width=480 ;;
    esac
    # Each sample of the prism follows many wavelengths.
    samples=64
    [ "$name" = prism ] && samples=16
    # Scenes in the light of real places are exposed as with a camera.
    case $name in
    wall-washer) exposed="--iso 100 --shutter 1/4 --aperture 4 --view aces2" ;;
    yard) exposed="--iso 100 --shutter 1/100 --aperture 16" ;;
    soft-shadow) exposed="--iso 100 --shutter 1/6 --aperture 4 --view aces2" ;;
    neon) exposed="--exposure 0.7 --view aces2" ;;
    mirror-ball) exposed="--exposure 0.6 --view aces2" ;;
    facing-mirrors) exposed="--exposure 2.2 --view aces2" ;;
    hall-of-mirrors) exposed="--exposure 0.5 --view aces2" ;;
    window) exposed="--exposure 1.6 --view aces2" ;;
    metals) exposed="--exposure 0.8 --view aces2" ;;
    prism) exposed="--exposure -2 --view aces2" ;;
    office) exposed="--iso 100 --shutter 1/10 --aperture 4 --view aces2" ;;
    *) exposed= ;;
    esac
    awk -v width="$width" '
        /^resolution = / && match($0, /[0-9]+, [0-9]+/) {
            split(substr($0, RSTART, RLENGTH), size, ", ")
            $0 = "resolution = [" width ", " int(width * size[2] / size[1] + 0.5) "]"
        }
        { print }' "$scene" > "$small"
    "$candela" render "$small" --frame $frame -o "$work/$name.exr" --samples "$samples" --quiet
    # shellcheck disable=SC2086 # The options are words.
    "$candela" tonemap "$work/$name.exr" -o "docs/pictures/$name.png" --alpha opaque $exposed
done
