// The work that a run keeps until its result is complete, so that the same command goes on from there after a kill, a full
// disk or a power cut. Each part is kept under a key of what it came from: the program, the bytes of mesh and photos, and
// the options that matter to it. A run with other options takes over what does not depend on them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "keys.h"
#include "memory.h"
#include "texture_files.h"

namespace gpvc::pipeline {

/// A folder of parts: "view-3", "labels", and the pages of an atlas.
class Checkpoint final : public results::Store {
 public:
  Checkpoint(std::filesystem::path folder, StepKeys keys)
      : store_(std::move(folder), results::kCheckpointHashes), keys_(std::move(keys)) {}

  bool read(const std::string& name, const std::function<void(Reader&)>& fill) const override;
  void write(const std::string& name, const std::function<void(Writer&)>& fill) override;
  atlas::KeptPages pages() { return {&store_, keys_.pages}; }
  /// Warns once if nothing more can be kept.
  void warn_of_failure(Observer& observer);

 private:
  io::WorkStore store_;
  StepKeys keys_;
  bool warned_ = false;
};

/// The name of a view's part.
std::string view_part(ViewId id);
inline constexpr const char* kLabelsPart = "labels";

/// Where a run into a folder keeps its work, if it does: see Settings::keep_work. `part`: a folder in that of the kept work, for
/// one of several results; empty: that folder itself.
std::optional<Checkpoint> open_checkpoint(const Run& run, const MemoryPlan& memory, const FileSizes& sizes,
                                          const OutputFolder& folder, const std::filesystem::path& part = {});

/// Bytes that the kept work of a run takes on disk, predicted.
double kept_bytes(const Workload& work);

}  // namespace gpvc::pipeline
