// The work that a run keeps until its result is complete, so that the same command goes on from there after a kill, a full
// disk or a power cut. Each part is kept under a key of what it came from: the program, the bytes of mesh and photos, and
// the options that matter to it. A run with other options takes over what does not depend on them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "app/checks/fit_verdict.h"
#include "app/pipeline/coverage_store.h"
#include "app/pipeline/pipeline.h"
#include "io/work_store.h"

namespace gpvc::pipeline {

/// What see() makes of a view.
struct ViewWork {
  std::vector<std::byte> statistics;  ///< as labeling::CandidateCollector::statistics_of() gives them
  PackedCoverage coverage;
  visibility::VisibilityStatistics visibility;
  checks::FitGroups tie_points{};  ///< as checks::TiePointFit counts them
};

class KeptWork {
 public:
  /// Hashes mesh and photos. Use make().
  KeptWork(io::WorkStore store, std::vector<std::pair<ViewId, io::WorkKey>> views, io::WorkKey selection,
           io::WorkKey atlas);

  /// nullopt where the photos have no keys, or this program cannot be read. O(bytes of mesh and photos), TBB. Throws
  /// InputError.
  static std::optional<KeptWork> make(const std::filesystem::path& folder, const Input& input, const Settings& settings,
                                      io::PhotoSource& photos, Observer& observer);

  /// nullopt if the view is to be looked at.
  std::optional<ViewWork> view(ViewId id);
  void keep_view(ViewId id, std::span<const std::byte> statistics, const PackedCoverage& coverage,
                 const visibility::VisibilityStatistics& visibility, const checks::FitGroups& tie_points);
  std::optional<labeling::Selection> selection(std::size_t faces) const;
  void keep_selection(const labeling::Selection& selection);
  atlas::KeptPages pages() { return {&store_, atlas_}; }

  /// How many views were taken over.
  std::size_t views_taken() const { return views_taken_; }
  /// Warns once if nothing more can be kept.
  void warn_of_failure(Observer& observer);

 private:
  io::WorkStore store_;
  std::map<ViewId, io::WorkKey> views_;
  io::WorkKey selection_, atlas_;
  std::size_t views_taken_ = 0;
  bool warned_ = false;
};

/// What a result came from, part by part, so that it can be told which of them is another one.
struct ResultKeys {
  io::WorkKey mesh, views, options;  ///< the views with their photos; all options but rules about views and files
};
/// O(bytes of mesh and photos), TBB. Photos without keys count as the same. Throws InputError.
ResultKeys result_keys(const Input& input, const Settings& settings, io::PhotoSource& photos, Observer& observer);

/// Bytes that the kept work of a run takes on disk, predicted.
double kept_bytes(const Workload& work);

}  // namespace gpvc::pipeline
