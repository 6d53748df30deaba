// Colours for faces that no photo shows, from around them.
#include "atlas/baking/hole_filler.h"

#include <tbb/parallel_for.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>

#include "atlas/leveling/finished_texture.h"
#include "io/freed_memory.h"
#include "io/grouping.h"

namespace gpvc::atlas {

namespace {

constexpr std::uint32_t kNoHole = 0xFFFFFFFFu;

/// Vertices of unseen faces and the edges between them.
struct Holes {
  std::vector<Color> color;
  std::vector<float> samples;                       ///< colours summed so far; > 0: on a border, so the colour is known
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< of each face, so inner edges are listed twice
};

/// Mean of the filled texels that a chart shows around a corner of one of its faces; nullopt where there is none.
std::optional<Color> color_around(const Page& page, std::uint32_t chart, std::size_t layer, const TexelTriangle& face,
                                  std::size_t corner) {
  ColorMean mean;
  const int x0 = static_cast<int>(std::floor(face[corner].x)), y0 = static_cast<int>(std::floor(face[corner].y));
  for (int y = std::max(0, y0 - 1); y <= std::min(page.image.height - 1, y0 + 1); ++y) {
    for (int x = std::max(0, x0 - 1); x <= std::min(page.image.width - 1, x0 + 1); ++x) {
      if (page.shows(chart, face, x, y) && page.state[page.at(x, y)] != TexelState::empty)
        mean.add(page.color(layer, x, y));
    }
  }
  return mean.mean();
}

/// The corners that seen faces have on borders of holes, in face order, as 3 x face + corner.
std::vector<std::size_t> border_corners(const std::vector<std::uint32_t>& slots, const AtlasBuild& build) {
  const ChartSet& set = build.set;
  return group_numbered<std::size_t>(1, set.face_chart.size(),
                                     [&](std::size_t face, const auto& add) {
                                       const std::uint32_t c = set.face_chart[face];
                                       if (c >= set.placed || set.charts[c].kind == ChartKind::unseen) return;
                                       for (std::size_t i = 0; i < 3; ++i)
                                         if (slots[build.input.mesh.faces[face][i]] != kNoHole) add(0, 3 * face + i);
                                     })
      .items;
}

/// Adds the colours that finished faces have on borders of holes.
void add_finished(const std::vector<std::uint32_t>& slots, const AtlasInput& input, std::size_t layer, Holes& holes) {
  if (input.finished == nullptr) return;
  for (std::size_t face = 0; face < input.mesh.faces.size(); ++face) {
    if (!is_finished(input, face)) continue;
    for (const std::uint32_t vertex : input.mesh.faces[face]) {
      const std::uint32_t slot = slots[vertex];
      if (slot == kNoHole) continue;
      holes.color[slot] = holes.color[slot] + finished_color(input, face, vertex, layer);
      holes.samples[slot] += 1;
    }
  }
}

/// Calls visit(chart, face) for the unseen faces.
template <typename Visit>
void for_unseen(const ChartSet& set, const Visit& visit) {
  for (std::uint32_t c = 0; c < set.placed; ++c)
    if (set.charts[c].kind == ChartKind::unseen)
      for (const auto face : set.charts[c].faces) visit(c, face);
}

/// Spreads border colours inwards, breadth first, as the start of the iteration. Returns which vertices were reached.
std::vector<char> spread(Holes& holes) {
  const auto neighbours = group_neighbours(holes.color.size(), holes.edges);
  std::vector<char> reached(holes.color.size(), 0);
  std::vector<std::uint32_t> queue;
  for (std::uint32_t i = 0; i < reached.size(); ++i) {
    if (!(holes.samples[i] > 0)) continue;
    reached[i] = 1;
    queue.push_back(i);
  }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    for (const auto other : neighbours[queue[k]]) {
      if (reached[other]) continue;
      reached[other] = 1;
      holes.color[other] = holes.color[queue[k]];
      queue.push_back(other);
    }
  }
  return reached;
}

/// Solves the graph Laplacian for the vertices inside the holes.
void make_harmonic(Holes& holes, const std::vector<char>& reached) {
  std::vector<std::uint32_t> unknown(holes.color.size(), kNoHole), vertex;
  for (std::uint32_t i = 0; i < unknown.size(); ++i) {
    if (!reached[i] || holes.samples[i] > 0) continue;
    unknown[i] = static_cast<std::uint32_t>(vertex.size());
    vertex.push_back(i);
  }
  if (vertex.empty()) return;
  const auto n = static_cast<Eigen::Index>(vertex.size());
  // Memory for millions of faces: what edges add to the diagonal would be half of all entries, and a list that grows has
  // room for twice as many.
  std::vector<double> diagonal(vertex.size(), 0);
  const auto inner = std::ranges::count_if(
      holes.edges, [&](const auto& ends) { return unknown[ends[0]] != kNoHole && unknown[ends[1]] != kNoHole; });
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(vertex.size() + 2 * static_cast<std::size_t>(inner));
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(n, 3), guess(n, 3);
  for (const auto& [a, b] : holes.edges) {
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
      if (unknown[from] == kNoHole) continue;
      const int row = static_cast<int>(unknown[from]);
      diagonal[unknown[from]] += 1;
      if (unknown[to] != kNoHole)
        entries.emplace_back(row, static_cast<int>(unknown[to]), -1.0);
      else
        right.row(row) += Eigen::RowVector3d(holes.color[to].r, holes.color[to].g, holes.color[to].b);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const Color& c = holes.color[vertex[static_cast<std::size_t>(i)]];
    guess.row(i) = Eigen::RowVector3d(c.r, c.g, c.b);
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), diagonal[static_cast<std::size_t>(i)]);
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  free_memory(entries);
  tbb::parallel_for(0, 3, [&](int channel) {
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
    // A relative residual of 1e-4 is a fraction of a grey level. In holes of millions of faces the iteration ends
    // before that, and their interior keeps the spread border colours.
    solver.setTolerance(1e-4);
    solver.setMaxIterations(400);
    solver.compute(matrix);
    guess.col(channel) = solver.solveWithGuess(right.col(channel), guess.col(channel)).eval();
  });
  for (Eigen::Index i = 0; i < n; ++i)
    holes.color[vertex[static_cast<std::size_t>(i)]] = {
        static_cast<float>(guess(i, 0)), static_cast<float>(guess(i, 1)), static_cast<float>(guess(i, 2))};
}

