#include "app/tileset/tileset_json.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/output_file.h"
#include "io/vector.h"

namespace gpvc::tileset {
namespace {

using Json = nlohmann::ordered_json;

// Of an axis-aligned box: its middle and three half edges.
Json volume(const TileBox& box) {
  Json numbers = Json::array();
  for (std::size_t i = 0; i < 3; ++i) numbers.push_back((box.low.at[i] + box.high.at[i]) / 2);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < 3; ++i) numbers.push_back(i == axis ? (box.high.at[i] - box.low.at[i]) / 2 : 0.0);
  return {{"box", numbers}};
}

class Writer {
 public:
  explicit Writer(std::span<const std::vector<Tile>> levels) : levels_(levels), boxes_(levels.size()) {
    for (std::size_t k = 0; k < levels.size(); ++k)
      for (std::size_t n = 0; n < levels[k].size(); ++n) {
        TileBox box = levels[k][n].box;
        for (std::size_t child = 4 * n; k > 0 && child < 4 * n + 4; ++child) box.add(boxes_[k - 1][child]);
        boxes_[k].push_back(box);
      }
  }

  const TileBox& box() const { return boxes_.back()[0]; }

  Json tile(std::size_t level, std::size_t number) const {
    const Tile& tile = levels_[level][number];
    Json json{{"boundingVolume", volume(boxes_[level][number])}, {"geometricError", tile.error}, {"refine", "REPLACE"}};
    if (!tile.file.empty()) json["content"] = {{"uri", tile.file}};
    for (std::size_t child = 4 * number; level > 0 && child < 4 * number + 4; ++child)
      if (!boxes_[level - 1][child].is_empty) json["children"].push_back(this->tile(level - 1, child));
    return json;
  }

 private:
  std::span<const std::vector<Tile>> levels_;
  std::vector<std::vector<TileBox>> boxes_;  ///< with those of the children
};

std::string today() { return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr))); }

Json asset_of(const io::ModelOptions& options, const std::optional<Place>& place) {
  const WorldPoint origin = options.offset + options.srs_offset;
  Json extras{{"program", "gpvc " GPVC_VERSION}, {"date", today()}, {"offset", {origin.x, origin.y, origin.z}}};
  if (!options.srs.empty()) extras["srs"] = options.srs;
  if (const std::string remark = remark_on_placing(options, place); !remark.empty()) extras["placing"] = remark;
  Json asset{{"version", "1.1"}, {"generator", "gpvc"}};
  if (!options.copyright.empty()) asset["copyright"] = options.copyright;
  asset["extras"] = std::move(extras);
  return asset;
}

}  // namespace

void TileBox::add(const TilePoint& p) {
  for (std::size_t i = 0; i < 3; ++i) {
    low.at[i] = is_empty ? p.at[i] : std::min(low.at[i], p.at[i]);
    high.at[i] = is_empty ? p.at[i] : std::max(high.at[i], p.at[i]);
  }
  is_empty = false;
}

void TileBox::add(const TileBox& box) {
  if (box.is_empty) return;
  add(box.low);
  add(box.high);
}

double geometric_error(double surface, double texel) {
  // A texel that is drawn larger than a screen's pixel shows that detail is missing. Viewers refine a tile whose error is seen
  // larger than some 16 pixels (the default of CesiumJS): an error of so many texels makes them refine where a texel would be
  // larger than two pixels.
  constexpr double kErrorTexels = 8;
  return std::max(surface, kErrorTexels * texel);
}

std::string tileset_text(std::span<const std::vector<Tile>> levels, const io::ModelOptions& options,
                         const std::optional<Place>& place) {
  constexpr Matrix kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const Writer writer(levels);
  Json root = writer.tile(levels.size() - 1, 0);
  if (const Matrix matrix = root_transform(options, place); matrix != kIdentity) root["transform"] = matrix;
  // How much is missing where nothing is drawn: all of it.
  double diagonal2 = 0;
  for (std::size_t i = 0; i < 3; ++i) diagonal2 += std::pow(writer.box().high.at[i] - writer.box().low.at[i], 2);
  const Json tileset{{"asset", asset_of(options, place)},
                     {"geometricError", std::max(std::sqrt(diagonal2), levels.back()[0].error)},
                     {"root", std::move(root)}};
  // Text of a scene file may not be UTF-8, which JSON must be.
  return tileset.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_tileset(const std::filesystem::path& folder, std::span<const std::vector<Tile>> levels,
                   const io::ModelOptions& options, const std::optional<Place>& place) {
  io::write_file(folder / "index.html", kTilesetPage);
  io::write_file(folder / "tileset.json", tileset_text(levels, options, place));
}

}  // namespace gpvc::tileset
