// Scenes for the atlas tests: a mesh built in code, cameras, and photos painted by a function, written as PNG.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/sampling/sampling.h"
#include "io/mesh.h"
#include "tests/support/grid_mesh.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::atlas {

/// Colour, 0..255 a channel, of a world point.
using Albedo = std::function<Color(double x, double y)>;

/// Everything build_atlas borrows, held together. Views look straight down (-z) onto the plane z = 0 unless posed
/// otherwise.
struct AtlasScene {
  test::TemporaryFolder folder;
  Mesh mesh;
  Scene scene;
  labeling::FaceGraph graph;
  std::vector<ViewId> labels;
  std::vector<labeling::FaceTag> tags;
  labeling::CostTable candidates;
  visibility::CoverageTable coverage;
  std::vector<std::uint8_t> border;
  std::vector<ViewExposure> exposure;

  /// Adds test::grid_mesh.
  void add_plane(int columns, int rows, double cell, double z = 0) {
    io::append_mesh(mesh, test::grid_mesh(columns, rows, cell, z));
    labels.resize(mesh.faces.size(), ViewId{0});
    tags.resize(mesh.faces.size(), labeling::FaceTag::seen);
  }

  void leave_unseen(std::size_t face) {
    labels[face] = kNoView;
    tags[face] = labeling::FaceTag::unseen;
  }

  /// Camera at (x, y, height) looking down; image x runs along world x, image y against world y.
  View& add_view(double x, double y, double height, int width_px, int height_px, double focal_px) {
    View view;
    view.name = "photo" + std::to_string(scene.views.size()) + ".png";
    view.photo = folder.path() / view.name;
    view.camera = {width_px, height_px, focal_px, focal_px, width_px / 2.0, height_px / 2.0, {}};
    view.pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    view.pose.centre = {x, y, height};
    scene.views.push_back(view);
    return scene.views.back();
  }

  /// Paints view `v` as it sees the plane z = 0 (each pixel its centre), with `change` applied to the colour.
  void photograph(std::size_t v, const Albedo& albedo,
                  const std::function<Color(int x, int y, Color)>& change = nullptr) {
    const View& view = scene.views[v];
    Image image{view.camera.width, view.camera.height, 3, {}};
    image.pixels.resize(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        Color color;
        if (const auto p = pixel_from_photo(view.camera, {x + 0.5, y + 0.5})) {
          const WorldPoint w = on_ground(view, *p);
          color = albedo(w.x, w.y);
        }
        store(image.at(x, y), change ? change(x, y, color) : color);
      }
    }
    io::write_image(view.photo, image, io::ImageFormat::png, 90);
  }

  static WorldPoint on_ground(const View& view, const PixelPoint& p) {
    const auto& c = view.camera;
    const auto& r = view.pose.rotation;
    const double x = (p.x - c.cx) / c.fx, y = (p.y - c.cy) / c.fy;
    const double dx = r[0] * x + r[3] * y + r[6], dy = r[1] * x + r[4] * y + r[7], dz = r[2] * x + r[5] * y + r[8];
    const double t = -view.pose.centre.z / dz;
    return {view.pose.centre.x + t * dx, view.pose.centre.y + t * dy, 0};
  }

  TextureAtlas build(const AtlasOptions& options) {
    graph = labeling::face_graph(mesh);
    if (candidates.first.empty()) candidates.first.assign(mesh.faces.size() + 1, 0);
    io::PhotoCache photos(scene, std::size_t{1} << 30);
    return build_atlas({mesh, scene, photos, graph, labels, tags, candidates, coverage, border, exposure}, options,
                       nullptr);
  }
};

/// Bilinear lookup on a page at texture coordinates, as a renderer does it.
inline Color lookup(const Image& page, const io::TexCoord& t) {
  return sample_bilinear(page, double(t.u) * page.width, double(t.v) * page.height);
}

/// Texture coordinates of a face at barycentric coordinates.
inline io::TexCoord texcoord_at(const io::TexturedModel& model, std::size_t face, double a, double b) {
  const auto& t = model.face_texcoords[face];
  const double c = 1 - a - b;
  const auto mix = [&](auto member) {
    return static_cast<float>(a * double(model.texcoords[t[0]].*member) + b * double(model.texcoords[t[1]].*member) +
                              c * double(model.texcoords[t[2]].*member));
  };
  return {mix(&io::TexCoord::u), mix(&io::TexCoord::v)};
}

inline WorldPoint point_at(const Mesh& mesh, std::size_t face, double a, double b) {
  const auto& t = mesh.faces[face];
  const double c = 1 - a - b;
  const auto &p = mesh.positions[t[0]], &q = mesh.positions[t[1]], &r = mesh.positions[t[2]];
  return {a * p.x + b * q.x + c * r.x, a * p.y + b * q.y + c * r.y, a * p.z + b * q.z + c * r.z};
}

}  // namespace gpvc::atlas
