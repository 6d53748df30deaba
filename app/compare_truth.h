// A comparison's models held against a synthetic scene's truth.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/run_record.h"
#include "app/scene_input.h"
#include "io/io.h"

namespace gpvc {

class TruthComparison {
 public:
  /// Borrows input and photos. Throws InputError.
  TruthComparison(const std::filesystem::path& dir, const SceneInputData& input, PhotoCache& photos);
  ~TruthComparison();
  TruthComparison(const TruthComparison&) = delete;
  TruthComparison& operator=(const TruthComparison&) = delete;
  /// The figures of a model whose positions lack `offset`.
  Json score(const TexturedModel& model, std::span<const Image> pages, const WorldPoint& offset,
             const Progress& progress) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc
