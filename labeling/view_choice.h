// What becomes of each view of one face: whether it is a candidate, why not, and the parts of its cost. The answer of
// CandidateCollector for single faces, from the same records and by the same rules.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "../io/names.h"
#include "face_record.h"
#include "labeling.h"

namespace gpvc::labeling {

enum class ViewFate : std::uint8_t {
  candidate,   ///< may texture the face
  refused,     ///< a rule keeps it from the face
  outlier,     ///< shows another colour than the face's other photos do
  background,  ///< shows what lies behind in the face's place
  mixed,       ///< shows a mixture with that
  not_needed,  ///< sees the face in part, or along a silhouette, where others see it better (CandidateCollector::candidates())
};
inline constexpr Named<ViewFate> kViewFateNames[] = {
    {"candidate", ViewFate::candidate},   {"refused", ViewFate::refused}, {"outlier", ViewFate::outlier},
    {"background", ViewFate::background}, {"mixed", ViewFate::mixed},     {"not-needed", ViewFate::not_needed}};

/// The parts of a candidate's cost, in units of a seam between two neighbouring faces; all 0 for the best view there is.
struct CostParts {
  double quality = 0;     ///< for its quality (pixels, viewing angle: see DataTerm) as a share of the best candidate's
  double silhouette = 0;  ///< for the share of the face within the strip along silhouettes
  double hidden = 0;      ///< for the share of the face that it does not see
  double coarse = 0;      ///< for being more than two halvings of quality behind the best
  double total() const { return quality + silhouette + hidden + coarse; }
};

struct ViewOfFace {
  ViewId view{};
  FaceRecord record;
};

struct ViewChoice {
  ViewFate fate = ViewFate::candidate;
  CostParts cost;         ///< of a candidate
  bool doubtful = false;  ///< a candidate that is an outlier, as all views of the face are
};

/// True if the face's other photos show another colour.
bool is_outlier(const FaceRecord& record);

/// Of the views of one face, in their order. `allowed`: true for the views that rules leave the face; empty: all. \pre the
/// views ascend. O(views).
std::vector<ViewChoice> choose_views(std::span<const ViewOfFace> views, const CostOptions& options,
                                     const std::function<bool(ViewId)>& allowed = {});

/// What CandidateCollector::statistics_of() holds of a face; nullopt where the view does not see it, or where more views show
/// background in its place than see it. O(log statistics). \pre is_sound(statistics)
std::optional<FaceRecord> record_of(std::span<const std::byte> statistics, FaceId face);

/// The record of a face as far as it follows from geometry alone: without colours, contrast and silhouettes, and with the
/// quality of the area terms in place of the gradient's. \param visible_share of its samples, 1 if its class is full \param
/// pixels that show it
FaceRecord geometric_record(const Mesh& mesh, const View& view, FaceId face, double visible_share, std::size_t pixels,
                            DataTerm term);

}  // namespace gpvc::labeling
