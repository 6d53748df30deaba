// gpvc tileset, from a scene to files.
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "io/textured_model.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;
using Json = nlohmann::json;

struct FoundTile {
  std::string file;
  int level = 0;  ///< 0: the root
  Json box;
  double error = 0;
};

void collect(const Json& tile, int level, std::vector<FoundTile>& all) {
  all.push_back({tile["content"]["uri"], level, tile["boundingVolume"]["box"], tile["geometricError"]});
  for (const Json& child : tile.value("children", Json::array())) {
    EXPECT_GT(tile["geometricError"], child["geometricError"]) << "viewers refine from coarse to fine";
    collect(child, level + 1, all);
  }
}

class TilesetCommand : public App {
 protected:
  std::vector<std::string> tileset(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = texture(out_, {"--tile-faces", "400"});
    words[0] = "tileset";
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(TilesetCommand, WritesATreeWithLevelsOfDetail) {
  ASSERT_EQ(run(tileset()).exit_code, 0);
  std::vector<FoundTile> tiles;
  collect(Json::parse(read_file(out_ / "tileset.json"))["root"], 0, tiles);
  std::map<int, std::size_t> faces, count;
  for (const FoundTile& tile : tiles) {
    io::LoadedModel loaded = io::read_textured_model(out_ / tile.file);
    loaded.model.mesh = &loaded.mesh;
    faces[tile.level] += loaded.mesh.faces.size();
    ++count[tile.level];
    ASSERT_FALSE(loaded.pages.empty()) << tile.file;
    const Image& page = loaded.pages[0];
    double sum = 0;
    for (const std::uint8_t sample : page.pixels) sum += sample;
    EXPECT_GT(sum / static_cast<double>(page.pixels.size()), 30) << tile.file << " is black";
    // The city's z is up, so the coordinates of the file and of the tile are the same.
    for (const WorldPoint& p : loaded.mesh.positions) {
      const std::array<double, 3> at{p.x, p.y, p.z};
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_LE(std::abs(at[i] - tile.box[i].get<double>()), tile.box[3 + 4 * i].get<double>() + 1e-4) << tile.file;
    }
  }
  const int leaves = count.rbegin()->first;
  EXPECT_EQ(leaves, 2);
  EXPECT_EQ(count[0], 1u);
  EXPECT_EQ(count[2], (faces[2] + 399) / 400) << "tiles have about as many faces as were asked for";
  EXPECT_EQ(faces[2], run_json(out_)["counts"]["levels"][0]["faces"]) << "every face of the mesh is in one leaf";
  EXPECT_LT(faces[1], faces[2] / 2);
  EXPECT_LT(faces[0], faces[1]);
}

// The parts of a GLB.
struct Glb {
  Json json;
  std::string binary;
  explicit Glb(const fs::path& file) {
    const std::string bytes = read_file(file);
    std::uint32_t text = 0;
    std::memcpy(&text, bytes.data() + 12, sizeof text);
    json = Json::parse(bytes.substr(20, text));
    binary = bytes.substr(28 + text);
  }
  /// The values of an accessor as bytes, decoded where they are compressed.
  std::string values(std::size_t accessor) const {
    const Json& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    if (!view.contains("extensions"))
      return binary.substr(view.value("byteOffset", std::size_t{0}), view["byteLength"].get<std::size_t>());
    const Json& packed = view["extensions"]["EXT_meshopt_compression"];
    const auto count = packed["count"].get<std::size_t>(), stride = packed["byteStride"].get<std::size_t>();
    const auto* from =
        reinterpret_cast<const unsigned char*>(binary.data()) + packed.value("byteOffset", std::size_t{0});
    const auto bytes = packed["byteLength"].get<std::size_t>();
    std::string decoded(count * stride, '\0');
    const int failed = packed["mode"] == "TRIANGLES"
                           ? meshopt_decodeIndexBuffer(decoded.data(), count, stride, from, bytes)
                           : meshopt_decodeVertexBuffer(decoded.data(), count, stride, from, bytes);
    EXPECT_EQ(failed, 0);
    return decoded;
  }
};

// Triangles, each beginning with its least corner.
std::vector<Triangle> triangles_of(const std::string& indices) {
  std::vector<Triangle> triangles(indices.size() / sizeof(Triangle));
  std::memcpy(triangles.data(), indices.data(), indices.size());
  for (Triangle& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return triangles;
}

// A photo's name and ground sampling distance by the row of a GLB's table.
std::vector<std::pair<std::string, float>> photos_of(const Glb& glb) {
  const Json& table = glb.json["extensions"]["EXT_structural_metadata"]["propertyTables"][0];
  const auto bytes = [&](const Json& number) {
    const Json& view = glb.json["bufferViews"][number.get<std::size_t>()];
    return glb.binary.substr(view["byteOffset"], view["byteLength"]);
  };
  const Json &names = table["properties"]["photo"], &gsd = table["properties"]["gsd"];
  const std::string text = bytes(names["values"]), ends = bytes(names["stringOffsets"]), sizes = bytes(gsd["values"]);
  std::vector<std::pair<std::string, float>> photos(table["count"].get<std::size_t>());
  for (std::size_t row = 0; row < photos.size(); ++row) {
    std::uint32_t begin = 0, end = 0;
    std::memcpy(&begin, ends.data() + 4 * row, 4);
    std::memcpy(&end, ends.data() + 4 * row + 4, 4);
    std::memcpy(&photos[row].second, sizes.data() + 4 * row, 4);
    photos[row].first = text.substr(begin, end - begin);
  }
  return photos;
}

// Level 0 has the faces, and so the labels, of `gpvc texture`.
TEST_F(TilesetCommand, FacesTellTheirPhoto) {
  const fs::path plain = folder_.path() / "plain";
  ASSERT_EQ(run(texture(plain)).exit_code, 0);
  std::map<std::string, std::size_t> expected, found;
  const Json views = Json::parse(read_file(plain / "views.json"))["views"];
  for (const std::int32_t label : npy<std::int32_t>(plain / "labels.npy"))
    ++expected[label < 0 ? "" : views[static_cast<std::size_t>(label)]["name"].get<std::string>()];
  ASSERT_GT(expected.size(), 3u);
  for (const char* more : {"--no-resume", "--compress"}) {
    ASSERT_EQ(run(tileset({more, "--force", "--copyright", "City of Ulm"})).exit_code, 0);
    found.clear();
    for (const fs::directory_entry& tile : fs::directory_iterator(out_ / "tiles")) {
      if (!tile.path().filename().string().starts_with("0_")) continue;
      const Glb glb(tile.path());
      EXPECT_EQ(glb.json["asset"]["copyright"], "City of Ulm");
      const auto photos = photos_of(glb);
      for (const Json& primitive : glb.json["meshes"][0]["primitives"]) {
        const std::string rows = glb.values(primitive["attributes"]["_FEATURE_ID_0"]);
        for (const Triangle& corners : triangles_of(glb.values(primitive["indices"]))) {
          std::set<float> of_corners;
          for (const std::uint32_t corner : corners) {
            float row = -1;
            std::memcpy(&row, rows.data() + 4 * std::size_t{corner}, 4);
            of_corners.insert(row);
          }
          ASSERT_EQ(of_corners.size(), 1u);
          const auto& [name, gsd] = photos.at(static_cast<std::size_t>(*of_corners.begin()));
          ++found[name];
          // Photos of 240 pixels across some 100 m.
          EXPECT_TRUE(name.empty() ? gsd == 0 : gsd > 0.05 && gsd < 2) << name << " " << gsd;
        }
      }
    }
    EXPECT_EQ(found, expected) << more;
  }
  EXPECT_EQ(Json::parse(read_file(out_ / "tileset.json"))["asset"]["copyright"], "City of Ulm");
}

TEST_F(TilesetCommand, APlaceStandsOnTheGlobe) {
  ASSERT_EQ(run(tileset({"--place", "48.5,11.25,600,90"})).exit_code, 0);
  const Json matrix = Json::parse(read_file(out_ / "tileset.json"))["root"]["transform"];
  const double distance = std::hypot(matrix[12].get<double>(), matrix[13].get<double>(), matrix[14].get<double>());
  EXPECT_NEAR(distance, 6366.8e3, 1e3);
  EXPECT_EQ(run_json(out_)["options"]["place"], Json({48.5, 11.25, 600, 90}));
  EXPECT_TRUE(contains(read_file(out_ / "index.html"), "tileset.json"));
  for (const char* bad : {"48.5,11.25", "95,11.25,600", "48.5,11.25,600,", "48.5,11.25,nan", "48.5,11.25,600,1,2"}) {
    const Outcome refused = run(tileset({"--force", "--place", bad}));
    EXPECT_EQ(refused.exit_code, 2) << bad;
    EXPECT_TRUE(contains(refused.err, "is not LAT,LON,HEIGHT or LAT,LON,HEIGHT,HEADING")) << refused.err;
  }
}

TEST_F(TilesetCommand, CompressedGeometryHoldsTheSameValues) {
  ASSERT_EQ(run(tileset({"--texture", "png"})).exit_code, 0);
  const fs::path plain = out_;
  const fs::path compressed = folder_.path() / "compressed";
  std::vector<std::string> words = tileset({"--texture", "png", "--compress"});
  std::ranges::replace(words, plain.string(), compressed.string());
  ASSERT_EQ(run(words).exit_code, 0);
  std::size_t plain_bytes = 0, bytes = 0;
  for (const fs::directory_entry& tile : fs::directory_iterator(plain / "tiles")) {
    const Glb a(tile.path()), b(compressed / "tiles" / tile.path().filename());
    plain_bytes += a.binary.size();
    bytes += b.binary.size();
    EXPECT_EQ(b.json["extensionsRequired"][0], "EXT_meshopt_compression");
    for (std::size_t p = 0; p < a.json["meshes"][0]["primitives"].size(); ++p) {
      const Json &before = a.json["meshes"][0]["primitives"][p], &after = b.json["meshes"][0]["primitives"][p];
      EXPECT_EQ(triangles_of(a.values(before["indices"])), triangles_of(b.values(after["indices"])));
      for (const char* name : {"POSITION", "TEXCOORD_0"})
        EXPECT_TRUE(a.values(before["attributes"][name]) == b.values(after["attributes"][name])) << name;
    }
  }
  EXPECT_LT(bytes, plain_bytes);
}

TEST_F(TilesetCommand, IsNoResultThatRulesCanChange) {
  ASSERT_EQ(run(tileset()).exit_code, 0);
  expect_one_sentence(run(texture(folder_.path() / "changed", {"--from", out_.string()})), out_.string(),
                      "holds no textured model");
}

TEST_F(TilesetCommand, IsTheSameForOneThread) {
  ASSERT_EQ(run(tileset()).exit_code, 0);
  const auto first = files_of(out_);
  ASSERT_EQ(run(tileset({"--force", "--threads", "1"})).exit_code, 0);
  const auto second = files_of(out_);
  ASSERT_EQ(first.size(), second.size());
  for (const auto& [name, bytes] : first) {
    if (name == "run.json") continue;
    EXPECT_TRUE(second.at(name) == bytes) << name;
  }
}

TEST_F(TilesetCommand, LeavesNothingOfARunThatFails) {
  fs::resize_file(scene_ / "images" / "east_001.jpg", 2000);
  expect_one_sentence(run(tileset()), "east_001.jpg", "");
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(TilesetCommand, DoesNotReplaceAnotherResult) {
  ASSERT_EQ(run(texture(out_)).exit_code, 0);
  const auto before = files_of(out_);
  expect_one_sentence(run(tileset({"--force"})), out_.string(), "texture");
  EXPECT_TRUE(files_of(out_) == before);
}

}  // namespace
}  // namespace gpvc
