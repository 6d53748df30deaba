// Mistakes of poses, lenses and meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include "benchmarks/wrong_scenes.h"
#include "io/box.h"
#include "io/vector.h"

namespace gpvc {
namespace {

// --- mistakes of poses and lenses

using Order = std::vector<std::size_t>;

/// Photos get the poses and cameras of others, in an order that `change` makes of their own.
void exchange_poses(Scene& scene, void (*change)(Order&)) {
  Order from(scene.views.size());
  std::iota(from.begin(), from.end(), std::size_t{0});
  change(from);
  const std::vector<View> right = scene.views;
  for (std::size_t i = 0; i < from.size(); ++i) {
    scene.views[i].pose = right[from[i]].pose;
    scene.views[i].camera = right[from[i]].camera;
  }
}

/// Every photo gets another's pose.
void shuffle(Order& order) {
  std::mt19937 random(1);
  // Sattolo 1986: one cycle through all, so that none stays in its place.
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random() % i]);
}

/// About the optical axis: what a photo stored upside down comes to.
void turn_over(View& view) {
  for (std::size_t i = 0; i < 6; ++i) view.pose.rotation[i] = -view.pose.rotation[i];
}

/// Camera-to-world taken for world-to-camera.
void invert(Pose& pose) {
  const std::array<double, 9> r = pose.rotation;
  const WorldPoint c = pose.centre;
  pose.rotation = {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]};
  pose.centre = {-(r[0] * c.x + r[1] * c.y + r[2] * c.z), -(r[3] * c.x + r[4] * c.y + r[5] * c.z),
                 -(r[6] * c.x + r[7] * c.y + r[8] * c.z)};
}

Mistake of_order(const char* name, void (*change)(Order&)) {
  return {name, [change](Input& in) { exchange_poses(in.scene, change); }};
}

Mistake of_views(const char* name, void (*spoil)(View&)) {
  return {name, [spoil](Input& in) { std::ranges::for_each(in.scene.views, spoil); }};
}

Mistake of_lens(const char* name, void (*spoil)(Camera&)) {
  return {name,
          [spoil](Input& in) {
            for (View& view : in.scene.views) {
              spoil(view.camera);
              limit_distortion(view.camera);
            }
          },
          true};
}

// --- mistakes of meshes

/// `move` takes a position less the box's middle to what the mesh has instead.
Mistake about_middle(const char* name, WorldPoint (*move)(const WorldPoint& p, double extent),
                     bool turns_faces = false) {
  return {name,
          [=](Input& in) {
            const Box box = box_of(in.mesh);
            const WorldPoint middle = 0.5 * (box.low + box.high);
            const double extent = extent_of(in.mesh);
            for (WorldPoint& p : in.mesh.positions) p = middle + move(p - middle, extent);
            if (turns_faces)
              for (Triangle& t : in.mesh.faces) std::swap(t[1], t[2]);
          },
          true};
}

Mistake about_origin(const char* name, WorldPoint (*move)(const WorldPoint& p)) {
  return {name, [=](Input& in) { std::ranges::transform(in.mesh.positions, in.mesh.positions.begin(), move); }, true};
}

WorldPoint turned_about_z(const WorldPoint& p, double degrees) {
  const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
  return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
}

WorldPoint turned_about_x(const WorldPoint& p, double degrees) {
  const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
  return {p.x, c * p.y - s * p.z, s * p.y + c * p.z};
}

Mistake moved(const char* name, double x, double z) {
  return {name,
          [=](Input& in) {
            const double extent = extent_of(in.mesh);
            for (WorldPoint& p : in.mesh.positions) p = p + WorldPoint{x * extent, 0, z * extent};
          },
          true};
}

/// Every other view, as if two cameras had taken turns.
Mistake of_one_camera_of_two(const char* name, void (*spoil)(Camera&)) {
  return {name,
          [spoil](Input& in) {
            for (std::size_t v = 0; v < in.scene.views.size(); v += 2) {
              spoil(in.scene.views[v].camera);
              limit_distortion(in.scene.views[v].camera);
            }
          },
          true};
}

}  // namespace

