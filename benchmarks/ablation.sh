#!/usr/bin/env bash
# ablation.sh [OPTION]... SCENE MESH IMAGES [SCENE MESH IMAGES]... -o DIR
#                          what each part of gpvc texture is worth: all parts, then each one off by itself, then all of them
#
# Arguments, scores and files in DIR are those of cross_validation.sh (--folds, --downscale, --gpvc); a --set NAME="OPTIONS"
# adds a row. A row with better scores than all_parts says that its part does harm on these scenes.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
case ${1-} in
  -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
esac

# Without the angle, a view's quality is its area in pixels; without smoothness, each face takes its cheapest view.
no_angle="--data-term area"
no_outliers="--outliers none"
no_background="--background none"
no_margin="--margin 0"
no_smoothness="--smoothness 0"
no_alignment="--align none"
no_blending="--blend none"
no_leveling="--seams none"

# Levelling and blending both make photos agree along seams, so that the one hides much of what the other is worth: they
# are also left out together.
exec "$here/cross_validation.sh" \
  --set all_parts="" \
  --set no_angle="$no_angle" \
  --set no_outliers="$no_outliers" \
  --set no_background="$no_background" \
  --set no_margin="$no_margin" \
  --set no_smoothness="$no_smoothness" \
  --set no_alignment="$no_alignment" \
  --set no_blending="$no_blending" \
  --set no_strips="--seams global" \
  --set no_leveling="$no_leveling" \
  --set one_photo_as_taken="$no_blending $no_leveling" \
  --set no_part="$no_angle $no_outliers $no_background $no_margin $no_smoothness $no_alignment $no_blending $no_leveling" \
  "$@"
