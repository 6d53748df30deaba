// Scenes of any size for the benchmark of the whole program: the synthetic city and a flight over it. `gpvc synth`
// traces four rays a pixel, with shadows; here every pixel takes the face that is drawn there and its colour at one
// point, without shadows, which is several times as fast. All photos agree about the surfaces, which texturing needs.
#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/synth/city.h"
#include "benchmarks/child.h"
#include "benchmarks/pipeline.h"
#include "benchmarks/table.h"
#include "io/images.h"
#include "io/scene_files.h"
#include "io/vector.h"
#include "visibility/item_buffer.h"

namespace gpvc::scaling {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// A camera takes in 144 x 108 m of the ground straight below, and more of it obliquely. With an area that grows by
// 1000 m2 a photo, a face that is seen at all is seen by 5 photos of 10, whose views reach far beyond their small city,
// 9 of 50 and 10 of 200.
constexpr double kDistance_m = 120, kAreaPerPhoto_m2 = 1000;
// Photos that take in 144 x 108 m and overlap by 80 % along and across are 28.8 and 21.6 m apart.
constexpr double kAreaPerNadirPhoto_m2 = 28.8 * 21.6;
constexpr int kPhotoQuality = 90;
constexpr int kGeneration = 1;  // to be raised when scenes of the same size come out different

/// What must be equal for a scene to be used again.
Json recipe(const SceneSize& size) {
  Json json = {{"generation", kGeneration},
               {"photos", size.photos},
               {"faces", size.faces},
               {"photo_size", {size.width, size.height}}};
  if (size.nadir) json["nadir"] = true;
  return json;
}

synth::CityOptions city_of(const SceneSize& size) {
  synth::CityOptions city;
  city.faces = size.faces;
  city.flight.photos = size.photos;
  city.flight.width = size.width;
  city.flight.height = size.height;
  city.flight.all_nadir = size.nadir;
  city.flight.size_m = std::sqrt((size.nadir ? kAreaPerNadirPhoto_m2 : kAreaPerPhoto_m2) * size.photos);
  city.flight.range = kDistance_m / city.flight.size_m;
  city.flight.distorted = false;
  return city;
}

// --- photos

/// A face as one photo shows it.
struct ShownFace {
  const synth::Surface* surface = nullptr;
  WorldPoint corner, normal;  // of the side that is seen
  WorldPoint low, high;       // the face's bounding box
  double light = 0;
};

double light_on(const WorldPoint& normal) {
  constexpr WorldPoint kSun{0.4514015204477136, -0.32099663676281853, 0.8325850266035605};  // unit length
  return 0.42 + 0.13 * normal.z + 0.55 * std::max(0.0, dot(normal, kSun));
}

ShownFace shown_face(const synth::SynthScene& scene, FaceId face, const WorldPoint& eye) {
  const Triangle& t = scene.mesh.faces[index(face)];
  const WorldPoint &a = scene.mesh.positions[t[0]], &b = scene.mesh.positions[t[1]], &c = scene.mesh.positions[t[2]];
  WorldPoint normal = unit(cross(b - a, c - a));
  if (dot(normal, eye - a) < 0) normal = normal * -1;
  const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
  const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
  const auto [z0, z1] = std::minmax({a.z, b.z, c.z});
  return {&scene.surfaces[scene.face_surface[index(face)]], a, normal, {x0, y0, z0}, {x1, y1, z1}, light_on(normal)};
}

/// Where the ray meets the face's plane. Nearly along the plane that is inaccurate, but it stays within the face's box.
WorldPoint point_on(const ShownFace& face, const WorldPoint& eye, const WorldPoint& ray) {
  const double t = dot(face.normal, face.corner - eye) / dot(face.normal, ray);
  if (!std::isfinite(t)) return face.corner;
  const WorldPoint p = eye + t * ray;
  return {std::clamp(p.x, face.low.x, face.high.x), std::clamp(p.y, face.low.y, face.high.y),
          std::clamp(p.z, face.low.z, face.high.z)};
}

/// Beyond the mesh, the ground goes on; above the horizon is sky.
synth::Color color_beyond(const synth::SynthScene& scene, const WorldPoint& eye, const WorldPoint& ray) {
  if (ray.z >= 0) return {206, 218, 232};
  synth::Color color = synth::surface_albedo(scene.surfaces[0], eye + (-eye.z / ray.z) * ray);
  for (double& c : color) c *= light_on({0, 0, 1});
  return color;
}

/// Noise of a sensor, without which photos would compress better than real ones do. `share` is in [0, 255].
double grain(std::uint32_t share) {
  constexpr double kGreyLevels = 6;  // each way
  return kGreyLevels * (share / 127.5 - 1);
}

Image take_photo(const synth::SynthScene& scene, const View& view, std::uint32_t number) {
  const Camera& camera = view.camera;
  const WorldPoint& eye = view.pose.centre;
  const visibility::Ivm ivm = visibility::draw_item_buffer(scene.mesh, camera, view.pose);
  Image photo{camera.width, camera.height, 3, std::vector<std::uint8_t>(3 * ivm.faces.size())};
  tbb::parallel_for(0, camera.height, [&](int y) {
    FaceId last = kNoFace;
    ShownFace face;
    for (int x = 0; x < camera.width; ++x) {
      const WorldPoint ray = ray_of(view, {x + 0.5, y + 0.5});
      const FaceId owner = ivm.at(x, y);
      synth::Color color;
      if (owner == kNoFace) {
        color = color_beyond(scene, eye, ray);
      } else {
        if (owner != last) face = shown_face(scene, owner, eye);
        last = owner;
        color = synth::surface_albedo(*face.surface, point_on(face, eye, ray));
        for (double& c : color) c *= face.light;
      }
      const std::uint32_t chance =
          synth::synth_hash(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), number);
      for (std::size_t c = 0; c < 3; ++c) {
        const double noisy = color[c] + grain((chance >> (8 * c)) & 255);
        photo.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(noisy + 0.5, 0.0, 255.0));
      }
    }
  });
  return photo;
}

