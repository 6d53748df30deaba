#include "io/bands/band_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "io/bands/band_files.h"
#include "io/files/text_scan.h"
#include "io/order_statistics.h"
#include "io/scenes/bad_photos.h"
#include "io/scenes/photo_index.h"
#include "io/vector.h"

namespace gpvc::io {
namespace {

using Views = std::map<int, std::size_t>;  ///< of a photo's bands, by order

/// Of one photo: what its bands' files have in common.
std::string group_of(const fs::path& photo, const BandFileName& name) {
  const fs::path folder = name.by_folder ? folder_of(folder_of(photo)) : folder_of(photo);
  return (real_path(folder) / name.group).string();
}

/// x_file = rotation * x_photo + shift, in the axes of two cameras.
BandCamera band_camera(const View& photo, const View& file) {
  BandCamera band{photo.camera, file.camera, {}, {}};
  const auto &from = photo.pose.rotation, &to = file.pose.rotation;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      band.file_from_photo[3 * row + column] = to[3 * row] * from[3 * column] + to[3 * row + 1] * from[3 * column + 1] +
                                               to[3 * row + 2] * from[3 * column + 2];
  const CameraPoint centre = camera_from_world(file.pose, photo.pose.centre);
  band.shift = {centre.x, centre.y, centre.z};
  return band;
}

double distance(const View& a, const View& b) { return length(a.pose.centre - b.pose.centre); }

bool has_same_camera(const View& a, const View& b) {
  return a.camera == b.camera && a.pose.rotation == b.pose.rotation && distance(a, b) == 0;
}

double median(std::vector<double> values) { return upper_median(std::span(values)); }

class Joiner {
 public:
  Joiner(SceneFile& scene, std::vector<bool>& needed) : scene_(scene), needed_(needed) {}

  void join() {
    if (!find_groups() || !are_most()) return;
    if (!lie_together()) return;
    leave_out_misfits();
    if (orders_.size() < 2) return;
    find_rig();
    std::vector<bool> out(scene_.views.size(), false);
    std::size_t without = 0;
    for (const auto& [key, views] : groups_) {
      const auto primary = views.find(primary_);
      without += primary == views.end() ? 1 : 0;
      for (const auto& [order, view] : views) out[view] = order != primary_;
      if (primary != views.end()) give_files(primary->second, views);
    }
    scene_.warn(without,
                "photos are left out of which the scene has no camera of the band " + quote(band_name(primary_)));
    for (const auto& [order, name] : orders_) scene_.band_names.push_back(name.band);
    cut(out);
  }

 private:
  const View& view(std::size_t i) const { return scene_.views[i]; }
  std::string band_name(int order) const { return BandMember{names_.at(order), {}}.band(); }

  /// False where there are none, or two views are one band of one photo.
  bool find_groups() {
    std::map<int, std::size_t> count;
    for (std::size_t i = 0; i < scene_.views.size(); ++i) {
      if (view(i).photo.empty() || !view(i).band_files.empty() || is_spherical(view(i).camera.distortion.model))
        continue;
      const std::optional<BandFileName> name = band_file_name(view(i).photo);
      if (!name) continue;
      if (!groups_[group_of(view(i).photo, *name)].emplace(name->order, i).second) return false;
      names_.emplace(name->order, *name);
      ++count[name->order];
    }
    if (count.size() < 2) return false;
    orders_ = names_;
    const auto more = [](const auto& a, const auto& b) { return a.second < b.second; };
    primary_ = std::ranges::max_element(count, more)->first;
    return true;
  }

  /// True if most views that need their photo belong to photos that are there and have several bands.
  bool are_most() const {
    std::size_t wanting = 0, grouped = 0;
    for (std::size_t i = 0; i < scene_.views.size(); ++i) wanting += needed_[i] && !view(i).photo.empty() ? 1 : 0;
    for (const auto& [key, views] : groups_) {
      const auto primary = views.find(primary_);
      if (views.size() < 2 || primary == views.end() || !needed_[primary->second]) continue;
      for (const auto& [order, i] : views) grouped += needed_[i] ? 1 : 0;
    }
    return grouped > 0 && 2 * grouped >= wanting;
  }

