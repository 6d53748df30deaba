// nerfstudio trains in coordinates of its own, turned upright, centred and scaled to a cube, and exports meshes in them.
// It says which in dataparser_transforms.json (save_dataparser_transform in nerfstudio/data/dataparsers/base_dataparser.py
// of github.com/nerfstudio-project/nerfstudio):
//
//   {"transform": 3 rows of 4 numbers, "scale": number}      x_trained = scale * (transform * (x_original, 1))
//
// The original coordinates are those before a transforms.json's applied_transform, or COLMAP's
// (nerfstudio_dataparser.py, colmap_dataparser.py).
#include "io/scenes/parser_frame.h"

#include <algorithm>
#include <cmath>

#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/scene_files.h"
#include "io/scenes/json_file.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {
namespace {

/// First to `first`, then to `second`.
SceneFrame chained(const SceneFrame& first, const SceneFrame& second) {
  const WorldPoint back = product(transposed(first.rotation), second.origin);
  return {second.name,
          product(second.rotation, first.rotation),
          {first.origin.x + back.x / first.scale, first.origin.y + back.y / first.scale,
           first.origin.z + back.z / first.scale},
          first.scale * second.scale};
}

}  // namespace

SceneFrame parse_parser_frame(const fs::path& file, std::string_view text) {
  const JsonFile json(file, text);
  const Json& root = json.root();
  if (!root.is_object()) json.fail("", "expected an object with 'transform' and 'scale'");
  const double scale = json.number("", root, "scale");
  if (!(scale > 0 && std::isfinite(scale) && std::isfinite(1 / scale)))
    json.fail("", "expected a positive number as 'scale'");
  const bool whole = root.contains("transform") && root["transform"].size() == 4;
  const std::vector<double> m = json.numbers("", root, "transform", 4, whole ? 4 : 3);
  const auto rotation = rotation_near({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
  if (!rotation) json.fail("", "'transform' has no rotation in it");
  const WorldPoint origin = product(transposed(*rotation), WorldPoint{-m[3], -m[7], -m[11]});
  if (!std::isfinite(origin.x + origin.y + origin.z)) json.fail("", "'transform' moves beyond what doubles can hold");
  return {"the coordinates that " + file.string() + " states", *rotation, origin, scale};
}

std::vector<SceneFrame> read_parser_frames(const Scene& scene, const fs::path& mesh) {
  const auto folder = [](const fs::path& path) { return is_folder(path) ? path : folder_of(path); };
  std::vector<SceneFrame> frames;
  std::vector<fs::path> seen;
  for (const fs::path& place : {folder(mesh), folder(scene.source), folder(scene.read_from)}) {
    const fs::path file = place / "dataparser_transforms.json";
    if (!is_file(file) || std::ranges::find(seen, file) != seen.end()) continue;
    seen.push_back(file);
    const SceneFrame trained = parse_parser_frame(file, FileBytes(file).view());
    frames.push_back(chained(SceneFrame{}, trained));
    for (const SceneFrame& other : scene.other_frames) frames.push_back(chained(other, trained));
  }
  return frames;
}

}  // namespace gpvc::io
