#include "app/checks/hypotheses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "app/checks/frame_check.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

/// What a hypothesis changes: some faces of the mesh, the views and their photos.
struct Trial {
  Mesh mesh;
  Scene scene;
  std::vector<SmallPhoto> photos;
};

struct Hypothesis {
  std::string name;  ///< completes "with ..."
  std::function<void(Trial&)> apply;
};

Hypothesis moved_points(std::string name, std::function<WorldPoint(const WorldPoint&)> move) {
  return {std::move(name), [move = std::move(move)](Trial& trial) {
            for (WorldPoint& p : trial.mesh.positions) p = move(p);
          }};
}

/// Fronts stay fronts.
Hypothesis mirrored_points(std::string name, std::function<WorldPoint(const WorldPoint&)> move) {
  Hypothesis moved = moved_points(std::move(name), std::move(move));
  return {moved.name, [apply = moved.apply](Trial& trial) {
            apply(trial);
            for (Triangle& face : trial.mesh.faces) std::swap(face[1], face[2]);
          }};
}

Hypothesis changed_views(std::string name, std::function<void(View&)> change) {
  return {std::move(name), [change = std::move(change)](Trial& trial) {
            for (View& view : trial.scene.views) change(view);
          }};
}

Hypothesis changed_photos(std::string name, SmallPhoto (*change)(SmallPhoto)) {
  return {std::move(name), [change](Trial& trial) {
            for (SmallPhoto& photo : trial.photos) photo = change(std::move(photo));
          }};
}

/// The used views take the photos of those that `order` puts in their places.
Hypothesis ordered_photos(std::string name, std::span<const ViewId> views,
                          std::function<void(std::vector<ViewId>&)> order) {
  return {std::move(name), [views, order = std::move(order)](Trial& trial) {
            std::vector<ViewId> from(views.begin(), views.end());
            order(from);
            std::vector<SmallPhoto> photos(trial.photos.size());
            for (std::size_t i = 0; i < from.size(); ++i) photos[index(views[i])] = trial.photos[index(from[i])];
            trial.photos = std::move(photos);
          }};
}

/// About the optical axis, by a quarter turn.
void turn(View& view) {
  auto& r = view.pose.rotation;
  for (std::size_t i = 0; i < 3; ++i) r[i] = -std::exchange(r[i + 3], r[i]);
}

/// x_camera = rotation * x_world + t turns into x_world = rotation * x_camera + t.
void invert(View& view) {
  const CameraPoint minus_t = camera_from_world({view.pose.rotation, {}}, view.pose.centre);
  auto& r = view.pose.rotation;
  std::swap(r[1], r[3]);
  std::swap(r[2], r[6]);
  std::swap(r[5], r[7]);
  view.pose.centre = {-minus_t.x, -minus_t.y, -minus_t.z};
}

std::vector<Hypothesis> hypotheses(std::span<const ViewId> views) {
  std::vector<Hypothesis> all;
  all.push_back(ordered_photos("each photo at the pose of the one before", views,
                               [](auto& v) { std::rotate(v.begin(), v.begin() + 1, v.end()); }));
  all.push_back(ordered_photos("each photo at the pose of the one after it", views,
                               [](auto& v) { std::rotate(v.begin(), v.end() - 1, v.end()); }));
  all.push_back(
      ordered_photos("the photos in reverse order", views, [](auto& v) { std::reverse(v.begin(), v.end()); }));
  all.push_back(changed_photos("the photos turned by 180 degrees", turned_over));
  all.push_back(changed_photos("the photos mirrored", mirrored));
  for (int quarters = 1; quarters < 4; ++quarters)
    all.push_back(changed_views(fmt::format("the cameras turned by {} degrees about their axes", 90 * quarters),
                                [quarters](View& view) {
                                  for (int i = 0; i < quarters; ++i) turn(view);
                                }));
  all.push_back(changed_views("the poses inverted", invert));
  all.push_back(changed_views("the cameras' y and z axes turned round", [](View& view) {
    for (std::size_t i = 3; i < 9; ++i) view.pose.rotation[i] = -view.pose.rotation[i];
  }));
  all.push_back(changed_views("a lens without distortion", [](View& view) { view.camera.distortion = {}; }));
  using P = WorldPoint;
  all.push_back(moved_points("the mesh's y as z", [](const P& p) { return P{p.x, -p.z, p.y}; }));
  all.push_back(moved_points("the mesh's z as y", [](const P& p) { return P{p.x, p.z, -p.y}; }));
  all.push_back(mirrored_points("the mesh's x mirrored", [](const P& p) { return P{-p.x, p.y, p.z}; }));
  all.push_back(mirrored_points("the mesh's y mirrored", [](const P& p) { return P{p.x, -p.y, p.z}; }));
  all.push_back(mirrored_points("the mesh's z mirrored", [](const P& p) { return P{p.x, p.y, -p.z}; }));
  constexpr double kFoot = 0.3048;
  for (const double scale : {0.001, 0.01, 0.1, kFoot, 1 / kFoot, 10.0, 100.0, 1000.0})
    all.push_back(moved_points(fmt::format("the mesh scaled by {:.4g}", scale), [scale](const P& p) {
      return P{scale * p.x, scale * p.y, scale * p.z};
    }));
  return all;
}

/// True if the mesh is half as large as a photo is wide, as what people photograph is. A mesh of a tenth of its size about a
/// point on the ground lies where photos show it, too.
bool fills_photos(const Trial& trial, std::span<const ViewId> views) {
  const std::vector<double> pixel = sampling_distances(trial.mesh, trial.scene, views, 200);
  const Box box = box_of(trial.mesh);
  return !pixel.empty() &&
         length(box.high - box.low) > pixel[pixel.size() / 2] * trial.scene.views[index(views[0])].camera.width / 2;
}

