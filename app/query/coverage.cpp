#include "app/query/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "app/query/sharpness.h"
#include "io/grouping.h"
#include "io/photos.h"
#include "labeling/view_choice.h"
#include "visibility/visibility.h"

namespace gpvc::query {
namespace {

constexpr double kHalf = 0.5;

class Counter {
 public:
  Counter(const checks::Input& input, FaceCoverage& to)
      : input_(input), to_(to), photos_(io::photo_of_view(input.scene)), last_(input.mesh.faces.size(), kNone) {
    const float none = std::numeric_limits<float>::infinity();
    to_.photos.assign(last_.size(), 0);
    to_.gsd.assign(last_.size(), none);
    to_.angle.assign(last_.size(), none);
  }

  /// To be called view by view, in order.
  void add(ViewId view, FaceId face) {
    const std::uint32_t photo = photos_[index(view)];
    const std::size_t f = index(face);
    if (last_[f] != photo) ++to_.photos[f];
    last_[f] = photo;
    const Sharpness sharp =
        sharpness_of(input_.scene.views[index(view)], middle_of(input_.mesh, face), normal_of(input_.mesh, face));
    to_.gsd[f] = std::min(to_.gsd[f], static_cast<float>(sharp.gsd));
    to_.angle[f] = std::min(to_.angle[f], static_cast<float>(sharp.angle));
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const checks::Input& input_;
  FaceCoverage& to_;
  std::vector<std::uint32_t> photos_, last_;
};

void add_seen(ViewId id, const visibility::ViewVisibility& seen, Counter& counter) {
  for (std::uint32_t f = 0; f < seen.classes.size(); ++f)
    if (seen.classes[f] == visibility::FaceClass::full) counter.add(id, FaceId{f});
  for (const visibility::FaceCoverage& entry : seen.coverage.entries)
    if (static_cast<double>(entry.visible_share) >= kHalf) counter.add(id, entry.face);
}

void add_judged(ViewId id, const pipeline::Judgement& judgement, Counter& counter) {
  const std::vector<std::byte>& statistics = judgement.statistics[index(id)];
  labeling::FaceRecord record;
  for (std::size_t at = 0; at < statistics.size(); at += sizeof record) {
    std::memcpy(&record, statistics.data() + at, sizeof record);
    if (record.visible >= labeling::kWholeShare / 2 && !labeling::is_outlier(record))
      counter.add(id, FaceId{record.face});
  }
}

}  // namespace

FaceCoverage cover_faces(const pipeline::Run& run, const pipeline::Judgement* judgement,
                         std::optional<visibility::DeviceInfo>* device_found) {
  const auto& [input, settings, photos, observer, kept] = run;
  FaceCoverage coverage;
  Counter counter(input, coverage);
  observer.begin({"coverage", "views"});
  std::unique_ptr<visibility::GraphicsDevice> device;
  std::optional<visibility::VisibilityStage> stage;
  if (judgement == nullptr) {
    device = visibility::find_device(settings.visibility, settings.device);
    if (device && device_found != nullptr) *device_found = device->info();
    stage.emplace(input.mesh, settings.visibility, device.get());
  }
  visibility::ViewVisibility seen;
  for (std::size_t n = 0; n < input.views.size(); ++n) {
    observer.progress(n, input.views.size());
    const ViewId id = input.views[n];
    if (judgement != nullptr) {
      add_judged(id, *judgement, counter);
      continue;
    }
    stage->classify(input.scene.views[index(id)], id, photos.exclusion(id).get(), seen);
    add_seen(id, seen, counter);
  }
  observer.progress(input.views.size(), input.views.size());
  observer.end(fmt::format("{} views", input.views.size()));
  return coverage;
}

Wanted resolved(const Wanted& wanted, const Mesh& mesh, const FaceCoverage& coverage) {
  Wanted found = wanted;
  if (found.gsd > 0) return found;
  std::vector<std::pair<float, double>> seen;  // gsd and area
  double all = 0;
  for (std::size_t f = 0; f < coverage.photos.size(); ++f)
    if (coverage.photos[f] > 0) {
      seen.emplace_back(coverage.gsd[f], surface_of(mesh, FaceId{static_cast<std::uint32_t>(f)}));
      all += seen.back().second;
    }
  std::ranges::sort(seen);
  found.gsd = std::numeric_limits<double>::infinity();
  double so_far = 0;
  for (const auto& [gsd, area] : seen) {
    so_far += area;
    if (so_far < all / 2) continue;
    found.gsd = 2 * static_cast<double>(gsd);
    break;
  }
  return found;
}

std::vector<Lack> lacks_of(const FaceCoverage& coverage, const Wanted& wanted) {
  std::vector<Lack> lacks(coverage.photos.size(), Lack::nothing);
  for (std::size_t f = 0; f < lacks.size(); ++f) {
    if (coverage.photos[f] == 0)
      lacks[f] = Lack::unseen;
    else if (coverage.photos[f] < wanted.photos)
      lacks[f] = Lack::few;
    else if (static_cast<double>(coverage.gsd[f]) > wanted.gsd)
      lacks[f] = Lack::coarse;
    else if (static_cast<double>(coverage.angle[f]) > wanted.angle)
      lacks[f] = Lack::grazing;
  }
  return lacks;
}

namespace {

Area area_from(const Mesh& mesh, const FaceCoverage& coverage, Lack lack, std::vector<FaceId> faces) {
  std::ranges::sort(faces);
  Area area;
  area.lack = lack;
  area.faces = std::move(faces);
  area.least_photos = std::numeric_limits<std::uint32_t>::max();
  area.gsd = area.angle = std::numeric_limits<double>::infinity();
  for (const FaceId face : area.faces) {
    const std::size_t f = index(face);
    const double surface = surface_of(mesh, face);
    area.surface += surface;
    area.middle = area.middle + surface * middle_of(mesh, face);
    area.normal = area.normal + normal_of(mesh, face);
    area.least_photos = std::min(area.least_photos, coverage.photos[f]);
    area.most_photos = std::max(area.most_photos, coverage.photos[f]);
    area.gsd = std::min(area.gsd, static_cast<double>(coverage.gsd[f]));
    area.angle = std::min(area.angle, static_cast<double>(coverage.angle[f]));
  }
  area.middle = area.surface > 0 ? area.middle * (1 / area.surface) : middle_of(mesh, area.faces.front());
  area.normal = unit(area.normal);
  return area;
}

}  // namespace

std::vector<Area> areas_of(const Mesh& mesh, const FaceCoverage& coverage, const std::vector<Lack>& lacks) {
  const Grouped<std::uint32_t> neighbours = group_neighbours(mesh.faces.size(), labeling::face_graph(mesh).edges);
  std::vector<bool> taken(lacks.size(), false);
  std::vector<Area> areas;
  for (std::uint32_t start = 0; start < lacks.size(); ++start) {
    if (taken[start] || lacks[start] == Lack::nothing) continue;
    taken[start] = true;
    std::vector<FaceId> faces{FaceId{start}};
    for (std::size_t n = 0; n < faces.size(); ++n)
      for (const std::uint32_t next : neighbours[index(faces[n])])
        if (!taken[next] && lacks[next] == lacks[start]) {
          taken[next] = true;
          faces.push_back(FaceId{next});
        }
    areas.push_back(area_from(mesh, coverage, lacks[start], std::move(faces)));
  }
  std::ranges::stable_sort(areas, std::ranges::greater{}, &Area::surface);
  return areas;
}

}  // namespace gpvc::query
