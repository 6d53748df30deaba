#include "atlas/baking/fill.h"

#include <tbb/parallel_for.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>

namespace gpvc::atlas {

namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// Vertices of unseen faces and the edges between them.
struct Holes {
  std::vector<std::uint32_t> slot;  ///< per mesh vertex: its place in the lists below, or kNone
  std::vector<Color> color;
  std::vector<float> samples;                       ///< colours summed so far; > 0: on a border, its colour is given
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< once per face, so inner edges count twice
};

Holes find_holes(const AtlasInput& input, const ChartSet& set) {
  Holes holes;
  holes.slot.assign(input.mesh.positions.size(), kNone);
  std::uint32_t count = 0;
  for (const Chart& chart : set.charts) {
    if (chart.kind != ChartKind::blocks) continue;
    for (const auto face : chart.faces) {
      const Triangle& t = input.mesh.faces[face];
      for (const auto v : t)
        if (holes.slot[v] == kNone) holes.slot[v] = count++;
      for (std::size_t e = 0; e < 3; ++e)
        if (t[e] != t[(e + 1) % 3]) holes.edges.push_back({holes.slot[t[e]], holes.slot[t[(e + 1) % 3]]});
    }
  }
  holes.color.resize(count);
  holes.samples.assign(count, 0.0f);
  return holes;
}

/// Mean of the filled texels around a position; its weight is zero where there is none.
std::pair<Color, float> color_around(const Page& page, const TexelPoint& p) {
  Color sum;
  float count = 0;
  const int x0 = static_cast<int>(std::floor(p.x)), y0 = static_cast<int>(std::floor(p.y));
  for (int y = std::max(0, y0 - 1); y <= std::min(page.image.height - 1, y0 + 1); ++y) {
    for (int x = std::max(0, x0 - 1); x <= std::min(page.image.width - 1, x0 + 1); ++x) {
      if (page.state[page.at(x, y)] == TexelState::empty) continue;
      sum = sum + load(page.image.at(x, y));
      count += 1;
    }
  }
  return {count > 0 ? (1 / count) * sum : sum, count > 0 ? 1.0f : 0.0f};
}

void gather_border(Holes& holes, const AtlasInput& input, const ChartSet& set, std::span<const ChartPlace> places,
                   std::span<const Page> pages) {
  for (std::size_t face = 0; face < input.mesh.faces.size(); ++face) {
    const std::uint32_t c = set.face_chart[face];
    if (set.charts[c].kind == ChartKind::blocks) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t slot = holes.slot[input.mesh.faces[face][i]];
      if (slot == kNone) continue;
      const auto [color, weight] = color_around(pages[places[c].page], places[c].point(set.corners[face][i]));
      holes.color[slot] = holes.color[slot] + weight * color;
      holes.samples[slot] += weight;
    }
  }
  for (std::size_t i = 0; i < holes.color.size(); ++i)
    if (holes.samples[i] > 0) holes.color[i] = (1 / holes.samples[i]) * holes.color[i];
}

/// Spreads border colours inwards, breadth first: the start of the iteration, and the answer to which vertices no
/// border reaches.
std::vector<char> spread(Holes& holes) {
  const std::size_t n = holes.color.size();
  std::vector<std::size_t> first(n + 1, 0);
  for (const auto& e : holes.edges)
    for (const auto v : e) ++first[v + 1];
  for (std::size_t i = 0; i < n; ++i) first[i + 1] += first[i];
  std::vector<std::uint32_t> neighbours(first[n]);
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (const auto& e : holes.edges) {
    neighbours[next[e[0]]++] = e[1];
    neighbours[next[e[1]]++] = e[0];
  }
  std::vector<char> reached(n, 0);
  std::vector<std::uint32_t> queue;
  for (std::uint32_t i = 0; i < n; ++i)
    if (holes.samples[i] > 0) reached[i] = 1, queue.push_back(i);
  for (std::size_t k = 0; k < queue.size(); ++k) {
    for (std::size_t j = first[queue[k]]; j < first[queue[k] + 1]; ++j) {
      const std::uint32_t other = neighbours[j];
      if (reached[other]) continue;
      reached[other] = 1;
      holes.color[other] = holes.color[queue[k]];
      queue.push_back(other);
    }
  }
  return reached;
}

