// glTF as browsers load it: quantized and packed geometry, WebP pages. What is written is read back.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "io/mesh.h"
#include "io/meshes/normals.h"
#include "io/vector.h"
#include "tests/atlas/strip_model.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::read_file;
using test::write_glb;
using Json = nlohmann::json;

// Hills of 2 x 24 x 24 triangles at UTM size, their left half on page 0, the right on page 1, listed in an order that nothing
// gains from.
struct Hills {
  static constexpr std::uint32_t kEdge = 24;
  Hills() {
    for (std::uint32_t y = 0; y <= kEdge; ++y)
      for (std::uint32_t x = 0; x <= kEdge; ++x) {
        mesh.positions.push_back({500000.3 + x, 5400000.7 + y, 3 * std::sin(0.5 * x) * std::cos(0.4 * y)});
        model.texcoords.push_back({static_cast<float>(x) / kEdge, static_cast<float>(y) / kEdge});
      }
    constexpr std::uint32_t kCells = kEdge * kEdge, kStride = 241;  // which has no divisor in common with the cells
    for (std::uint32_t n = 0; n < kCells; ++n) {
      const std::uint32_t cell = n * kStride % kCells, at = cell / kEdge * (kEdge + 1) + cell % kEdge;
      mesh.faces.insert(mesh.faces.end(), {{at, at + 1, at + kEdge + 1}, {at + kEdge + 2, at + kEdge + 1, at + 1}});
      model.face_page.insert(model.face_page.end(), 2, cell % kEdge < kEdge / 2 ? 0u : 1u);
    }
    // The same triangle twice: both faces are to be found again.
    mesh.faces.push_back(mesh.faces[0]);
    model.face_page.push_back(model.face_page[0]);
    model.face_texcoords = mesh.faces;
    model.mesh = &mesh;
    Image page{64, 48, 3, {}};
    for (int i = 0; i < 64 * 48; ++i)
      for (const int c : {0, 1, 2}) page.pixels.push_back(static_cast<std::uint8_t>(i % 64 + 60 * c + i / 64));
    for (const std::string name : {"a", "b"}) {
      const PageFile file{folder.path() / (name + ".webp"), ImageFormat::webp, folder.path() / (name + ".jpg")};
      write_image(file.file, page, ImageFormat::webp, 90);
      write_image(file.fallback, reduce_image(page, 4), ImageFormat::jpg, 75);
      pages.push_back(file);
    }
    options.coding = GltfCoding::quantized;
    options.offset = {500000, 5400000, 0};
  }
  std::filesystem::path file() const { return folder.path() / "m.glb"; }
  LoadedModel written() const {
    write_glb(file(), model, pages, options);
    return read_textured_model(file());
  }
  std::size_t json_bytes() const {
    std::uint32_t length = 0;
    std::memcpy(&length, read_file(file()).data() + 12, sizeof length);
    return length;
  }
  Json json() const { return Json::parse(read_file(file()).substr(20, json_bytes())); }
  test::TemporaryFolder folder;
  Mesh mesh;
  TexturedModel model;
  std::vector<PageFile> pages;
  ModelOptions options;
};

TEST(WebGltf, HoldsEveryFaceInsideItsGrid) {
  const Hills hills;
  const std::vector<FaceId> faces = write_glb(hills.file(), hills.model, hills.pages, hills.options);
  const LoadedModel back = read_textured_model(hills.file());
  ASSERT_EQ(back.mesh.faces.size(), hills.mesh.faces.size());
  std::set<FaceId> all(faces.begin(), faces.end());
  EXPECT_EQ(all.size(), faces.size()) << "a face was listed twice";
  ASSERT_EQ(back.pages.size(), 2u);
  // 24.0 m in 65534 steps or fewer, a power of two.
  constexpr double kStep = 0x1p-11;
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const std::size_t face = index(faces[t]);
    EXPECT_EQ(back.model.face_page[t], hills.model.face_page[face]);
    // A triangle may begin with another of its corners.
    const auto place = [&](std::size_t corner) {
      return back.mesh.positions[back.mesh.faces[t][corner]] + back.offset;
    };
    std::size_t first = 0;
    while (first < 2 && length(place(first) - hills.mesh.positions[hills.mesh.faces[face][0]]) > 0.1) ++first;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t other = (first + corner) % 3;
      const WorldPoint &p = back.mesh.positions[back.mesh.faces[t][other]],
                       &q = hills.mesh.positions[hills.mesh.faces[face][corner]];
      EXPECT_LE(std::abs(p.x + back.offset.x - q.x), kStep / 2 + 1e-9);
      EXPECT_LE(std::abs(p.y + back.offset.y - q.y), kStep / 2 + 1e-9);
      EXPECT_LE(std::abs(p.z + back.offset.z - q.z), kStep / 2 + 1e-9);
      EXPECT_EQ(p.x, std::round(p.x / kStep) * kStep) << "not on the grid that all models have in common";
      const TexCoord &s = back.model.texcoords[back.model.face_texcoords[t][other]],
                     &u = hills.model.texcoords[hills.model.face_texcoords[face][corner]];
      EXPECT_NEAR(s.u, u.u, 0.5 / 65535 + 1e-7);
      EXPECT_NEAR(s.v, u.v, 0.5 / 65535 + 1e-7);
    }
  }
  // No crack: as many places as the mesh has vertices, whatever page they are on.
  EXPECT_EQ(read_mesh(hills.file()).positions.size(), hills.mesh.positions.size());
}

