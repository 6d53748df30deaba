#include "app/query/index.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <limits>
#include <memory>
#include <string>

#include "app/query/sharpness.h"
#include "io/grouping.h"
#include "io/npz.h"
#include "io/photos.h"
#include "labeling/view_choice.h"
#include "visibility/visibility.h"

namespace gpvc::query {
namespace {

struct Entry {
  std::uint32_t view;
  std::uint8_t found;
  float share;
};

using SeenFaces = std::vector<std::pair<std::uint32_t, Entry>>;  // of one view

SeenFaces seen_faces(ViewId id, const visibility::ViewVisibility& seen) {
  SeenFaces faces;
  const auto view = static_cast<std::uint32_t>(index(id));
  auto partial = seen.coverage.entries.begin();
  for (std::uint32_t f = 0; f < seen.classes.size(); ++f) {
    const visibility::FaceClass found = seen.classes[f];
    if (found != visibility::FaceClass::full && found != visibility::FaceClass::partial) continue;
    while (partial != seen.coverage.entries.end() && index(partial->face) < f) ++partial;
    const bool has_share = partial != seen.coverage.entries.end() && index(partial->face) == f;
    const float share = found == visibility::FaceClass::full ? 1 : has_share ? partial->visible_share : 0;
    faces.push_back({f, {view, static_cast<std::uint8_t>(found), share}});
  }
  return faces;
}

// What the labeling makes of the entries of a face.
void judge_face(std::uint32_t face, std::size_t begin, std::size_t end, const pipeline::Judgement& judgement,
                const labeling::CandidateCollector::Allowed& allowed, PhotoIndex& to) {
  std::vector<labeling::ViewOfFace> views;
  std::vector<std::size_t> which;
  for (std::size_t at = begin; at < end; ++at) {
    const ViewId view{to.views[at]};
    const auto record = labeling::record_of(judgement.statistics[index(view)], FaceId{face});
    if (!record) continue;
    views.push_back({view, *record});
    which.push_back(at);
  }
  const auto choices = labeling::choose_views(views, judgement.costs,
                                              [&](ViewId view) { return !allowed || allowed(FaceId{face}, view); });
  for (std::size_t n = 0; n < which.size(); ++n) {
    to.fates[which[n]] = static_cast<std::uint8_t>(choices[n].fate);
    if (choices[n].fate == labeling::ViewFate::candidate)
      to.costs[which[n]] = static_cast<float>(choices[n].cost.total());
  }
}

}  // namespace

PhotoIndex index_faces(const pipeline::Run& run, const pipeline::Judgement* judgement,
                       std::optional<visibility::DeviceInfo>* device_found) {
  const auto& [input, settings, photos, observer, kept] = run;
  const checks::Input& of = input;
  observer.begin({"visibility", "views"});
  const auto device = visibility::find_device(settings.visibility, settings.device);
  if (device && device_found != nullptr) *device_found = device->info();
  visibility::VisibilityStage stage(of.mesh, settings.visibility, device.get());
  visibility::ViewVisibility seen;
  std::vector<SeenFaces> by_view;
  for (std::size_t n = 0; n < of.views.size(); ++n) {
    observer.progress(n, of.views.size());
    const ViewId id = of.views[n];
    stage.classify(of.scene.views[index(id)], id, photos.exclusion(id).get(), seen);
    by_view.push_back(seen_faces(id, seen));
  }
  const Grouped<Entry> grouped = group_items<Entry>(of.mesh.faces.size(), [&](const auto& add) {
    for (const SeenFaces& faces : by_view)
      for (const auto& [face, entry] : faces) add(face, entry);
  });
  by_view.clear();
  PhotoIndex found;
  const std::size_t entries = grouped.items.size();
  found.first.assign(grouped.first.begin(), grouped.first.end());
  found.views.resize(entries);
  found.classes.resize(entries);
  found.shares.resize(entries);
  found.gsd.resize(entries);
  found.angle.resize(entries);
  if (judgement != nullptr) {
    found.fates.assign(entries, kNoFate);
    found.costs.assign(entries, std::numeric_limits<float>::quiet_NaN());
  }
  const auto allowed = judgement == nullptr
                           ? labeling::CandidateCollector::Allowed{}
                           : pipeline::allowed_views(judgement->rules, of.mesh, of.scene.views.size(), observer);
  tbb::parallel_for(std::size_t{0}, of.mesh.faces.size(), [&](std::size_t f) {
    const FaceId face{static_cast<std::uint32_t>(f)};
    for (std::size_t at = grouped.first[f]; at < grouped.first[f + 1]; ++at) {
      const Entry& entry = grouped.items[at];
      const Sharpness sharp =
          sharpness_of(of.scene.views[entry.view], middle_of(of.mesh, face), normal_of(of.mesh, face));
      found.views[at] = entry.view;
      found.classes[at] = entry.found;
      found.shares[at] = entry.share;
      found.gsd[at] = static_cast<float>(sharp.gsd);
      found.angle[at] = static_cast<float>(sharp.angle);
    }
    if (judgement != nullptr)
      judge_face(static_cast<std::uint32_t>(f), grouped.first[f], grouped.first[f + 1], *judgement, allowed, found);
  });
  observer.end(fmt::format("{} entries of {} faces", results::readable_count(entries),
                           results::readable_count(of.mesh.faces.size())));
  return found;
}

void write_index(const std::filesystem::path& file, const PhotoIndex& faces, const Scene& scene) {
  std::vector<std::uint8_t> names;
  for (const View& view : scene.views) {
    if (!names.empty()) names.push_back('\n');
    names.insert(names.end(), view.name.begin(), view.name.end());
  }
  io::NpzWriter out(file);
  out.add("first", faces.first);
  out.add("views", faces.views);
  out.add("classes", faces.classes);
  out.add("shares", faces.shares);
  out.add("gsd", faces.gsd);
  out.add("angle", faces.angle);
  if (!faces.fates.empty()) {
    out.add("fates", faces.fates);
    out.add("costs", faces.costs);
  }
  out.add("names", names);
  out.commit();
}

}  // namespace gpvc::query
