#include "app/checks/frame_check.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "app/checks/coarse_depths.h"
#include "app/results/observer.h"
#include "io/error.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

bool any_framed(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used) {
  std::atomic<bool> found{false};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.faces.size(), FaceRuns::kRun),
                    [&](const tbb::blocked_range<std::size_t>& run) {
                      if (found) return;
                      const auto hull = corners(box_of_faces(mesh, run.begin(), run.end()));
                      for (const ViewId id : used) {
                        const View& view = scene.views[index(id)];
                        if (!hull_may_be_framed(view, hull)) continue;
                        for (std::size_t f = run.begin(); f != run.end() && !found; ++f)
                          if (may_be_framed(view, mesh, mesh.faces[f])) found = true;
                      }
                    });
  return found;
}

// A sample of the used views whose cameras are known: at least four, and no more than keep the work small compared with
// reading the mesh.
std::vector<ViewId> some_views(const Scene& scene, std::span<const ViewId> used, std::size_t faces) {
  std::vector<ViewId> known;
  for (const ViewId id : used) {
    const Camera& camera = scene.views[index(id)].camera;
    if (camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0) known.push_back(id);
  }
  constexpr std::size_t kFacesInAll = 4000000, kFewest = 4, kMost = 64;
  const std::size_t count =
      std::min(known.size(), std::clamp(kFacesInAll / std::max<std::size_t>(1, faces), kFewest, kMost));
  std::vector<ViewId> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(known[i * known.size() / count]);
  return some;
}

/// Every so many of `count` things are looked at from each view: `most` of them, or fewer where there are many views.
std::size_t sample_step(std::size_t count, std::size_t views, std::size_t most) {
  // So many numbers are 32 MB and take a second.
  constexpr std::size_t kLooks = 4000000;
  most = std::clamp<std::size_t>(kLooks / std::max<std::size_t>(1, views), 1, most);
  return std::max<std::size_t>(1, count / most);
}

/// The share of a photo's area that some ray reaches. Fisheyes leave corners dark, and so count as whole.
double reached_share(const Camera& camera) {
  const LensModel lens = camera.distortion.model;
  if (camera.width == 0 || (lens != LensModel::brown && lens != LensModel::perspective)) return 1;
  constexpr int kSteps = 16;
  int reached = 0;
  for (int y = 0; y < kSteps; ++y)
    for (int x = 0; x < kSteps; ++x)
      reached +=
          pixel_from_photo(camera, {(x + 0.5) / kSteps * camera.width, (y + 0.5) / kSteps * camera.height}) ? 1 : 0;
  return static_cast<double>(reached) / (kSteps * kSteps);
}

}  // namespace

Box box_of(const Scene& scene) {
  Box box;
  for (const View& view : scene.views) box.add(view.pose.centre);
  return box;
}

std::string box_text(const Box& b) {
  return fmt::format("x {:.3f} .. {:.3f}, y {:.3f} .. {:.3f}, z {:.3f} .. {:.3f}", b.low.x, b.high.x, b.low.y, b.high.y,
                     b.low.z, b.high.z);
}

void check_frames(const Mesh& mesh, const std::filesystem::path& mesh_file, const Scene& scene,
                  std::span<const ViewId> used) {
  if (used.empty() || any_framed(mesh, scene, used)) return;
  const auto hull = corners(box_of(mesh));
  const bool behind = std::all_of(used.begin(), used.end(), [&](ViewId id) {
    return std::none_of(hull.begin(), hull.end(),
                        [&](const WorldPoint& p) { return camera_from_world(scene.views[index(id)].pose, p).z > 0; });
  });
  std::string text = fmt::format("no photo sees any face, the mesh lies {}: it spans {}, the cameras {}",
                                 behind ? "behind every camera" : "outside every frame", box_text(box_of(mesh)),
                                 box_text(box_of(scene)));
  const WorldPoint& o = scene.offset;
  if (!(o == WorldPoint{}))
    text += fmt::format(" (which is {} less {} {} {})", scene.srs.empty() ? "their system" : scene.srs, o.x, o.y, o.z);
  else if (!scene.srs.empty())
    text += fmt::format(" (in {})", scene.srs);
  throw InputError(mesh_file, "", text + "; expected both in the same coordinates");
}