struct Taken {
  std::size_t view;
  Image photo;
};

/// Writes the photos that are not there yet, encoding some while others are drawn; as many are in memory as there are
/// threads.
void take_photos(const synth::SynthScene& scene, const std::vector<View>& views, const fs::path& folder) {
  const auto file_of = [&](std::size_t v) { return folder / views[v].name; };
  std::vector<std::size_t> missing;
  for (std::size_t v = 0; v < views.size(); ++v)
    if (!fs::exists(file_of(v))) missing.push_back(v);
  std::size_t next = 0, done = 0;
  const auto choose = [&](tbb::flow_control& control) {
    if (next == missing.size()) control.stop();
    return next == missing.size() ? next : missing[next++];
  };
  const auto draw = [&](std::size_t v) {
    return std::make_shared<Taken>(Taken{v, take_photo(scene, views[v], static_cast<std::uint32_t>(v))});
  };
  const auto encode = [&](const std::shared_ptr<Taken>& taken) {
    io::write_image(file_of(taken->view), taken->photo, io::ImageFormat::jpg, kPhotoQuality);
    return taken->view;
  };
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const auto report = [&](std::size_t) {
    if (terminal) fmt::print(stderr, "\r{} of {} photos", ++done, missing.size());
  };
  using tbb::filter_mode;
  using tbb::make_filter;
  tbb::parallel_pipeline(static_cast<std::size_t>(tbb::info::default_concurrency()),
                         make_filter<void, std::size_t>(filter_mode::serial_in_order, choose) &
                             make_filter<std::size_t, std::shared_ptr<Taken>>(filter_mode::parallel, draw) &
                             make_filter<std::shared_ptr<Taken>, std::size_t>(filter_mode::parallel, encode) &
                             make_filter<std::size_t, void>(filter_mode::serial_out_of_order, report));
  if (terminal) std::fputs("\n", stderr);
}

// --- files

/// Null unless the file holds JSON.
Json read_json(const fs::path& file) {
  std::ifstream in(file);
  const Json json = Json::parse(in, nullptr, false);
  return json.is_discarded() ? Json() : json;
}

/// Writes what the folder lacks of the scene. Returns the number of faces.
std::size_t complete_scene(const SceneSize& size, const fs::path& folder) {
  fs::create_directories(folder / "sparse");
  fs::create_directories(folder / "images");
  const synth::CityOptions options = city_of(size);
  const synth::SynthScene city = synth::make_city(options);
  Scene scene;
  scene.views = synth::synth_flight(options.flight);
  const std::vector<ViewId> all = all_views(scene);
  io::write_scene(io::SceneTarget::colmap, scene, all, io::photo_places(io::SceneTarget::colmap, scene, all), folder);
  synth::write_synth_mesh(folder / "mesh.ply", city.mesh, {});
  take_photos(city, scene.views, folder / "images");
  return city.mesh.faces.size();
}

}  // namespace

std::string name_of(const SceneSize& size) {
  return fmt::format("{}-photos-{}-faces-{}x{}{}", size.photos, size.faces, size.width, size.height,
                     size.nadir ? "-nadir" : "");
}

SceneFiles make_scene(const SceneSize& size, const fs::path& scenes) {
  const fs::path folder = scenes / name_of(size);
  const fs::path started = folder / "recipe.json", completed = folder / "complete.json";  // written first and last
  if (read_json(started) != recipe(size)) {
    fs::remove_all(folder);
    fs::create_directories(folder);
    write_text(started, recipe(size).dump(1) + "\n");
  }
  Json made = read_json(completed);
  if (!made.contains("faces")) {
    fmt::print(stderr, "making {}\n", folder.string());
    made = {{"faces", std::stoull(in_own_process([&] { return std::to_string(complete_scene(size, folder)); }))}};
    write_text(completed, made.dump(1) + "\n");
  }
  return {folder, folder / "mesh.ply", made["faces"].get<std::size_t>()};
}

}  // namespace gpvc::scaling
