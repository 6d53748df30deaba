#include "app/view/tileset_files.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "app/evaluate/json.h"
#include "app/results/output_folder.h"
#include "io/error.h"
#include "io/file_bytes.h"
#include "io/paths.h"

namespace gpvc::view {
namespace {

namespace fs = std::filesystem;
using evaluate::Json;

constexpr const char* kTileset = "tileset.json";

}  // namespace

bool is_tileset(const fs::path& folder) { return io::is_file(folder / kTileset); }

std::set<std::string> tileset_files(const fs::path& folder) {
  const fs::path file = folder / kTileset;
  const Json json = Json::parse(io::FileBytes(file).view(), nullptr, false);
  if (!json.is_object() || !json.contains("root") || !json["root"].is_object())
    throw InputError(file, "", "is no tileset: expected a JSON object with a root");
  std::set<std::string> files{kTileset};
  std::vector<const Json*> tiles{&json["root"]};
  while (!tiles.empty()) {
    const Json& tile = *tiles.back();
    tiles.pop_back();
    if (!tile.is_object()) throw InputError(file, "", "has a tile that is no JSON object");
    if (const auto content = tile.find("content"); content != tile.end() && content->is_object()) {
      const std::string uri = content->value("uri", "");
      const fs::path path(uri);
      if (path.extension() != ".glb") throw InputError(file, uri, "is no .glb, which alone is shown here");
      try {
        if (io::is_file(folder / results::contained_path(uri))) files.insert(uri);
      } catch (const OutputError&) {  // leaves the folder
      }
    }
    if (const auto children = tile.find("children"); children != tile.end() && children->is_array())
      for (const Json& child : *children) tiles.push_back(&child);
  }
  return files;
}

}  // namespace gpvc::view