  bool lie_together() {
    std::vector<double> within, between;
    std::vector<std::size_t> primaries;
    for (const auto& [key, views] : groups_) {
      const auto primary = views.find(primary_);
      if (primary == views.end()) continue;
      double most = 0;
      for (const auto& [order, i] : views) {
        most = std::max(most, distance(view(i), view(primary->second)));
        copied_ = copied_ && has_same_camera(view(i), view(primary->second));
      }
      if (views.size() > 1) within.push_back(most);
      primaries.push_back(primary->second);
    }
    if (copied_) return true;
    constexpr std::size_t kMost = 300;  // whose neighbours are looked for
    for (std::size_t n = 0; n < primaries.size() && primaries.size() > 1; n += 1 + primaries.size() / kMost) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const std::size_t other : primaries)
        if (other != primaries[n]) nearest = std::min(nearest, distance(view(primaries[n]), view(other)));
      between.push_back(nearest);
    }
    constexpr double kTogether = 0.2;
    if (!between.empty() && median(within) <= kTogether * median(between)) return true;
    scene_.warnings.push_back(
        "bands of the same photos have cameras that lie as far apart as those of different photos: each is taken for a "
        "photo of its own, as " +
        view(groups_.begin()->second.begin()->second).photo.string());
    return false;
  }

  /// Bands that cannot be laid over the primary, of which one photo tells.
  void leave_out_misfits() {
    std::erase_if(orders_, [&](const auto& order) {
      if (order.first == primary_) return false;
      for (const auto& [key, views] : groups_) {
        const auto primary = views.find(primary_), other = views.find(order.first);
        if (primary == views.end() || other == views.end()) continue;
        const fs::path& file = view(other->second).photo;
        const std::string why = misfit_of_band(file, view(primary->second).photo);
        if (!why.empty())
          scene_.warnings.push_back("the band " + quote(band_name(order.first)) + " is left out: " + file.string() +
                                    " " + why);
        return !why.empty();
      }
      return true;  // no photo has it beside the primary
    });
  }

  void find_rig() {
    for (const auto& group : groups_) {
      const Views& views = group.second;
      const auto has = [&](const auto& order) { return views.contains(order.first); };
      if (!views.contains(primary_) || !std::ranges::all_of(orders_, has)) continue;
      for (const auto& [order, name] : orders_)
        rig_[order] = band_camera(view(views.at(primary_)), view(views.at(order)));
      return;
    }
  }

  void give_files(std::size_t primary, const Views& views) {
    View& photo = scene_.views[primary];
    std::vector<fs::path> files;
    std::vector<BandCamera> cameras;
    for (const auto& [order, name] : orders_) {
      if (const auto own = views.find(order); own != views.end()) {
        files.push_back(view(own->second).photo);
        cameras.push_back(band_camera(photo, view(own->second)));
        continue;
      }
      const std::map<int, BandMember> beside = files_.of(photo.photo);
      const auto file = beside.find(order);
      if (file == beside.end() || (!copied_ && !rig_.contains(order)))
        return forget_photo(scene_, primary, needed_[primary], BadPhoto::Problem::unreadable,
                            file == beside.end() ? "there is no file of its band " + quote(band_name(order)) + " in " +
                                                       folder_of(photo.photo).string()
                                                 : "the scene has no camera of its band " + quote(band_name(order)));
      files.push_back(file->second.file);
      if (!copied_) cameras.push_back(rig_.at(order));
    }
    photo.band_files = std::move(files);
    if (!copied_) photo.band_cameras = std::move(cameras);
  }

  void cut(const std::vector<bool>& out) {
    std::vector<View> views;
    std::vector<bool> needed;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (out[i]) continue;
      views.push_back(std::move(scene_.views[i]));
      needed.push_back(needed_[i]);
    }
    scene_.views = std::move(views);
    needed_ = std::move(needed);
  }

  SceneFile& scene_;
  std::vector<bool>& needed_;
  std::map<std::string, Views> groups_;
  std::map<int, BandFileName> names_, orders_;  ///< of all bands, and of those that are taken
  int primary_ = 0;
  bool copied_ = true;  ///< all bands have the primary's camera and pose
  std::map<int, BandCamera> rig_;
  BandGroups files_;
};

}  // namespace

void join_band_views(SceneFile& scene, std::vector<bool>& needed, const SceneOptions& options) {
  if (options.bands.empty() && options.bands_by_name && !options.bands_as_listed) Joiner(scene, needed).join();
}

}  // namespace gpvc::io
