// Rules about which photos may texture which part of a mesh, resolved to the views of a scene.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "../../io/scene.h"
#include "../../io/view_rules.h"
#include "../../labeling/labeling.h"
#include "../results/observer.h"

namespace gpvc::pipeline {

struct ViewRule {
  io::Region region;
  bool allow = false;  ///< these views alone; else all but these
  std::vector<ViewId> views;
  std::string name = "rule";  ///< in messages: the file and the place in it
};

/// True if its views are of so many, and its region has corners that are numbers.
bool is_sound(const ViewRule& rule, std::size_t views);

/// What a list of rules says of each face and view. A view may texture a face that all rules about the face leave it.
class ViewRuleTable {
 public:
  /// O(faces log faces, and for each rule what FaceLocator::faces_in() takes), TBB.
  ViewRuleTable(std::span<const ViewRule> rules, const Mesh& mesh, std::size_t views);

  bool allows(FaceId face, ViewId view) const {
    return allowed_[set_of_face_[static_cast<std::size_t>(face)]][static_cast<std::size_t>(view)];
  }
  /// Faces that some rule is about.
  std::size_t faces() const;
  /// Per rule the number of its faces.
  const std::vector<std::size_t>& faces_of_rules() const { return faces_of_rules_; }

 private:
  std::vector<std::uint32_t> set_of_face_;  ///< which set of rules is about it; 0: none
  std::vector<std::vector<bool>> allowed_;  ///< per set of rules and view
  std::vector<std::size_t> faces_of_rules_;
};

/// The table of some rules, as CandidateCollector::candidates() takes it; none where there are no rules. Says how many faces
/// they are about, and warns of regions without a face, since a mistyped region shows in that. Borrows nothing.
labeling::CandidateCollector::Allowed allowed_views(std::span<const ViewRule> rules, const Mesh& mesh,
                                                    std::size_t views, results::Observer& observer);

// --- parts of a mesh, and coarser meshes of some of its vertices

/// First and last numbers, ascending.
using NumberRanges = std::vector<std::array<std::uint32_t, 2>>;

/// Per rule the vertices of the faces that it lists; none for rules about places. O(faces).
std::vector<NumberRanges> listed_vertices(std::span<const ViewRule> rules, const Mesh& mesh);

/// The rules for a part of the mesh. \param face per face of the part, its number in the mesh, ascending
std::vector<ViewRule> rules_of_part(std::span<const ViewRule> rules, std::span<const std::uint64_t> face);

/// The rules for a coarser mesh: where a rule lists faces, they are about the faces all of whose corners are corners of those.
/// \param listed listed_vertices() of the finer mesh \param vertex per vertex of the coarser mesh, its number in the finer
std::vector<ViewRule> rules_of_coarser(std::span<const ViewRule> rules, std::span<const NumberRanges> listed,
                                       const Mesh& coarser, std::span<const std::uint32_t> vertex);

/// Warns of faces that lose all views.
void report_refused(std::span<const FaceId> refused, results::Observer& observer);

}  // namespace gpvc::pipeline