/// Solves the graph Laplacian for the vertices off the border; a matrix of at most seven entries a row.
void make_harmonic(Holes& holes, const std::vector<char>& reached) {
  std::vector<std::uint32_t> unknown(holes.color.size(), kNone), vertex;
  for (std::uint32_t i = 0; i < unknown.size(); ++i) {
    if (!reached[i] || holes.samples[i] > 0) continue;
    unknown[i] = static_cast<std::uint32_t>(vertex.size());
    vertex.push_back(i);
  }
  if (vertex.empty()) return;
  const auto n = static_cast<Eigen::Index>(vertex.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(n, 3), guess(n, 3);
  for (const auto& [a, b] : holes.edges) {
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
      if (unknown[from] == kNone) continue;
      const int row = static_cast<int>(unknown[from]);
      entries.emplace_back(row, row, 1.0);
      if (unknown[to] != kNone)
        entries.emplace_back(row, static_cast<int>(unknown[to]), -1.0);
      else
        right.row(row) += Eigen::RowVector3d(holes.color[to].r, holes.color[to].g, holes.color[to].b);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const Color& c = holes.color[vertex[static_cast<std::size_t>(i)]];
    guess.row(i) << c.r, c.g, c.b;
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  tbb::parallel_for(0, 3, [&](int channel) {
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver;
    // A relative residual of 1e-4 is a fraction of a grey level; the cap bounds holes of millions of faces, whose deep
    // inside then keeps the spread border colour.
    solver.setTolerance(1e-4);
    solver.setMaxIterations(400);
    solver.compute(matrix);
    guess.col(channel) = solver.solveWithGuess(right.col(channel), guess.col(channel)).eval();
  });
  for (Eigen::Index i = 0; i < n; ++i)
    holes.color[vertex[static_cast<std::size_t>(i)]] = {
        static_cast<float>(guess(i, 0)), static_cast<float>(guess(i, 1)), static_cast<float>(guess(i, 2))};
}

void write_block(const std::array<Color, 3>& c, const TexelTriangle& corners, const ChartPlace& place, Page& page) {
  const int x = static_cast<int>(corners[0].x), y = static_cast<int>(corners[0].y);
  const auto put = [&](int i, int j, const Color& color) {
    const auto texel = place.texel(x + i, y + j);
    page.put(texel.x, texel.y, color, TexelState::chart);
  };
  put(0, 0, c[0]);
  put(1, 0, c[1]);
  put(0, 1, c[2]);
  put(1, 1, c[1] + c[2] - c[0]);
}

}  // namespace

void fill_unseen(const AtlasInput& input, const ChartSet& set, std::span<const ChartPlace> places,
                 std::span<Page> pages) {
  if (set.filled_faces == 0) return;
  Holes holes = find_holes(input, set);
  gather_border(holes, input, set, places, pages);
  const std::vector<char> reached = spread(holes);
  make_harmonic(holes, reached);
  if (std::find(reached.begin(), reached.end(), 0) != reached.end()) {
    const Color mean = mean_color(pages);
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (!reached[i]) holes.color[i] = mean;
  }
  tbb::parallel_for(std::size_t{0}, set.charts.size(), [&](std::size_t c) {
    const Chart& chart = set.charts[c];
    if (chart.kind != ChartKind::blocks) return;
    Page& page = pages[places[c].page];
    for (const auto face : chart.faces) {
      const Triangle& t = input.mesh.faces[face];
      write_block({holes.color[holes.slot[t[0]]], holes.color[holes.slot[t[1]]], holes.color[holes.slot[t[2]]]},
                  set.corners[face], places[c], page);
    }
  });
}

void paint_unseen(const ChartSet& set, std::span<const ChartPlace> places, const std::array<std::uint8_t, 3>& color,
                  std::span<Page> pages) {
  const Color flat = load(color.data());
  for (std::size_t c = 0; c < set.charts.size(); ++c) {
    if (set.charts[c].kind != ChartKind::blocks) continue;
    for (const auto face : set.charts[c].faces)
      write_block({flat, flat, flat}, set.corners[face], places[c], pages[places[c].page]);
  }
}

}  // namespace gpvc::atlas