double framed_share(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used) {
  constexpr std::size_t kFaces = 100000;
  const std::size_t step = std::max<std::size_t>(1, mesh.faces.size() / kFaces);
  const std::size_t count = (mesh.faces.size() + step - 1) / step;
  const std::size_t framed = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count), std::size_t{0},
      [&](const tbb::blocked_range<std::size_t>& range, std::size_t sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          sum += std::any_of(used.begin(), used.end(), [&](ViewId id) {
            return may_be_framed(scene.views[index(id)], mesh, mesh.faces[i * step]);
          });
        return sum;
      },
      std::plus<>());
  return count == 0 ? 0 : static_cast<double>(framed) / static_cast<double>(count);
}

namespace {

/// For each face of a sample, the places in `used` of the views that may frame it and stand on its front side.
std::vector<std::vector<std::uint32_t>> possible_views(const Mesh& mesh, const Scene& scene,
                                                       std::span<const ViewId> used) {
  const std::size_t step = sample_step(mesh.faces.size(), used.size(), 20000);
  std::vector<std::vector<std::uint32_t>> views_of((mesh.faces.size() + step - 1) / step);
  tbb::parallel_for(std::size_t{0}, views_of.size(), [&](std::size_t i) {
    const Triangle& face = mesh.faces[i * step];
    const WorldPoint& a = mesh.positions[face[0]];
    const WorldPoint normal = cross(mesh.positions[face[1]] - a, mesh.positions[face[2]] - a);
    for (std::uint32_t n = 0; n < used.size(); ++n) {
      const View& view = scene.views[index(used[n])];
      if (dot(normal, view.pose.centre - a) > 0 && may_be_framed(view, mesh, face)) views_of[i].push_back(n);
    }
  });
  return views_of;
}

}  // namespace

std::vector<std::size_t> overlap(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used) {
  std::vector<std::size_t> counts;
  for (const auto& views : possible_views(mesh, scene, used)) counts.push_back(views.size());
  std::ranges::sort(counts);
  return counts;
}

std::vector<ViewId> few_views(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used, int times) {
  const std::vector<std::vector<std::uint32_t>> views_of = possible_views(mesh, scene, used);
  std::vector<std::vector<std::uint32_t>> faces_of(used.size());
  for (std::uint32_t f = 0; f < views_of.size(); ++f)
    for (const std::uint32_t n : views_of[f]) faces_of[n].push_back(f);
  // A view gains the faces that are not shown often enough. Each face tells all of its views once it is.
  std::vector<int> missing(views_of.size(), times);
  std::vector<std::size_t> gains;
  for (const auto& faces : faces_of) gains.push_back(faces.size());
  std::vector<ViewId> few;
  while (!gains.empty()) {
    const auto best = std::ranges::max_element(gains);
    if (*best <= views_of.size() / 200) break;
    const auto chosen = static_cast<std::size_t>(best - gains.begin());
    few.push_back(used[chosen]);
    for (const std::uint32_t f : faces_of[chosen])
      if (--missing[f] == 0)
        for (const std::uint32_t n : views_of[f])
          if (gains[n] > 0) --gains[n];
    gains[chosen] = 0;
  }
  std::ranges::sort(few);
  return few;
}

std::optional<Backs> back_share(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used) {
  const std::vector<ViewId> views = some_views(scene, used, mesh.faces.size());
  const FaceRuns runs(mesh);
  std::atomic<std::size_t> rays{0}, seen{0}, backs{0};
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t n) {
    const CoarseDepths coarse = draw_coarse_depths(mesh, runs, scene.views[index(views[n])]);
    rays += coarse.depths.size();
    seen += static_cast<std::size_t>(
        std::ranges::count_if(coarse.depths, [](float depth) { return std::isfinite(depth); }));
    backs += static_cast<std::size_t>(std::ranges::count(coarse.backs, true));
  });
  if (seen == 0) return {};
  const auto hits = static_cast<double>(seen);
  return Backs{static_cast<double>(backs) / hits, hits / static_cast<double>(rays)};
}

