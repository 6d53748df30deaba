// Colours for faces that no photo shows, from around them.
#include <tbb/parallel_for.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>

#include "atlas/baking/baking.h"
#include "io/grouping.h"

namespace gpvc::atlas {

namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// Vertices of unseen faces and the edges between them.
struct Holes {
  std::vector<std::uint32_t> slot;  ///< per mesh vertex: its place in the lists below, or kNone
  std::vector<Color> color;
  std::vector<float> samples;                       ///< colours summed so far; > 0: on a border, so the colour is known
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< of each face, so inner edges are listed twice
};

Holes find_holes(const Mesh& mesh, const ChartSet& set) {
  Holes holes;
  holes.slot.assign(mesh.positions.size(), kNone);
  std::uint32_t count = 0;
  for (const Chart& chart : set.charts) {
    if (chart.kind != ChartKind::unseen) continue;
    for (const auto face : chart.faces) {
      const Triangle& t = mesh.faces[face];
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

/// Mean of the filled texels around a position; nullopt where there is none.
std::optional<Color> color_around(const Page& page, const TexelPoint& p) {
  ColorMean mean;
  const int x0 = static_cast<int>(std::floor(p.x)), y0 = static_cast<int>(std::floor(p.y));
  for (int y = std::max(0, y0 - 1); y <= std::min(page.image.height - 1, y0 + 1); ++y) {
    for (int x = std::max(0, x0 - 1); x <= std::min(page.image.width - 1, x0 + 1); ++x) {
      if (page.state[page.at(x, y)] != TexelState::empty) mean.add(load(page.image.at(x, y)));
    }
  }
  return mean.mean();
}

/// Calls visit(vertex of a hole, page, place on it) for the corners that seen faces have on borders of holes, in face
/// order.
template <typename Visit>
void for_border_corners(const Holes& holes, const AtlasBuild& build, const Visit& visit) {
  const ChartSet& set = build.set;
  for (std::size_t face = 0; face < set.face_chart.size(); ++face) {
    const std::uint32_t c = set.face_chart[face];
    if (c >= set.placed || set.charts[c].kind == ChartKind::unseen) continue;
    for (std::size_t i = 0; i < 3; ++i)
      if (const std::uint32_t slot = holes.slot[build.input.mesh.faces[face][i]]; slot != kNone)
        visit(slot, build.places[c].page, build.places[c].point(set.corners[face][i]));
  }
}

/// A vertex on a border takes the mean of the colours that the seen faces around it have there.
void gather_border(Holes& holes, const AtlasBuild& build) {
  std::size_t kept = 0;
  for_border_corners(holes, build, [&](std::uint32_t slot, std::uint32_t page, const TexelPoint& at) {
    const std::optional<Color> color =
        build.is_early(page) ? build.kept_at_holes.colors[kept++] : color_around(build.pages[page], at);
    if (!color) return;
    holes.color[slot] = holes.color[slot] + *color;
    holes.samples[slot] += 1;
  });
  for (std::size_t i = 0; i < holes.color.size(); ++i)
    if (holes.samples[i] > 0) holes.color[i] = (1 / holes.samples[i]) * holes.color[i];
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
    guess.row(i) = Eigen::RowVector3d(c.r, c.g, c.b);
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
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

/// Writes the 2 x 2 texels of an unseen face whose corners have the given colours.
void write_face(AtlasBuild& build, std::uint32_t face, const std::array<Color, 3>& c) {
  const std::uint32_t chart = build.set.face_chart[face];
  const ChartPlace& place = build.places[chart];
  Page& page = build.page_of(chart);
  const TexelPoint& corner = build.set.corners[face][0];
  const int x = static_cast<int>(corner.x), y = static_cast<int>(corner.y);
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

void want_at_holes(AtlasBuild& build) {
  if (build.set.unseen_faces == 0) return;
  for_border_corners(find_holes(build.input.mesh, build.set), build,
                     [&](std::uint32_t, std::uint32_t page, const TexelPoint& at) {
                       if (build.is_early(page)) build.kept_at_holes.want(page, at);
                     });
}

void keep_at_holes(AtlasBuild& build, std::uint32_t page) {
  build.kept_at_holes.take(page, build.pages[page], color_around);
}

void fill_unseen(AtlasBuild& build) {
  if (build.set.unseen_faces == 0) return;
  const Mesh& mesh = build.input.mesh;
  Holes holes = find_holes(mesh, build.set);
  gather_border(holes, build);
  const std::vector<char> reached = spread(holes);
  make_harmonic(holes, reached);
  if (std::find(reached.begin(), reached.end(), 0) != reached.end()) {
    const Color mean = build.mean_color();
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (!reached[i]) holes.color[i] = mean;
  }
  tbb::parallel_for(std::size_t{0}, build.set.charts.size(), [&](std::size_t c) {
    const Chart& chart = build.set.charts[c];
    if (chart.kind != ChartKind::unseen) return;
    const auto color_of = [&](std::uint32_t vertex) { return holes.color[holes.slot[vertex]]; };
    for (const auto face : chart.faces) {
      const Triangle& t = mesh.faces[face];
      write_face(build, face, {color_of(t[0]), color_of(t[1]), color_of(t[2])});
    }
  });
}

void paint_unseen(AtlasBuild& build) {
  const Color color = load(build.options.unseen_color.data());
  for (const Chart& chart : build.set.charts)
    if (chart.kind == ChartKind::unseen)
      for (const auto face : chart.faces) write_face(build, face, {color, color, color});
}

}  // namespace gpvc::atlas
