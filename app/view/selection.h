// Faces that people mark on the screen, and rules about them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <vector>

#include "app/checks/input.h"
#include "app/evaluate/json.h"
#include "labeling/labeling.h"

namespace gpvc::view {

/// The faces that a view of the screen shows in a polygon, in its pixels: those with the larger part of their visible pixels in the
/// polygon's bounding rectangle and their middle in the polygon. Nothing behind them is meant. O(faces + pixels).
std::vector<std::uint32_t> faces_in(const checks::Input& input, const View& screen,
                                    std::span<const PhotoPoint> polygon);

/// The faces that are joined to a face through faces of the same photo, ascending; with no photo, the face alone. \param labels per
/// face of the mesh. O(faces).
std::vector<std::uint32_t> chart_around(FaceId face, std::span<const std::int32_t> labels,
                                        const labeling::FaceGraph& graph);

/// Ascending faces as files of rules list them: 7, [100, 120].
evaluate::Json faces_json(std::span<const std::uint32_t> ascending);
/// Faces so listed, ascending, each once. Throws InputError about `place` for anything else, and for faces beyond `count`.
std::vector<std::uint32_t> faces_from(const evaluate::Json& listed, std::size_t count, const char* place);

/// The rules beside a result, in the JSON that io/view_rules.h describes. Thread-safe.
class RuleFile {
 public:
  /// \param earlier the file that the result was made with, which an own file begins with; empty: none
  RuleFile(std::filesystem::path file, std::filesystem::path earlier)
      : file_(std::move(file)), earlier_(std::move(earlier)) {}
  const std::filesystem::path& path() const { return file_; }
  /// The list of rules. Throws InputError where the file cannot be edited here.
  evaluate::Json read() const;
  /// Throws InputError for a list that read_view_rules() would refuse, OutputError.
  void write(const evaluate::Json& rules) const;

 private:
  std::filesystem::path file_, earlier_;
  mutable std::mutex mutex_;
};

}  // namespace gpvc::view
