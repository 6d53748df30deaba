#include "app/tiles/job_photos.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "io/photos.h"

namespace gpvc::tiles {
namespace {

constexpr const char* kPhotosPart = "photos";

bool looks_first(const Unit& unit) { return unit.stage == Stage::see && unit.level == 0; }

}  // namespace

JobPhotos::JobPhotos(JobFolder folder, const Job& job, const io::WorkKey& job_key)
    : folder_(std::move(folder)), job_(job), job_key_(job_key), group_of_(job.scene.views.size(), 0) {
  for (std::uint32_t g = 0; g < job_.groups.size(); ++g)
    for (const ViewId view : job_.groups[g]) group_of_[index(view)] = g;
}

std::vector<fs::path> JobPhotos::files_of(std::span<const ViewId> views) const {
  std::set<fs::path> files;  // several views may be made from one
  for (const ViewId id : views)
    for (const fs::path& file : io::files_of(job_.scene.views[index(id)])) files.insert(file);
  return {files.begin(), files.end()};
}

const JobPhotos::Seen* JobPhotos::seen_in(std::uint32_t group) {
  if (const auto found = seen_.find(group); found != seen_.end()) return &found->second;
  std::vector<SeenFile> files;
  const io::WorkStore store(folder_.unit(see_unit(0, group)));
  if (!store.read(kPhotosPart, job_key_, [&](io::WorkStore::Reader& in) { files = in.get<std::vector<SeenFile>>(); }))
    return nullptr;
  Seen& seen = seen_[group];
  for (const SeenFile& each : files) {
    seen.emplace(each.file, each.known);
    hashes_.learn(each.file, each.known);
  }
  return &seen;
}

void JobPhotos::add(const Unit& unit, io::WorkHash& hash) {
  if (looks_first(unit)) {
    seen_in(unit.number);
    hash.add(job_.groups[unit.number]);  // jobs of one input may have other groups
    for (const fs::path& file : files_of(job_.groups[unit.number])) hash.add(hashes_.of(file).hash);
    return;
  }
  std::span<const ViewId> views;
  if (unit.stage == Stage::see) views = job_.groups[unit.number];
  if (unit.stage == Stage::expose || unit.stage == Stage::bake) views = job_.tiles(unit.level)[unit.number].views;
  for (const ViewId view : views) {
    const std::uint32_t group = group_of_[index(view)];
    const Seen* seen = seen_in(group);
    for (const fs::path& file : files_of({&view, 1})) {
      const auto found = seen != nullptr ? seen->find(file) : Seen::const_iterator{};
      if (seen == nullptr || found == seen->end())
        throw InputError(folder_.unit(see_unit(0, group)) / kPhotosPart, "",
                         fmt::format("is missing or damaged; run unit {} again", see_unit(0, group)));
      if (hashes_.of(file).hash != found->second.hash)
        throw InputError(file, "",
                         fmt::format("is not the file that unit {} looked at; run that unit again, and those after it",
                                     see_unit(0, group)));
      hash.add(found->second.hash);
    }
  }
}

void JobPhotos::keep(const Unit& unit) {
  if (!looks_first(unit)) return;
  std::vector<SeenFile> files;
  Seen seen;
  for (const fs::path& file : files_of(job_.groups[unit.number])) {
    files.push_back({file, hashes_.unchanged(file)});  // since add()
    seen.emplace(file, files.back().known);
  }
  if (const Seen* before = seen_in(unit.number); before != nullptr && *before == seen) return;
  folder_.keep(folder_.unit(unit.name), kPhotosPart, job_key_, [&](io::WorkStore::Writer& out) { out.add(files); });
  seen_[unit.number] = std::move(seen);
}

}  // namespace gpvc::tiles