/// Writes a layer of the 2 x 2 texels of an unseen face whose corners have the given colours.
void write_face(AtlasBuild& build, std::uint32_t chart, std::uint32_t face, std::size_t layer,
                const std::array<Color, 3>& c) {
  const ChartPlace& place = build.places[chart];
  Page& page = build.page_of(chart);
  const TexelPoint& corner = build.set.corners[face][0];
  const int x = static_cast<int>(corner.x), y = static_cast<int>(corner.y);
  const auto put = [&](int i, int j, const Color& color) {
    const auto texel = place.texel(x + i, y + j);
    page.put(layer, texel.x, texel.y, color);
    page.state[page.at(texel.x, texel.y)] = TexelState::chart;
  };
  put(0, 0, c[0]);
  put(1, 0, c[1]);
  put(0, 1, c[2]);
  // Outside the face. A plane through its corners may reach values there that a quantity never has.
  put(1, 1, layer == 0 ? c[1] + c[2] - c[0] : 0.5f * (c[1] + c[2]));
}

/// Writes a layer of the texels of an unseen chart of a given layout; of_face(face) gives the colours of a face's corners.
template <typename OfFace>
void write_given(AtlasBuild& build, std::uint32_t number, std::size_t layer, const OfFace& of_face) {
  const Chart& chart = build.set.charts[number];
  const ChartRaster raster = rasterize(chart.faces, build.set.corners, {-1, -1, chart.width + 1, chart.height + 1});
  Page& page = build.page_of(number);
  for (int y = raster.box.y0; y < raster.box.y1; ++y) {
    for (int x = raster.box.x0; x < raster.box.x1; ++x) {
      const std::size_t i = raster.at(x, y);
      if (!is_baked(raster.reach[i], build.options.padding)) continue;
      const auto texel = build.own_texel(number, x, y);
      if (!texel) continue;
      const std::array<Color, 3> c = of_face(raster.owner[i]);
      const std::array<double, 3> share = shares_at(build.set.corners[raster.owner[i]], x + 0.5, y + 0.5);
      Color color;
      for (std::size_t k = 0; k < 3; ++k) color = color + static_cast<float>(share[k]) * c[k];
      page.put(layer, texel->x, texel->y, color);
      page.state[page.at(texel->x, texel->y)] = state_of(raster.reach[i]);
    }
  }
}

}  // namespace

