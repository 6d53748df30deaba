// gpvc photos and gpvc coverage: which photos show a point, held against rays in long double.
#include <fmt/format.h>

#include <random>

#include "io/images.h"
#include "io/mesh.h"
#include "io/photos.h"
#include "io/reference_system.h"
#include "io/scene_files.h"
#include "tests/app/app_fixture.h"
#include "tests/visibility/visibility_oracle.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using namespace test;
using nlohmann::json;

class PhotosCommand : public App {
 protected:
  std::vector<std::string> command(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> words{name, (scene_ / "colmap").string(), (scene_ / "mesh.ply").string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  json answers(std::vector<std::string> more) const {
    const fs::path file = folder_.path() / "answers.json";
    more.insert(more.end(), {"--json", file.string()});
    const Outcome outcome = run(command("photos", more));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(read_file(file))["points"];
  }
  fs::path editable() const {
    const fs::path out = folder_.path() / "textured";
    EXPECT_EQ(run(texture(out, {"--editable"})).exit_code, 0);
    return out;
  }
  void expect_refused_photos(const std::vector<std::string>& more, const std::string& where,
                             const std::string& why) const {
    expect_one_sentence(run(command("photos", more)), where, why);
  }
  // The scene as OpenDroneMap has it: in UTM coordinates less an offset.
  fs::path georeferenced() const {
    const Scene scene = io::read_scene(scene_ / "colmap", {});
    json shots, camera;
    for (const View& view : scene.views) {
      const auto& r = view.pose.rotation;
      const double angle = std::acos((r[0] + r[4] + r[8] - 1) / 2), scale = angle / (2 * std::sin(angle));
      const CameraPoint t = camera_from_world(view.pose, {0, 0, 0});
      shots[view.name] = {{"camera", "c"},
                          {"rotation", {scale * (r[7] - r[5]), scale * (r[2] - r[6]), scale * (r[3] - r[1])}},
                          {"translation", {t.x, t.y, t.z}}};
      const Camera& c = view.camera;
      const double longer = std::max(c.width, c.height);
      camera = {{"projection_type", "brown"},
                {"width", c.width},
                {"height", c.height},
                {"focal_x", c.fx / longer},
                {"focal_y", c.fy / longer},
                {"c_x", (c.cx - c.width / 2.0) / longer},
                {"c_y", (c.cy - c.height / 2.0) / longer},
                {"k1", c.distortion.k1},
                {"k2", c.distortion.k2},
                {"p1", c.distortion.p1},
                {"p2", c.distortion.p2},
                {"k3", c.distortion.k3}};
    }
    const fs::path project = folder_.path() / "odm";
    for (const char* name : {"opensfm", "odm_georeferencing"}) fs::create_directories(project / name);
    std::ofstream(project / "opensfm" / "reconstruction.json")
        << json::array({{{"cameras", {{"c", camera}}}, {"shots", shots}, {"points", json::object()}}});
    std::ofstream(project / "opensfm" / "reconstruction.topocentric.json") << "[]";
    std::ofstream(project / "odm_georeferencing" / "coords.txt") << "WGS84 UTM 32N\n448000 5411000\n";
    return project;
  }
  Mesh mesh() const { return io::read_mesh(scene_ / "mesh.ply"); }
};

// Points all over a mesh, by face and weights of its corners.
struct RandomPoints {
  std::vector<std::uint32_t> faces;
  std::vector<WorldPoint> at;
  RandomPoints(const Mesh& mesh, std::size_t count) {
    std::mt19937 random(48);
    const auto share = [&] { return static_cast<double>(random() % 1000 + 1) / 1001; };
    for (std::size_t n = 0; n < count; ++n) {
      faces.push_back(static_cast<std::uint32_t>(random() % mesh.faces.size()));
      double a = share(), b = share();
      if (a + b >= 1) a = 1 - a, b = 1 - b;
      const auto [i, j, k] = mesh.faces[faces.back()];
      const WorldPoint &p = mesh.positions[i], &q = mesh.positions[j], &r = mesh.positions[k];
      const auto mean = [&](double x, double y, double z) { return x + a * (y - x) + b * (z - x); };
      at.push_back({mean(p.x, q.x, r.x), mean(p.y, q.y, r.y), mean(p.z, q.z, r.z)});
    }
  }
};

// Whether a view shows the point of a face, by brute force; nullopt where that hangs on rounding.
std::optional<bool> shows(const Mesh& mesh, const View& view, std::uint32_t face, const WorldPoint& point) {
  const auto frame = pixel_from_world(view, point);
  if (!frame || !is_in_frame(view.camera, *frame) || !in_photo(view.camera, *frame)) return false;
  const oracle::Ray ray = oracle::ray_of(view.camera, frame->x, frame->y);
  const oracle::Corners own = oracle::prepare(mesh, view, face).corners;
  const auto hit = oracle::meet(ray, own, 1e-6L);
  if (!hit) return std::nullopt;
  const oracle::Vec normal = oracle::cross(own[1] - own[0], own[2] - own[0]);
  if (oracle::dot(normal, ray.direction) >= 0) return false;
  bool hidden = false;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (f == face) continue;
    const auto other = oracle::meet(ray, oracle::prepare(mesh, view, f).corners, 1e-9L);
    if (!other || other->depth > hit->depth * (1 + 1e-9L)) continue;
    if (other->margin_px < 1e-9L || other->depth > hit->depth * (1 - 1e-9L)) return std::nullopt;
    hidden = true;
  }
  return !hidden;
}

TEST_F(PhotosCommand, EveryPhotoListedShowsThePointAndNoneIsMissing) {
  const Mesh mesh = this->mesh();
  const Scene scene = io::read_scene(scene_ / "colmap", {});
  const RandomPoints points(mesh, 60);
  std::vector<std::string> asked;
  for (const WorldPoint& p : points.at) asked.push_back(fmt::format("--at={},{},{}", p.x, p.y, p.z));
  const json all = answers(asked);
  ASSERT_EQ(all.size(), points.at.size());
  std::size_t listed = 0, others = 0;
  std::map<std::string, int> reasons;
  for (std::size_t n = 0; n < all.size(); ++n)
    for (const json& photo : all[n]["photos"]) {
      const View& view = scene.views[photo["view"].get<std::size_t>()];
      ++reasons[photo["reason"]];
      const auto expected = shows(mesh, view, points.faces[n], points.at[n]);
      if (!expected) continue;
      EXPECT_EQ(photo["shows"], *expected) << view.name << ", face " << points.faces[n] << ": " << photo;
      ++(*expected ? listed : others);
      if (photo["reason"] == "behind") continue;
      const auto pixel = photo_from_world(view, points.at[n]);
      ASSERT_EQ(photo["pixel"].is_null(), !pixel);
      if (!pixel) continue;
      EXPECT_NEAR(photo["pixel"][0].get<double>(), pixel->x, 1e-6);
      EXPECT_NEAR(photo["pixel"][1].get<double>(), pixel->y, 1e-6);
    }
  EXPECT_GT(listed, 40U);
  EXPECT_GT(others, 100U);
  for (const char* reason : {"shown", "outside-frame", "back", "hidden"}) EXPECT_GT(reasons[reason], 0) << reason;
}

TEST_F(PhotosCommand, ClassesAreThoseOfTheRenderedViews) {
  ASSERT_EQ(run(command("visibility", {"-o", out_.string()})).exit_code, 0);
  const Scene scene = io::read_scene(scene_ / "colmap", {});
  std::vector<std::string> asked;
  for (int face = 5; face < 4000; face += 97) asked.insert(asked.end(), {"--face", std::to_string(face)});
  const std::map<std::string, int> codes{{"hidden", 0}, {"partial", 1}, {"full", 2}};
  std::size_t seen = 0;
  for (const json& answer : answers(asked))
    for (const json& photo : answer["photos"]) {
      if (photo["reason"] == "behind" || photo["reason"] == "outside-frame") continue;
      const auto classes = npy<std::uint8_t>(out_ / "visibility" / (photo["name"].get<std::string>() + ".npy"));
      EXPECT_EQ(codes.at(photo["class"]), classes[photo["face"].get<std::size_t>()]) << photo;
      seen += photo["class"] != "hidden" ? 1 : 0;
    }
  EXPECT_GT(seen, 30U);
}

TEST_F(PhotosCommand, AnEarlierResultKnowsOutliersCostsAndLabels) {
  const fs::path from = editable();
  const auto labels = npy<std::int32_t>(from / "labels.npy");
  std::vector<std::string> asked;
  for (int face = 11; face < 4000; face += 83) asked.insert(asked.end(), {"--face", std::to_string(face)});
  std::vector<std::string> with_result = asked, judged = asked;
  with_result.insert(with_result.end(), {"--from", from.string()});
  judged.emplace_back("--judge");
  const json known = answers(with_result), compared = answers(judged);
  std::size_t chosen = 0;
  ASSERT_EQ(known.size(), compared.size());
  for (std::size_t n = 0; n < known.size(); ++n) {
    double last = 0;
    const std::int32_t label = labels[known[n]["faces"][0].get<std::size_t>()];
    for (std::size_t p = 0; p < known[n]["photos"].size(); ++p) {
      json photo = known[n]["photos"][p], other = compared[n]["photos"][p];
      EXPECT_EQ(photo["textures_face"], label >= 0 && photo["view"] == label);
      if (photo["textures_face"] == true) {
        EXPECT_TRUE(photo["candidate"] == true || photo["shows"] == false) << photo;
        ++chosen;
      }
      photo.erase("textures_face");
      other.erase("textures_face");
      EXPECT_EQ(photo, other) << "the same whether kept or compared anew";
      if (photo["candidate"] != true || photo["shows"] != true) continue;
      EXPECT_GE(photo["cost"]["total"].get<double>(), last) << "best first";
      last = photo["cost"]["total"];
      EXPECT_FALSE(photo["cost"]["silhouette"].is_null());
    }
  }
  EXPECT_GT(chosen, 20U);
  // A photo that is forbidden everywhere.
  std::ofstream(folder_.path() / "rules.csv") << "box,-1e6 -1e6 -1e6 1e6 1e6 1e6,forbid,east_001.jpg\n";
  with_result.insert(with_result.end(), {"--allow", (folder_.path() / "rules.csv").string()});
  std::size_t refused = 0;
  for (const json& answer : answers(with_result))
    for (const json& photo : answer["photos"]) {
      EXPECT_FALSE(photo["name"] == "east_001.jpg" && photo["shows"] == true);
      refused += photo["reason"] == "refused" ? 1 : 0;
    }
  EXPECT_GT(refused, 5U);
}

TEST_F(PhotosCommand, CropsAreAroundThePixel) {
  const fs::path crops = folder_.path() / "crops";
  const json answer = answers({"--face", "700", "--crops", crops.string(), "--crop-size", "64"})[0];
  std::size_t written = 0;
  for (const json& photo : answer["photos"]) {
    const fs::path file = crops / "1" / (photo["name"].get<std::string>() + ".png");
    EXPECT_EQ(fs::exists(file), photo["shows"].get<bool>());
    if (!photo["shows"].get<bool>()) continue;
    const Image crop = io::read_image(file),
                whole = io::read_image(scene_ / "images" / photo["name"].get<std::string>());
    const int x = static_cast<int>(photo["pixel"][0].get<double>()),
              y = static_cast<int>(photo["pixel"][1].get<double>());
    const int x0 = std::max(0, x - 32), y0 = std::max(0, y - 32);
    EXPECT_EQ(crop.width, std::min(whole.width, x + 32) - x0);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(crop.at(x - x0, y - y0)[c], whole.at(x, y)[c]) << "the pixel itself is free";
    ++written;
  }
  EXPECT_EQ(written, answer["shown"].get<std::size_t>());
}

TEST_F(PhotosCommand, TheTableNamesPhotosAndReasons) {
  const Outcome outcome = run(command("photos", {"--face", "700"}));
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.out, "face 700: ("));
  EXPECT_TRUE(contains(outcome.out, "of 5 photos"));
  EXPECT_TRUE(contains(outcome.out, "gsd"));
  EXPECT_TRUE(contains(outcome.err, "--judge")) << "what is not known, and how it can be";
}

