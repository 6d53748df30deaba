#include "atlas/charts/given_charts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "atlas/charts/chart_cutting.h"

namespace gpvc::atlas {
namespace {

class GivenCharts {
 public:
  GivenCharts(const AtlasInput& input, const FaceNeighbours& neighbours)
      : input_(input), neighbours_(neighbours), kinds_(input.mesh.faces.size()), taken_(kinds_.size(), 0) {
    result_.face_chart.resize(kinds_.size());
    result_.corners.resize(kinds_.size());
  }

  ChartSet make() {
    for (std::uint32_t face = 0; face < kinds_.size(); ++face) {
      result_.corners[face] = page_corners(*input_.layout, face);
      kinds_[face] = kind_of(face);
    }
    for (const ChartKind kind : {ChartKind::plain, ChartKind::partial, ChartKind::unseen, ChartKind::border}) {
      if (kind == ChartKind::border) result_.placed = result_.charts.size();
      for (std::uint32_t face = 0; face < kinds_.size(); ++face)
        if (kinds_[face] == kind && !taken_[face]) add_piece(face);
    }
    result_.unseen_faces = static_cast<std::size_t>(std::ranges::count(kinds_, ChartKind::unseen));
    return std::move(result_);
  }

 private:
  ChartKind kind_of(std::uint32_t face) const {
    const bool in_border = !input_.border.empty() && input_.border[face];
    if (in_border || !takes_texels(*input_.layout, face)) return ChartKind::border;
    if (!has_view(input_, face)) return ChartKind::unseen;
    return input_.tags[face] == labeling::FaceTag::partial ? ChartKind::partial : ChartKind::plain;
  }

  bool may_share_chart(std::uint32_t face, std::uint32_t other) const {
    if (kinds_[face] != kinds_[other] || input_.labels[face] != input_.labels[other]) return false;
    return kinds_[face] == ChartKind::border || continues(input_.mesh, *input_.layout, face, other);
  }

  /// The charts of what continues a face.
  void add_piece(std::uint32_t seed) {
    FramePart part;
    part.view = input_.labels[seed];
    part.faces = {seed};
    taken_[seed] = 1;
    for (std::size_t next = 0; next < part.faces.size(); ++next)
      for (const std::uint32_t face = part.faces[next]; const std::uint32_t other : neighbours_[face])
        if (!taken_[other] && may_share_chart(face, other)) {
          taken_[other] = 1;
          part.faces.push_back(other);
        }
    std::ranges::sort(part.faces);
    const ChartKind kind = kinds_[seed];
    if (kind == ChartKind::border)
      for (const std::uint32_t face : part.faces) result_.corners[face] = {};
    for (const std::uint32_t face : part.faces) part.box.add(result_.corners[face]);
    const auto piece = static_cast<std::uint32_t>(result_.charts.size());
    for (FramePart& cut : cut_ragged(std::move(part), result_.corners)) add(kind, std::move(cut), piece);
  }

  void add(ChartKind kind, FramePart part, std::uint32_t piece) {
    Chart chart;
    chart.kind = kind;
    chart.given = true;
    chart.view = kind == ChartKind::unseen ? kNoView : part.view;
    chart.piece = piece;
    chart.origin_x = std::floor(part.box.x0);
    chart.origin_y = std::floor(part.box.y0);
    chart.width = part.box.width();
    chart.height = part.box.height();
    for (const std::uint32_t face : part.faces) {
      result_.face_chart[face] = static_cast<std::uint32_t>(result_.charts.size());
      for (TexelPoint& p : result_.corners[face]) p = {p.x - chart.origin_x, p.y - chart.origin_y};
    }
    chart.faces = std::move(part.faces);
    result_.charts.push_back(std::move(chart));
  }

  const AtlasInput& input_;
  const FaceNeighbours& neighbours_;
  std::vector<ChartKind> kinds_;  ///< per face
  std::vector<char> taken_;       ///< per face, 1 if it is in a chart
  ChartSet result_;
};

}  // namespace

TexelTriangle page_corners(const io::UvLayout& layout, std::size_t face) {
  if (layout.face_page[face] == io::kNoPage) return {};
  const io::UvPage& page = layout.pages[layout.face_page[face]];
  TexelTriangle corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const io::TexCoord& at = layout.texcoords[layout.face_texcoords[face][i]];
    corners[i] = {double{at.u} * page.width, double{at.v} * page.height};
  }
  return corners;
}

bool takes_texels(const io::UvLayout& layout, std::size_t face) {
  return layout.face_page[face] != io::kNoPage && doubled_area(page_corners(layout, face)) != 0;
}

bool continues(const Mesh& mesh, const io::UvLayout& layout, std::uint32_t face, std::uint32_t other) {
  if (layout.face_page[face] != layout.face_page[other]) return false;
  const auto edge = shared_edge(mesh.faces[face], mesh.faces[other]);
  return edge && std::ranges::all_of(*edge, [&](std::uint32_t vertex) {
           const auto at = [&](std::uint32_t of) -> const io::TexCoord& {
             return layout.texcoords[layout.face_texcoords[of][corner_of(mesh.faces[of], vertex)]];
           };
           return at(face).u == at(other).u && at(face).v == at(other).v;
         });
}

ChartSet make_given_charts(const AtlasInput& input, const FaceNeighbours& neighbours) {
  return GivenCharts(input, neighbours).make();
}

}  // namespace gpvc::atlas
