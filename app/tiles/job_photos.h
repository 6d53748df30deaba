// The photos and masks of a job, by content: those that units bake from are those that were looked at.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "app/tiles/plan.h"
#include "io/file_hashes.h"

namespace gpvc::tiles {

/// What a unit that looks at photos of level 0 has found a file to be.
struct SeenFile {
  std::filesystem::path file;
  io::HashedFile known;
};
GPVC_MEMBERS(SeenFile, file, known)

/// Units of Stage::see on level 0 leave the hashes of their photos beside what they see. Later units read a photo again only
/// where its size, inode or times are others than then.
class JobPhotos {
 public:
  /// Borrows the job.
  JobPhotos(JobFolder folder, const Job& job, const io::WorkKey& job_key);
  /// Adds what the unit's photos are to its key, if it looks at photos. Throws InputError that names a photo which cannot be
  /// read, or which is not the one that an earlier unit looked at.
  void add(const Unit& unit, io::WorkHash& hash);
  /// Leaves the hashes that add() has used for later units. Throws OutputError.
  void keep(const Unit& unit);
  /// What add() has found the photos of a unit to be, for the cache that the unit reads them through.
  io::FileHashes& hashes() { return hashes_; }

 private:
  using Seen = std::map<std::filesystem::path, io::HashedFile>;
  std::vector<std::filesystem::path> files_of(std::span<const ViewId> views) const;
  /// What the unit that looks at a group has left; nullptr where it has not.
  const Seen* seen_in(std::uint32_t group);

  JobFolder folder_;
  const Job& job_;
  io::WorkKey job_key_;
  std::vector<std::uint32_t> group_of_;  ///< per view
  std::map<std::uint32_t, Seen> seen_;   ///< by group, as far as it was read
  io::FileHashes hashes_;
};

}  // namespace gpvc::tiles