MeshFit fit_of(const Trial& trial) {
  return measure_fit(trial.mesh, trial.scene, trial.photos, framed_places(trial.mesh, trial.scene, trial.photos));
}

/// What a hypothesis comes to.
struct Explanation {
  std::string name;
  MeshFit fit;
};

/// A principal point that is stated in pixels belongs to the photo's size too; one that readers put into the middle does not.
void resize(double factor, Camera& camera) {
  camera.fx *= factor;
  camera.fy *= factor;
  const auto from_middle = [&](double by) {
    return std::hypot(by * camera.cx - camera.width / 2.0, by * camera.cy - camera.height / 2.0);
  };
  if (from_middle(factor) >= from_middle(1)) return;
  camera.cx *= factor;
  camera.cy *= factor;
}

/// Photos that were reduced since they were aligned: files that do not state their size (NVM, Bundler) then have focal
/// lengths of too many pixels, by any factor. Photos agree about surfaces off the mesh where the factor is nearly right.
Explanation other_focal_length(const Trial& given, results::Observer& observer) {
  // A mesh that lies a little too far or too near looks like a focal length that is a little wrong.
  const auto is_near_one = [](double factor) { return factor > 0.9 && factor < 1.1; };
  Trial trial = given;
  const auto fit_at = [&](double factor) -> MeshFit {
    observer.check_cancelled();
    if (is_near_one(factor)) return {};
    for (std::size_t v = 0; v < trial.scene.views.size(); ++v) {
      trial.scene.views[v].camera = given.scene.views[v].camera;
      resize(factor, trial.scene.views[v].camera);
    }
    return fit_of(trial);
  };
  // An error of 3 % moves what photos show by 15 of 500 pixels from the middle, of which surfaces are looked for along 24
  // either way; one of a quarter of a percent moves it by the pixel that counts as on the mesh.
  constexpr double kCoarse = 1.06, kFine = 1.005;
  // From photos reduced to a sixth to photos of twice the size, and a step more.
  constexpr double kLeast = 1.0 / 6, kMost = 2 * kCoarse;
  // A principal point that is off by more than a pixel or two hides what a nearly right focal length would show, so that
  // photos whose file states one are only found where they were halved, say.
  std::vector<double> factors{1.0 / 4, 1.0 / 3, 1.0 / 2, 2};
  for (double factor = kLeast; factor <= kMost; factor *= kCoarse) factors.push_back(factor);
  double near = 1;
  MeshFit found;
  for (const double factor : factors)
    if (const MeshFit fit = fit_at(factor); fit.verdict != MeshFit::Verdict::unknown && fit.found > found.found) {
      found = fit;
      near = factor;
    }
  if (found.found == 0) return {};
  Explanation best;
  for (double factor = near / kCoarse; factor <= near * kCoarse; factor *= kFine)
    if (const MeshFit fit = fit_at(factor); places_on_mesh(fit) > places_on_mesh(best.fit))
      best = {fmt::format(
                  "focal lengths times {:.3f} (were the photos {} since they were aligned, or does the mesh lie too "
                  "{} the cameras?)",
                  factor, factor < 1 ? "reduced" : "enlarged", factor < 1 ? "near" : "far from"),
              fit};
  return best;
}

Trial unchanged(const Input& input, std::span<const SmallPhoto> photos) {
  constexpr std::size_t kFaces = 2048;
  return {some_faces(input.mesh, kFaces), input.scene, {photos.begin(), photos.end()}};
}

}  // namespace

MeshFit framed_fit(const Input& input, std::span<const SmallPhoto> photos) { return fit_of(unchanged(input, photos)); }

std::string fitting_hypothesis(const Input& input, std::span<const SmallPhoto> photos, results::Observer& observer,
                               double clearly) {
  const Trial given = unchanged(input, photos);
  const MeshFit before = fit_of(given);
  Explanation best;
  // Hidden faces lie behind what photos show. A mesh that shrinks to a point on the ground has few surfaces to compare.
  const auto offer = [&](const Explanation& one, const Trial& trial) {
    if (one.name.empty()) return;
    observer.detail(
        fmt::format("  with {} photos agree about a surface at {} of {} places, {:.0f} % of these lie on the mesh",
                    one.name, one.fit.found, one.fit.places, 100 * one.fit.share));
    if (one.fit.verdict != MeshFit::Verdict::unknown && one.fit.share >= 0.5 && fills_photos(trial, input.views) &&
        2 * one.fit.places >= before.places && places_on_mesh(one.fit) > places_on_mesh(best.fit))
      best = one;
  };
  // Some hypotheses leave a level ground where it is.
  const auto explains = [&] {
    return !best.name.empty() && places_on_mesh(best.fit) >= clearly * std::max(1.0, places_on_mesh(before));
  };
  for (const Hypothesis& hypothesis : hypotheses(input.views)) {
    observer.check_cancelled();
    Trial trial = given;
    hypothesis.apply(trial);
    offer({hypothesis.name, fit_of(trial)}, trial);
  }
  if (!explains()) offer(other_focal_length(given, observer), given);
  if (!explains()) return {};
  return fmt::format("with {} they would agree on the mesh at {:.0f} places instead of {:.0f}", best.name,
                     places_on_mesh(best.fit), places_on_mesh(before));
}

}  // namespace gpvc::checks