HoleFiller::HoleFiller(AtlasBuild& build)
    : build_(build), pending_(build.pages.size(), 0), layers_(build.painting.layers()) {
  if (build.set.unseen_faces == 0) return;
  slot_.assign(build.input.mesh.positions.size(), kNoHole);
  for_unseen(build.set, [&](std::uint32_t chart, std::uint32_t face) {
    pending_[build.places[chart].page] = 1;
    for (const auto v : build.input.mesh.faces[face])
      if (slot_[v] == kNoHole) slot_[v] = vertices_++;
  });
  if (build.options.unseen == UnseenFaces::color) return;
  corners_ = border_corners(slot_, build);
  for (Colors& layer : layers_) layer.border.resize(corners_.size());
}

void HoleFiller::look_at_borders() {
  for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, corners_.size()), [&](const auto& some) {
      for (std::size_t n = some.begin(); n < some.end(); ++n) {
        const std::size_t face = corners_[n] / 3;
        const std::uint32_t chart = build_.set.face_chart[face];
        const Page& page = build_.page_of(chart);
        if (page.is_open())
          layers_[layer].border[n] = color_around(page, chart, layer, build_.on_page(chart, face), corners_[n] % 3);
      }
    });
  }
}

void HoleFiller::solve() {
  if (vertices_ == 0 || build_.options.unseen == UnseenFaces::color) return;
  for (std::size_t layer = 0; layer < layers_.size(); ++layer) solve(layer);
}

void HoleFiller::solve(std::size_t layer) {
  Holes holes{std::vector<Color>(vertices_), std::vector<float>(vertices_, 0.0f), {}};
  for_unseen(build_.set, [&](std::uint32_t, std::uint32_t face) {
    const Triangle& t = build_.input.mesh.faces[face];
    for (std::size_t e = 0; e < 3; ++e)
      if (t[e] != t[(e + 1) % 3]) holes.edges.push_back({slot_[t[e]], slot_[t[(e + 1) % 3]]});
  });
  // A vertex on a border takes the mean of the colours that the seen faces around it have there.
  for (std::size_t n = 0; n < corners_.size(); ++n) {
    const std::optional<Color>& color = layers_[layer].border[n];
    if (!color) continue;
    const std::uint32_t slot = slot_[build_.input.mesh.faces[corners_[n] / 3][corners_[n] % 3]];
    holes.color[slot] = holes.color[slot] + *color;
    holes.samples[slot] += 1;
  }
  add_finished(slot_, build_.input, layer, holes);
  for (std::size_t i = 0; i < holes.color.size(); ++i)
    if (holes.samples[i] > 0) holes.color[i] = (1 / holes.samples[i]) * holes.color[i];
  const std::vector<char> reached = spread(holes);
  make_harmonic(holes, reached);
  if (std::find(reached.begin(), reached.end(), 0) != reached.end()) {
    const Color mean = build_.mean_color().mean(layer);
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (!reached[i]) holes.color[i] = mean;
  }
  layers_[layer].vertex = std::move(holes.color);
}

void HoleFiller::fill() {
  const bool paint = build_.options.unseen == UnseenFaces::color;
  std::vector<Color> painted{load(build_.options.unseen_color.data())};
  for (std::size_t layer = 1; layer < layers_.size(); ++layer)
    painted.push_back(build_.painting.in_bands(layer, painted.front()));
  tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(build_.set.placed), [&](std::uint32_t c) {
    const Chart& chart = build_.set.charts[c];
    if (chart.kind != ChartKind::unseen || !build_.page_of(c).is_open()) return;
    for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
      const auto of_face = [&](std::uint32_t face) {
        std::array<Color, 3> corners{painted[layer], painted[layer], painted[layer]};
        for (std::size_t i = 0; i < 3 && !paint; ++i)
          corners[i] = layers_[layer].vertex[slot_[build_.input.mesh.faces[face][i]]];
        return corners;
      };
      if (chart.given)
        write_given(build_, c, layer, of_face);
      else
        for (const auto face : chart.faces) write_face(build_, c, face, layer, of_face(face));
    }
  });
}

}  // namespace gpvc::atlas