TEST_F(PhotosCommand, TakesPointsInTheSystemsThatAreKnown) {
  const fs::path project = georeferenced(), file = folder_.path() / "answers.json",
                 geo = folder_.path() / "points.json";
  const auto answer = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{
        "photos", project.string(), (scene_ / "mesh.ply").string(), "--images", (scene_ / "images").string(),
        "--json", file.string()};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(read_file(file))["points"][0];
  };
  const json local = answer({"--at=3.25,4.5,0.125"});
  EXPECT_NEAR(local["at_srs"][0].get<double>(), 448000 + local["at"][0].get<double>(), 1e-6);
  for (const std::vector<std::string>& same :
       {std::vector<std::string>{"--at=448003.25,5411004.5,0.125"},
        std::vector<std::string>{"--at=448003.25,5411004.5,0.125", "--crs", "EPSG:32632"}}) {
    const json other = answer(same);
    EXPECT_EQ(other["faces"], local["faces"]);
    EXPECT_EQ(other["photos"].size(), local["photos"].size());
    EXPECT_EQ(other["shown"], local["shown"]);
  }
  std::vector<WorldPoint> degrees{{448003.25, 5411004.5, 0}};
  io::transform_points("EPSG:32632", "OGC:CRS84", degrees);
  std::ofstream(geo) << json{{"type", "Feature"},
                             {"properties", {{"name", "GCP 7"}}},
                             {"geometry", {{"type", "Point"}, {"coordinates", {degrees[0].x, degrees[0].y}}}}};
  const json above = answer({"--geojson", geo.string()});
  EXPECT_EQ(above["name"], "GCP 7");
  EXPECT_NEAR(above["at"][0].get<double>(), 3.25, 1e-6);
  EXPECT_NEAR(above["at"][1].get<double>(), 4.5, 1e-6);
  EXPECT_GE(above["at"][2].get<double>(), local["at"][2].get<double>() - 0.125) << "the highest surface";
  const Outcome outcome = run({"coverage", project.string(), (scene_ / "mesh.ply").string(), "--images",
                               (scene_ / "images").string(), "-o", out_.string(), "--min-area", "0"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json map = json::parse(read_file(out_ / "coverage.geojson"));
  EXPECT_FALSE(map.contains("coordinates"));
  ASSERT_GT(map["features"].size(), 0U);
  for (const json& feature : map["features"]) {
    const json& corner = feature["geometry"]["coordinates"][0][0][0];
    EXPECT_NEAR(corner[0].get<double>(), degrees[0].x, 0.002);
    EXPECT_NEAR(corner[1].get<double>(), degrees[0].y, 0.002);
  }
}

TEST_F(PhotosCommand, RefusesWhatIsNoPoint) {
  const std::string mesh = (scene_ / "mesh.ply").string(), geo = (folder_.path() / "points.json").string();
  expect_refused_photos({"--at", "1e5,0,0"}, mesh, "from the surface, farther than");
  expect_refused_photos({"--face", "123456789"}, mesh, "has no face 123456789");
  expect_refused_photos({"--at", "0,0,0", "--crs", "EPSG:4326"}, mesh, "the scene names no reference system");
  for (const auto& [text, why] : std::vector<std::pair<std::string, std::string>>{
           {"{\"type\": \"Point\", \"coordinates\": [1", "JSON"},
           {"[]", "expected GeoJSON"},
           {R"({"type": "LineString", "coordinates": [[0, 0], [1, 1]]})", "expected a Point or a MultiPoint"},
           {R"({"type": "Point", "coordinates": [0, "north"]})", "expected two or three numbers"},
           {R"({"type": "FeatureCollection", "features": []})", "holds no point"}}) {
    std::ofstream(geo) << text;
    expect_refused_photos({"--geojson", geo}, geo, why);
  }
  std::ofstream(geo) << R"({"type": "Point", "coordinates": [8.5, 47.25]})";
  expect_refused_photos({"--geojson", geo}, mesh,
                        "is in longitude and latitude, and the scene names no reference system");
  expect_refused_photos({"--face", "1", "--from", scene_.string()}, scene_.string(), "holds no textured model");
  for (const auto& words :
       std::vector<std::vector<std::string>>{{}, {"--at", "1,2"}, {"--at", "nan,0,0"}, {"--at", "1,2,x"}})
    EXPECT_EQ(run(command("photos", words)).exit_code, 2);
}

TEST_F(PhotosCommand, TheIndexHoldsWhatViewsSee) {
  const fs::path file = folder_.path() / "index.npz";
  ASSERT_EQ(run(command("photos", {"--index", file.string()})).exit_code, 0);
  const std::string bytes = read_file(file);
  EXPECT_TRUE(bytes.starts_with("PK"));
  for (const char* name : {"first.npy", "views.npy", "classes.npy", "shares.npy", "gsd.npy", "angle.npy", "names.npy"})
    EXPECT_TRUE(contains(bytes, name)) << name;
  EXPECT_FALSE(contains(bytes, "costs.npy")) << "nobody has compared the photos";
}

class CoverageCommand : public PhotosCommand {};

TEST_F(CoverageCommand, CountsPhotosAndOutlinesAreas) {
  ASSERT_EQ(run(command("visibility", {"-o", (folder_.path() / "seen").string()})).exit_code, 0);
  const Outcome outcome = run(command("coverage", {"-o", out_.string(), "--min-photos", "3", "--min-area", "0"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto photos = npy<std::uint32_t>(out_ / "coverage_photos.npy");
  const auto lacks = npy<std::uint8_t>(out_ / "coverage_lack.npy");
  const auto gsd = npy<float>(out_ / "coverage_gsd.npy");
  std::vector<std::uint32_t> full(photos.size()), any(photos.size());
  for (const auto& entry : fs::directory_iterator(folder_.path() / "seen" / "visibility")) {
    const auto classes = npy<std::uint8_t>(entry.path());
    ASSERT_EQ(classes.size(), photos.size());
    for (std::size_t f = 0; f < classes.size(); ++f) {
      full[f] += classes[f] == 2 ? 1 : 0;
      any[f] += classes[f] != 0 ? 1 : 0;
    }
  }
  for (std::size_t f = 0; f < photos.size(); ++f) {
    EXPECT_GE(photos[f], full[f]);
    EXPECT_LE(photos[f], any[f]);
    EXPECT_EQ(lacks[f] == 1, photos[f] == 0);
    EXPECT_EQ(lacks[f] == 2, photos[f] > 0 && photos[f] < 3);
    EXPECT_EQ(std::isinf(gsd[f]), photos[f] == 0);
  }
  const json map = json::parse(read_file(out_ / "coverage.geojson"));
  EXPECT_EQ(map["type"], "FeatureCollection");
  EXPECT_TRUE(map.contains("coordinates")) << "a scene without a reference system says what the numbers are";
  std::size_t faces = 0;
  for (const json& feature : map["features"]) {
    faces += feature["properties"]["faces"].get<std::size_t>();
    ASSERT_EQ(feature["geometry"]["type"], "MultiPolygon");
    for (const json& polygon : feature["geometry"]["coordinates"])
      for (std::size_t r = 0; r < polygon.size(); ++r) {
        const json& ring = polygon[r];
        ASSERT_GE(ring.size(), 5U);
        EXPECT_EQ(ring.front(), ring.back());
        double twice = 0;
        for (std::size_t n = 0; n + 1 < ring.size(); ++n)
          twice += ring[n][0].get<double>() * ring[n + 1][1].get<double>() -
                   ring[n][1].get<double>() * ring[n + 1][0].get<double>();
        EXPECT_EQ(twice > 0, r == 0) << "the right-hand rule of RFC 7946";
      }
  }
  EXPECT_EQ(faces, static_cast<std::size_t>(std::ranges::count_if(lacks, [](std::uint8_t lack) { return lack != 0; })));
  const std::string table = read_file(out_ / "coverage.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(table, '\n')), map["features"].size() + 1);
  const Image picture = io::read_image(out_ / "coverage.png");
  EXPECT_GT(picture.width, 700);
  EXPECT_EQ(run_json(out_)["counts"]["wanted"]["photos"], 3);
}

TEST_F(CoverageCommand, OutliersOfAnEarlierResultDoNotCount) {
  const fs::path from = editable();
  ASSERT_EQ(run(command("coverage", {"-o", out_.string()})).exit_code, 0);
  const auto all = npy<std::uint32_t>(out_ / "coverage_photos.npy");
  ASSERT_EQ(run(command("coverage", {"-o", out_.string(), "--force", "--from", from.string()})).exit_code, 0);
  const auto judged = npy<std::uint32_t>(out_ / "coverage_photos.npy");
  std::size_t same = 0;
  for (std::size_t f = 0; f < all.size(); ++f) {
    EXPECT_LE(judged[f], all[f]);
    same += judged[f] == all[f] ? 1 : 0;
  }
  EXPECT_GT(same, all.size() / 2);
  EXPECT_LT(same, all.size());
}

}  // namespace
}  // namespace gpvc