std::string check_winding(std::optional<Backs> backs, const std::filesystem::path& mesh_file) {
  // A correctly oriented mesh shows backs only where it is open: through holes, at its rim, on single sheets. Scans from
  // photos showed none, synthetic walls with slits 3.5 %. Above nine tenths hardly any face would get a photo.
  constexpr double kInsideOut = 0.9, kSuspect = 0.2;
  if (!backs || backs->share < kSuspect) return {};
  const std::string share =
      fmt::format("{:.0f} % of what the cameras see of it are backs of faces", 100 * backs->share);
  constexpr const char* kExpected =
      "expected corners counter-clockwise seen from outside (turn the faces over when exporting)";
  // A mesh of the ground that was made of the photos fills most of them.
  constexpr double kOwn = 0.5;
  if (backs->share > kInsideOut && backs->covered < kOwn)
    throw InputError(mesh_file, "",
                     fmt::format("the mesh fills {:.0f} % of the photos, and {}: is it another scene's, in other "
                                 "coordinates, or turned over?",
                                 100 * backs->covered, share));
  if (backs->share > kInsideOut)
    throw InputError(
        mesh_file, "",
        fmt::format("the mesh looks inside out, or the cameras stand behind its surface: {}; {}", share, kExpected));
  return fmt::format("{}: parts of the mesh look inside out: {}, which get no photo; {}", mesh_file.string(), share,
                     kExpected);
}

std::vector<double> sampling_distances(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used,
                                       std::size_t most) {
  const std::size_t step = sample_step(mesh.positions.size(), used.size(), most);
  std::vector<double> sampling;
  for (std::size_t v = 0; v < mesh.positions.size(); v += step)
    for (const ViewId id : used) {
      const View& view = scene.views[index(id)];
      const CameraPoint c = camera_from_world(view.pose, mesh.positions[v]);
      if (c.z > 0 && view.camera.width > 0 && in_photo(view.camera, pixel_from_camera(view.camera, c)))
        sampling.push_back(c.z / view.camera.fx);
    }
  std::ranges::sort(sampling);
  return sampling;
}

std::string check_scale(const Mesh& mesh, std::span<const double> sampling, const std::filesystem::path& mesh_file) {
  if (sampling.empty()) return {};
  const double pixel = sampling[sampling.size() / 2];
  const Box box = box_of(mesh);
  const double extent = std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
  // Smaller than the icon of a program: no photo is taken of that.
  constexpr double kLeastPixels = 16;
  if (extent < kLeastPixels * pixel)
    throw InputError(
        mesh_file, "",
        fmt::format("the whole mesh is {:.3g} pixels large in the photos: are its units those of the cameras? "
                    "It spans {}",
                    extent / pixel, box_text(box)));
  const auto is_float = [](double v) { return static_cast<double>(static_cast<float>(v)) == v; };
  double largest = 0;
  for (const WorldPoint& p : mesh.written_positions()) {
    if (!is_float(p.x) || !is_float(p.y) || !is_float(p.z)) return {};
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  const auto top = static_cast<float>(largest);
  const double spacing = static_cast<double>(std::nextafter(top, std::numeric_limits<float>::infinity()) - top);
  // Rounding moves a vertex by half of that at most: by as much as good camera poses are off, half a pixel.
  if (spacing < pixel) return {};
  return fmt::format(
      "{}: positions are rounded to {:.3g} units, {:.1f} pixels of the photos, as float numbers of such "
      "coordinates are; export the mesh with double precision, or in local coordinates",
      mesh_file.string(), spacing, spacing / pixel);
}

std::string check_lenses(const Scene& scene, std::span<const ViewId> used) {
  // Of real lenses that are fitted this way the last few pixels of the corners may be out of reach.
  constexpr double kMostUnreached = 0.1;
  std::vector<std::string> names;
  double least = 1;
  const Camera* last = nullptr;
  double reached = 1;
  for (const ViewId id : used) {
    const View& view = scene.views[index(id)];
    if (last == nullptr || !(*last == view.camera)) reached = reached_share(view.camera);
    last = &view.camera;
    if (reached > 1 - kMostUnreached) continue;
    names.push_back(view.name);
    least = std::min(least, reached);
  }
  if (names.empty()) return {};
  return fmt::format(
      "{} of {} photos have a lens whose terms describe only a part of them, {:.0f} % of the least ({}): beyond it "
      "they "
      "fold back on themselves, and the rest is not used; are they those of these photos?",
      names.size(), used.size(), 100 * least, results::readable_list(names, 3));
}

}  // namespace gpvc::checks