double extent_of(const Mesh& mesh) {
  const auto [low, high] = box_of(mesh);
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

std::vector<Mistake> mistakes_of_views() {
  return {
      of_order("photos in random order", shuffle),
      of_order("photos in reverse order", [](Order& order) { std::ranges::reverse(order); }),
      of_order("photos moved by one", [](Order& order) { std::rotate(order.begin(), order.begin() + 1, order.end()); }),
      of_order("two photos swapped", [](Order& order) { std::swap(order[0], order[order.size() / 2]); }),
      {"one photo turned by 180 degrees", [](Input& in) { turn_over(in.scene.views[in.scene.views.size() / 2]); }},
      of_views("all photos turned by 180 degrees", turn_over),
      {"all cameras at one pose",
       [](Input& in) {
         for (View& view : in.scene.views) view.pose = in.scene.views[0].pose;
       }},
      of_views("poses inverted", [](View& view) { invert(view.pose); }),
      of_lens("k1 = -5", [](Camera& c) { c.distortion.k1 = -5; }),
      of_lens("focal length a fifth too long", [](Camera& c) { c.fx *= 1.2, c.fy *= 1.2; }),
      of_lens("focal length of photos twice as large", [](Camera& c) { c.fx *= 2, c.fy *= 2; }),
      {"one pose 2 % of the mesh's size to the side",
       [](Input& in) { in.scene.views[in.scene.views.size() / 2].pose.centre.x += 0.02 * extent_of(in.mesh); }},
      of_views("cameras' y and z axes turned round",
               [](View& view) {
                 for (std::size_t i = 3; i < 9; ++i) view.pose.rotation[i] = -view.pose.rotation[i];
               }),
      of_views("all photos turned by 90 degrees",
               [](View& view) {
                 auto& r = view.pose.rotation;
                 for (std::size_t i = 0; i < 3; ++i) r[i] = -std::exchange(r[i + 3], r[i]);
               }),
      of_lens("focal length of photos half as large", [](Camera& c) { c.fx *= 0.5, c.fy *= 0.5; }),
      of_lens("focal length 5 % too long", [](Camera& c) { c.fx *= 1.05, c.fy *= 1.05; }),
      of_lens("pixels 5 % higher than wide", [](Camera& c) { c.fy *= 1.05; }),
      of_lens("principal point 1 % of the width to the right", [](Camera& c) { c.cx += 0.01 * c.width; }),
      of_lens("principal point 3 % of the width lower", [](Camera& c) { c.cy += 0.03 * c.width; }),
      of_one_camera_of_two("one camera of two with another focal length", [](Camera& c) { c.fx *= 1.2, c.fy *= 1.2; }),
      of_one_camera_of_two("one camera of two with the principal point 2 % of the width to the left",
                           [](Camera& c) { c.cx -= 0.02 * c.width; }),
  };
}

std::vector<Mistake> mistakes_of_meshes() {
  using P = WorldPoint;
  return {
      about_middle("mesh 5 % of its size to the side",
                   [](const P& p, double e) {
                     return p + P{0.05 * e, 0, 0};
                   }),
      about_middle("mesh 5 % of its size higher",
                   [](const P& p, double e) {
                     return p + P{0, 0, 0.05 * e};
                   }),
      about_middle("mesh 1.05 times as large, about its middle", [](const P& p, double) { return 1.05 * p; }),
      about_middle("mesh turned by 10 degrees about z", [](const P& p, double) { return turned_about_z(p, 10); }),
      about_middle("mesh turned by 10 degrees about x", [](const P& p, double) { return turned_about_x(p, 10); }),
      about_middle(
          "mesh mirrored",
          [](const P& p, double) {
            return P{-p.x, p.y, p.z};
          },
          true),
      about_origin("mesh 1.05 times as large, about the origin", [](const P& p) { return 1.05 * p; }),
      about_origin("mesh in feet", [](const P& p) { return (1 / 0.3048) * p; }),
      about_origin("mesh's y and z exchanged",
                   [](const P& p) {
                     return P{p.x, -p.z, p.y};
                   }),
      about_origin("mesh a millionth as large", [](const P& p) { return 1e-6 * p; }),
      moved("mesh 1.5 % of its size to the side", 0.015, 0),
      moved("mesh 45 % of its size lower, as heights above the geoid are", 0, -0.45),
      about_middle("mesh turned by 180 degrees about z", [](const P& p, double) { return turned_about_z(p, 180); }),
      about_middle(
          "mesh upside down",
          [](const P& p, double) {
            return P{p.x, p.y, -p.z};
          },
          true),
      about_origin("mesh in millimetres", [](const P& p) { return 1000.0 * p; }),
  };
}

}  // namespace gpvc
