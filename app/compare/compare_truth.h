// The models of a comparison judged by a synthetic scene's truth.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/cli/run_record.h"
#include "app/pipeline/pipeline.h"
#include "io/photos.h"
#include "io/progress.h"
#include "io/textured_model.h"

namespace gpvc::compare {

class TruthComparison {
 public:
  /// Borrows input and photos. Throws InputError.
  TruthComparison(const std::filesystem::path& dir, const pipeline::Input& input, io::PhotoSource& photos,
                  const Progress& progress);
  ~TruthComparison();
  TruthComparison(const TruthComparison&) = delete;
  TruthComparison& operator=(const TruthComparison&) = delete;
  /// The figures of a model; `offset` is to be added to its positions. `origins`: where its texture comes from, or
  /// nullptr.
  cli::Json score(const io::TexturedModel& model, std::span<const Image> pages, const WorldPoint& offset,
                  const atlas::TextureOrigins* origins, const Progress& progress);
  /// How far one scored model is ahead of another in the seen area textured rightly, as a share of that area, and one
  /// standard error, taking each face's points as a random sample. null where origins are not known.
  cli::Json ahead(std::size_t model, std::size_t of) const;
  /// The last scored model's points with another surface's colour.
  cli::Json wrong_points() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::compare