TEST(WebGltf, IsAFractionOfThePlainOne) {
  Hills hills;
  hills.written();
  const auto web = std::filesystem::file_size(hills.file());
  hills.options.coding = GltfCoding::plain;
  hills.written();
  const auto plain = std::filesystem::file_size(hills.file());
  const std::size_t pages =
      std::filesystem::file_size(hills.pages[0].file) * 2 + std::filesystem::file_size(hills.pages[0].fallback) * 2;
  EXPECT_LT(2 * (web - pages), plain - pages) << "two kilobytes of which are its description";
  hills.options.coding = GltfCoding::quantized;
  const std::size_t told = gltf_geometry_bytes(hills.model, 2, hills.options);
  hills.written();
  const Json json = hills.json();
  const std::size_t buffer = json["buffers"][0]["byteLength"];
  EXPECT_GE(buffer, told + pages);
  EXPECT_LE(buffer, told + pages + 16) << "padding";
}

TEST(WebGltf, NamesWhatReadersHaveToKnow) {
  Hills hills;
  hills.written();
  Json json = hills.json();
  EXPECT_EQ(json["extensionsRequired"], Json({"KHR_mesh_quantization", "EXT_meshopt_compression"}));
  EXPECT_EQ(json["extensionsUsed"],
            Json({"KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_texture_webp", "KHR_materials_unlit"}));
  const Json texture = json["textures"][0];
  const auto image = [&](const Json& number) { return json["images"][number.get<std::size_t>()]["mimeType"]; };
  EXPECT_EQ(image(texture["extensions"]["EXT_texture_webp"]["source"]), "image/webp");
  EXPECT_EQ(image(texture["source"]), "image/jpeg");
  hills.pages[1].fallback.clear();
  EXPECT_EQ(hills.written().pages.size(), 2u);
  json = hills.json();
  EXPECT_EQ(json["extensionsRequired"], Json({"KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_texture_webp"}));
  EXPECT_FALSE(json["textures"][1].contains("source"));
}

TEST(WebGltf, ReadersOfWebpTakeThePageAndNotItsFallback) {
  const Hills hills;
  const LoadedModel back = hills.written();
  EXPECT_EQ(back.pages[0].width, 64);
  EXPECT_EQ(back.pages[0].pixels, read_image(hills.pages[0].file).pixels);
}

TEST(WebGltf, NormalsAreWithinADegree) {
  Hills hills;
  hills.options.normals = hills.options.lit = true;
  write_glb(hills.file(), hills.model, hills.pages, hills.options);
  const Json json = hills.json();
  EXPECT_FALSE(json["materials"][0].contains("extensions")) << "viewers are to light it";
  const std::size_t number = json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"];
  EXPECT_EQ(json["accessors"][number]["componentType"], 5120);
  EXPECT_EQ(json["accessors"][number]["normalized"], true);
  const auto normals = vertex_normals(hills.mesh);
  for (const auto& n : normals) {
    double rounded[3], length = 0, dot = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      rounded[i] = std::round(127.0 * n[i]);
      length += rounded[i] * rounded[i];
      dot += rounded[i] * n[i];
    }
    EXPECT_GT(dot / std::sqrt(length), std::cos(std::numbers::pi / 180));
  }
}

// A mesh of a few metres with one vertex far away: 16 bits would round it to steps of a metre.
TEST(WebGltf, PositionsStayFloatsWhereAGridIsTooCoarse) {
  Hills hills;
  hills.mesh.positions.back() = {500000 + 1e5, 5400000, 0};
  const LoadedModel back = hills.written();
  EXPECT_EQ(hills.json()["accessors"][1]["componentType"], 5126);
  const Mesh mesh = read_mesh(hills.file());
  std::set<std::pair<float, float>> places;
  for (const WorldPoint& p : hills.mesh.positions)
    places.insert({static_cast<float>(p.x - 500000), static_cast<float>(p.y - 5400000)});
  for (const WorldPoint& p : back.mesh.positions)
    EXPECT_TRUE(places.contains({static_cast<float>(p.x), static_cast<float>(p.y)})) << p.x << ' ' << p.y;
  EXPECT_EQ(mesh.faces.size(), hills.mesh.faces.size());
}

TEST(WebGltf, TexturesThatRepeatKeepTheirCoordinates) {
  Hills hills;
  hills.model.texcoords[5] = {1.75f, -2.5f};
  write_glb(hills.file(), hills.model, hills.pages, hills.options);
  EXPECT_EQ(hills.json()["accessors"][2]["componentType"], 5126);
}

TEST(WebGltf, PackedFloatsAreTheSame) {
  Hills hills;
  hills.options.coding = GltfCoding::plain;
  const LoadedModel plain = hills.written();
  hills.options.coding = GltfCoding::compressed;
  const LoadedModel packed = hills.written();
  EXPECT_EQ(hills.json()["extensionsRequired"], Json({"EXT_meshopt_compression"}));
  ASSERT_EQ(plain.mesh.faces.size(), packed.mesh.faces.size());
  EXPECT_EQ(plain.mesh.positions, packed.mesh.positions);
  for (std::size_t f = 0; f < plain.mesh.faces.size(); ++f) {
    Triangle a = plain.mesh.faces[f], b = packed.mesh.faces[f];
    for (Triangle* t : {&a, &b}) std::rotate(t->begin(), std::ranges::min_element(*t), t->end());
    EXPECT_EQ(a, b);
  }
}

TEST(WebGltf, IsTheSameInFiles) {
  const Hills hills;
  const LoadedModel glb = hills.written();
  const GltfFiles files =
      write_gltf(hills.folder.path() / "m", GltfContainer::files, hills.model, hills.pages, hills.options);
  EXPECT_EQ(files.file.filename(), "m.gltf");
  const LoadedModel parts = read_textured_model(files.file);
  EXPECT_EQ(parts.mesh.positions, glb.mesh.positions);
  EXPECT_EQ(parts.mesh.faces, glb.mesh.faces);
  EXPECT_EQ(parts.pages[1].pixels, glb.pages[1].pixels);
}

std::string refusal(const Hills& hills, const std::string& bytes) {
  const auto file = hills.folder.write("changed.glb", bytes);
  return test::input_error([&] { read_textured_model(file); });
}

TEST(WebGltf, RefusesWhatIsCutAnywhere) {
  const Hills hills;
  hills.written();
  const std::string good = read_file(hills.file());
  for (std::size_t size = 0; size < good.size(); size += 7)
    EXPECT_TRUE(contains(refusal(hills, good.substr(0, size)), "changed.glb: ")) << size;
}

TEST(WebGltf, RefusesWhatCannotBeUnpacked) {
  const Hills hills;
  hills.written();
  const std::string good = read_file(hills.file());
  const auto with = [&](const std::string& what, const std::string& by) {
    std::string changed = good;
    const std::size_t at = changed.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return changed.replace(at, what.size(), by);
  };
  EXPECT_TRUE(contains(refusal(hills, with("\"TRIANGLES\"", "\"TRIANGLEZ\"")),
                       "buffer view 0: is packed in a way that EXT_meshopt_compression does not know"));
  // A count of so many elements as no bytes of that number make, in a description of the same length.
  const Json json = hills.json();
  const Json& packed = json["bufferViews"][1]["extensions"]["EXT_meshopt_compression"];
  const std::string count = "\"count\":" + packed["count"].dump() + ",\"mode\":\"ATTRIBUTES\"";
  EXPECT_TRUE(contains(refusal(hills, with(count, "\"count\":" + std::to_string(packed["count"].get<int>() + 300) +
                                                      ",\"mode\":\"ATTRIBUTES\"")),
                       "buffer view 1: cannot be unpacked"));
  const std::string length = "\"byteLength\":" + packed["byteLength"].dump() + ",\"byteOffset\"";
  EXPECT_TRUE(contains(
      refusal(hills, with(length, "\"byteLength\":" + std::string(length.size() - 26, '1') + ",\"byteOffset\"")),
      "buffer view 1: "));
  // Views that unpack the same bytes again and again.
  Json many = hills.json();
  for (int n = 0; n < 2000; ++n) many["bufferViews"].push_back(many["bufferViews"][0]);
  std::string text = many.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::string rest = good.substr(20 + hills.json_bytes());
  const auto word = [](std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&number), sizeof number);
  };
  EXPECT_TRUE(contains(refusal(hills, good.substr(0, 8) + word(20 + text.size() + rest.size()) + word(text.size()) +
                                          "JSON" + text + rest),
                       "is packed in bytes of other views"));
  // The first byte of packed indices says so.
  const std::size_t binary = good.find("BIN", 20) + 4;
  std::string damaged = good;
  damaged[binary] = '\x11';
  EXPECT_TRUE(contains(refusal(hills, damaged),
                       "buffer view 0: cannot be unpacked, expected whole data of EXT_meshopt_compression"));
}

}  // namespace
}  // namespace gpvc::io
