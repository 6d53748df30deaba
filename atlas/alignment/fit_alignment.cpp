// Fields of shifts that explain what photos show of each other: smooth, and no larger than it takes.
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "atlas/alignment/alignment.h"
#include "atlas/alignment/patch.h"
#include "io/grouping.h"
#include "io/order_statistics.h"

namespace gpvc::atlas {

namespace {

/// Cells of a field along the longer edge of a frame.
constexpr int kCells = 32;
/// A match is known no better than this, px: errors of the mesh move places of both photos apart.
constexpr double kLeastError = 0.5;
/// Matches that are farther off than this, px, count less and less (Cauchy).
constexpr double kOutlying = 1;
/// The weight of the squared difference of neighbouring nodes, beside that of a match that is known best.
constexpr double kSmooth = 10;
/// The weight of all squared shifts of a photo is that of kPriorMatches, and kAnchor times that of its own matches. It keeps the
/// shifts of the photos of a place about zero in the mean, which matches leave open, and photos that few places speak for where they
/// are. Where the mesh is wrong, photos held out want small shifts, where poses are, large ones (benchmarks/README.md).
constexpr double kAnchor = 0.2, kPriorMatches = 2;
/// More than a match can tell, px, and far less than could move a texel to another thing.
constexpr double kMostShift = 16;

using Shift = std::array<double, 2>;
using Shifts = std::vector<Shift>;  ///< per node

/// A position of a frame: a node, and how far it lies from there to the next ones, in cells.
struct Lookup {
  std::uint32_t node = 0, columns = 0;
  float x = 0, y = 0;

  template <class Use>
  void each_node(const Use& use) const {
    const double right = double{x}, below = double{y};
    use(node, (1 - right) * (1 - below));
    use(node + 1, right * (1 - below));
    use(node + columns, (1 - right) * below);
    use(node + columns + 1, right * below);
  }
};

/// The nodes of a view's field, among those of all.
struct Grid {
  std::uint32_t first = 0, columns = 0, rows = 0;
  double spacing = 1;
  double anchor = 0;  ///< of each node

  std::uint32_t nodes() const { return columns * rows; }
  Lookup at(double x, double y) const {
    const double u = std::clamp(x / spacing, 0.0, columns - 1.0), v = std::clamp(y / spacing, 0.0, rows - 1.0);
    const auto column = std::min(static_cast<std::uint32_t>(u), columns - 2);
    const auto row = std::min(static_cast<std::uint32_t>(v), rows - 2);
    return {first + row * columns + column, columns, static_cast<float>(u - column), static_cast<float>(v - row)};
  }
};

Grid grid_of(const Camera& camera, std::uint32_t first) {
  Grid grid;
  grid.first = first;
  grid.spacing = std::max({camera.width, camera.height, kCells}) / double{kCells};
  const auto nodes = [&](int edge) {
    return static_cast<std::uint32_t>(std::max(2.0, std::ceil(edge / grid.spacing) + 1));
  };
  grid.columns = nodes(camera.width);
  grid.rows = nodes(camera.height);
  return grid;
}

/// first_from_second s2 - s1 is to be `shift`, in pixels of the first frame.
struct Equation {
  std::array<Lookup, 2> at;
  std::array<double, 4> first_from_second{};
  Shift shift{};
  std::array<double, 3> information{};  ///< in units of 1 / kLeastError^2, at most 1
  double weight = 1;

  double squared(const Shift& r) const {
    const auto& [xx, xy, yy] = information;
    return std::max(0.0, (xx * r[0] * r[0] + 2 * xy * r[0] * r[1] + yy * r[1] * r[1]) / (kOutlying * kOutlying));
  }
};

/// With eigenvalues below 1, which stands for kLeastError.
std::array<double, 3> limited(const std::array<float, 3>& information) {
  // I (1 + I)^-1 has eigenvalues i / (1 + i).
  constexpr double kUnit = kLeastError * kLeastError;
  const double xx = double{information[0]} * kUnit, xy = double{information[1]} * kUnit,
               yy = double{information[2]} * kUnit;
  const double determinant = (1 + xx) * (1 + yy) - xy * xy;
  const double a = (1 + yy) / determinant, b = -xy / determinant, d = (1 + xx) / determinant;  // the inverse
  return {xx * a + xy * b, xx * b + xy * d, xy * b + yy * d};
}

Shift at(const Lookup& lookup, const Shifts& shifts) {
  Shift sum{};
  lookup.each_node([&](std::uint32_t node, double share) {
    for (std::size_t i = 0; i < 2; ++i) sum[i] += share * shifts[node][i];
  });
  return sum;
}

/// What the shifts have in place of the equation's.
Shift difference(const Equation& equation, const Shifts& shifts) {
  const Shift first = at(equation.at[0], shifts), second = at(equation.at[1], shifts);
  const auto& m = equation.first_from_second;
  return {m[0] * second[0] + m[1] * second[1] - first[0], m[2] * second[0] + m[3] * second[1] - first[1]};
}

Shift residual(const Equation& equation, const Shifts& shifts) {
  const auto [x, y] = difference(equation, shifts);
  return {equation.shift[0] - x, equation.shift[1] - y};
}

double dot(const Shifts& a, const Shifts& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i][0] * b[i][0] + a[i][1] * b[i][1];
  return sum;
}

/// Least squares, weighed anew by how far off matches are (Holland and Welsch 1977), by conjugate gradients.
class Solver {
 public:
  /// Borrows the grids.
  Solver(const std::vector<Grid>& grids, std::vector<Equation> equations)
      : grids_(grids), equations_(std::move(equations)) {
    std::vector<std::uint32_t> view_of(nodes());
    for (std::uint32_t v = 0; v < grids.size(); ++v) std::fill_n(view_of.begin() + grids[v].first, grids[v].nodes(), v);
    sides_ = group_items<Side>(grids.size(), [&](const auto& emit) {
      for (std::uint32_t e = 0; e < equations_.size(); ++e)
        for (std::uint32_t side = 0; side < 2; ++side) emit(view_of[equations_[e].at[side].node], Side{e, side});
    });
    pulls_.resize(equations_.size());
  }

  Shifts solve() {
    // At first all photos may be far off (graduated non-convexity, Blake and Zisserman 1987).
    constexpr std::array kScales{8.0, 4.0, 2.0, 1.0, 1.0};
    Shifts shifts(nodes());
    for (const double scale : kScales) {
      each_equation([&](Equation& equation, Shift&) {
        equation.weight = 1 / (1 + equation.squared(residual(equation, shifts)) / (scale * scale));
      });
      improve(shifts);
    }
    return shifts;
  }

 private:
  struct Side {
    std::uint32_t equation = 0, side = 0;
  };

  std::size_t nodes() const { return grids_.empty() ? 0 : grids_.back().first + grids_.back().nodes(); }

  template <class Use>
  void each_equation(const Use& use) {
    tbb::parallel_for(std::size_t{0}, equations_.size(), [&](std::size_t e) { use(equations_[e], pulls_[e]); });
  }

  static Shift weighed(const Equation& equation, const Shift& r) {
    const auto& [xx, xy, yy] = equation.information;
    return {equation.weight * (xx * r[0] + xy * r[1]), equation.weight * (xy * r[0] + yy * r[1])};
  }

  /// Sums of the pulls by node. Those of a view's nodes are added in the order of the equations.
  void gather(Shifts& sums, const Shifts* shifts) const {
    tbb::parallel_for(std::size_t{0}, grids_.size(), [&](std::size_t v) {
      const Grid& grid = grids_[v];
      std::fill_n(sums.begin() + grid.first, grid.nodes(), Shift{});
      for (const auto& [e, side] : std::as_const(sides_)[v]) {
        const Equation& equation = equations_[e];
        const Shift& pull = pulls_[e];
        const auto& m = equation.first_from_second;
        const Shift mine = side == 0 ? Shift{-pull[0], -pull[1]}
                                     : Shift{m[0] * pull[0] + m[2] * pull[1], m[1] * pull[0] + m[3] * pull[1]};
        equation.at[side].each_node([&](std::uint32_t node, double share) {
          for (std::size_t i = 0; i < 2; ++i) sums[node][i] += share * mine[i];
        });
      }
      if (shifts != nullptr) add_smoothness(grid, *shifts, sums);
    });
  }

  static void add_smoothness(const Grid& grid, const Shifts& shifts, Shifts& sums) {
    for (std::uint32_t row = 0; row < grid.rows; ++row) {
      for (std::uint32_t column = 0; column < grid.columns; ++column) {
        const std::uint32_t here = grid.first + row * grid.columns + column;
        for (std::size_t i = 0; i < 2; ++i) {
          sums[here][i] += grid.anchor * shifts[here][i];
          const auto smooth = [&](std::uint32_t next) {
            const double step = kSmooth * (shifts[here][i] - shifts[next][i]);
            sums[here][i] += step;
            sums[next][i] -= step;
          };
          if (column + 1 < grid.columns) smooth(here + 1);
          if (row + 1 < grid.rows) smooth(here + grid.columns);
        }
      }
    }
  }

  /// The matrix of the normal equations times the shifts.
  void multiply(const Shifts& shifts, Shifts& product) {
    each_equation([&](Equation& equation, Shift& pull) { pull = weighed(equation, difference(equation, shifts)); });
    gather(product, &shifts);
  }

  void improve(Shifts& shifts) {
    Shifts right(shifts.size()), product(shifts.size());
    each_equation([](Equation& equation, Shift& pull) { pull = weighed(equation, equation.shift); });
    gather(right, nullptr);
    multiply(shifts, product);
    Shifts rest = right;
    for (std::size_t n = 0; n < rest.size(); ++n)
      for (std::size_t i = 0; i < 2; ++i) rest[n][i] -= product[n][i];
    Shifts direction = rest;
    double rest2 = dot(rest, rest);
    const double enough = 1e-6 * dot(right, right);  // a thousandth of a shift
    constexpr int kMostSteps = 100;
    for (int step = 0; step < kMostSteps && rest2 > enough; ++step) {
      multiply(direction, product);
      const double length = rest2 / dot(direction, product);
      for (std::size_t n = 0; n < rest.size(); ++n) {
        for (std::size_t i = 0; i < 2; ++i) {
          shifts[n][i] += length * direction[n][i];
          rest[n][i] -= length * product[n][i];
        }
      }
      const double before = std::exchange(rest2, dot(rest, rest));
      for (std::size_t n = 0; n < rest.size(); ++n)
        for (std::size_t i = 0; i < 2; ++i) direction[n][i] = rest[n][i] + rest2 / before * direction[n][i];
    }
  }

  const std::vector<Grid>& grids_;
  std::vector<Equation> equations_;
  Grouped<Side> sides_;       ///< by view
  std::vector<Shift> pulls_;  ///< per equation, of the first photo's shift
};

/// The value in the middle; 0 of none.
double median(std::vector<double> values) { return values.empty() ? 0 : upper_median(std::span(values)); }

class Fit {
 public:
  Fit(const Scene& scene, std::span<const PhotoMatch> matches) : matches_(matches) {
    std::vector<std::size_t> count(scene.views.size(), 0);
    for (const PhotoMatch& match : matches)
      for (const std::uint32_t view : match.views) ++count[view];
    std::uint32_t nodes = 0;
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      Grid& grid = grids_.emplace_back(Grid{nodes});
      if (count[v] == 0) continue;
      grid = grid_of(scene.views[v].camera, nodes);
      grid.anchor = (kPriorMatches + kAnchor * static_cast<double>(count[v])) / grid.nodes();
      nodes += grid.nodes();
    }
    for (const PhotoMatch& match : matches) {
      std::array<double, 4> change{};
      std::ranges::copy(match.second_from_first, change.begin());
      Equation equation;
      equation.at = {grids_[match.views[0]].at(double{match.at[0]}, double{match.at[1]}),
                     grids_[match.views[1]].at(double{match.at[2]}, double{match.at[3]})};
      equation.first_from_second = inverse(change).value_or(std::array<double, 4>{});
      equation.shift = {double{match.shift[0]}, double{match.shift[1]}};
      equation.information = limited(match.information);
      equations_.push_back(equation);
    }
  }

  AlignmentFit fit() const {
    AlignmentFit result;
    result.fields.resize(grids_.size());
    AlignmentStatistics& statistics = result.statistics;
    statistics.matches = matches_.size();
    if (!gains(statistics)) return result;
    const Shifts shifts = Solver(grids_, equations_).solve();
    measure(shifts, statistics);
    // Where photos fit each other already, what is left is noise.
    constexpr double kLeastShift = 0.1;  // px
    if (statistics.shift_px >= kLeastShift) result.fields = fields_of(shifts);
    return result;
  }

 private:
  /// True if a fit to four fifths of the places explains the others: a field that follows noise does not.
  bool gains(AlignmentStatistics& result) const {
    std::vector<Equation> fitted;
    std::vector<std::size_t> left_out;
    std::size_t place = 0;
    for (std::size_t i = 0; i < equations_.size(); ++i) {
      const bool is_same = i > 0 && matches_[i].views[0] == matches_[i - 1].views[0] &&
                           matches_[i].at[0] == matches_[i - 1].at[0] && matches_[i].at[1] == matches_[i - 1].at[1];
      if (!is_same) ++place;
      if (place % 5 == 0)
        left_out.push_back(i);
      else
        fitted.push_back(equations_[i]);
    }
    const Shifts shifts = Solver(grids_, std::move(fitted)).solve();
    double before = 0, after = 0;
    std::vector<double> px_before, px_after;
    for (const std::size_t i : left_out) {
      const Equation& equation = equations_[i];
      const Shift left = residual(equation, shifts);
      before += std::log1p(equation.squared(equation.shift));
      after += std::log1p(equation.squared(left));
      std::array<double, 3> information{};
      std::ranges::copy(matches_[i].information, information.begin());
      px_before.push_back(misfit(equation.shift[0], equation.shift[1], information));
      px_after.push_back(misfit(left[0], left[1], information));
    }
    result.before_px = median(std::move(px_before));
    result.after_px = median(std::move(px_after));
    constexpr double kGain = 0.9;
    return after < kGain * before;
  }

  /// How large the shifts are where there are matches, and how much of them a pose or a focal length explains.
  void measure(const Shifts& shifts, AlignmentStatistics& result) const {
    std::vector<std::vector<std::pair<PixelPoint, Shift>>> of_view(grids_.size());
    for (std::size_t i = 0; i < matches_.size(); ++i)
      for (std::size_t side = 0; side < 2; ++side)
        of_view[matches_[i].views[side]].push_back(
            {{double{matches_[i].at[2 * side]}, double{matches_[i].at[2 * side + 1]}},
             at(equations_[i].at[side], shifts)});
    double all = 0, left = 0;
    std::size_t count = 0;
    for (std::size_t v = 0; v < of_view.size(); ++v) {
      const double size = grids_[v].spacing * kCells;
      Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
      Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
      const auto row = [&](const PixelPoint& p) { return Eigen::Vector3d(1, p.x / size, p.y / size); };
      for (const auto& [p, s] : of_view[v]) {
        normal += row(p) * row(p).transpose();
        right += row(p) * Eigen::RowVector2d(s[0], s[1]);
      }
      const Eigen::Matrix<double, 3, 2> affine = normal.ldlt().solve(right);
      for (const auto& [p, s] : of_view[v]) {
        const Eigen::RowVector2d shift(s[0], s[1]);
        all += shift.squaredNorm();
        left += (shift - row(p).transpose() * affine).squaredNorm();
      }
      count += of_view[v].size();
    }
    if (count == 0 || all == 0) return;
    result.shift_px = std::sqrt(all / static_cast<double>(count));
    result.affine_share = std::clamp(1 - left / all, 0.0, 1.0);
  }

  std::vector<ShiftField> fields_of(const Shifts& shifts) const {
    std::vector<ShiftField> fields(grids_.size());
    for (std::size_t v = 0; v < grids_.size(); ++v) {
      const Grid& grid = grids_[v];
      if (grid.nodes() == 0) continue;  // nothing is compared with it
      ShiftField& field = fields[v];
      field.columns = static_cast<int>(grid.columns);
      field.rows = static_cast<int>(grid.rows);
      field.spacing = grid.spacing;
      for (std::uint32_t i = 0; i < grid.nodes(); ++i) {
        const auto& [x, y] = shifts[grid.first + i];
        const auto bounded = [](double value) {
          return static_cast<float>(std::clamp(value, -kMostShift, kMostShift));
        };
        field.nodes.push_back({bounded(x), bounded(y)});
      }
    }
    return fields;
  }

  std::span<const PhotoMatch> matches_;
  std::vector<Grid> grids_;
  std::vector<Equation> equations_;  ///< per match
};

/// What a shift is bounded to, px.
bool is_small(float shift) { return std::abs(shift) <= static_cast<float>(kMostShift); }

}  // namespace

bool is_sound(const PhotoMatch& match, const Scene& scene) {
  const auto is_finite = [](float value) { return std::isfinite(value); };
  const auto is_reached = [](float shift) { return is_small(shift); };
  // Patches are compared where both views show a place about alike. Larger numbers would end in sums that are none.
  constexpr float kMostChange = 64, kMostInformation = 1e9f;
  const auto is_change = [](float value) { return std::abs(value) <= kMostChange; };
  const auto& [xx, xy, yy] = match.information;
  // The information of a straight edge is a singular matrix: xy^2 equals xx yy, up to rounding. Each of these four sums of 256 floats
  // is off by some 40 times 6e-8 of itself.
  constexpr double kRounding = 1 + 1e-5;
  return std::ranges::all_of(match.views, [&](std::uint32_t view) { return view < scene.views.size(); }) &&
         std::ranges::all_of(match.at, is_finite) && std::ranges::all_of(match.shift, is_reached) && xx >= 0 &&
         yy >= 0 && xx <= kMostInformation && yy <= kMostInformation &&
         double{xy} * double{xy} <= kRounding * double{xx} * double{yy} &&
         std::ranges::all_of(match.second_from_first, is_change);
}

bool is_sound(const ShiftField& field) {
  if (field.nodes.empty()) return true;
  constexpr int kMostNodes = 2 * kCells;
  const auto is_count = [](int nodes) { return nodes >= 2 && nodes <= kMostNodes; };
  return is_count(field.columns) && is_count(field.rows) &&
         field.nodes.size() == static_cast<std::size_t>(field.columns) * static_cast<std::size_t>(field.rows) &&
         field.spacing > 0 && std::isfinite(field.spacing) &&
         std::ranges::all_of(field.nodes, [](const auto& node) { return is_small(node[0]) && is_small(node[1]); });
}

std::vector<ShiftField> reduced(std::vector<ShiftField> fields, double reduction) {
  for (ShiftField& field : fields) {
    field.spacing /= reduction;
    for (auto& node : field.nodes)
      for (float& shift : node) shift = static_cast<float>(double{shift} / reduction);
  }
  return fields;
}

AlignmentFit fit_alignment(const Scene& scene, std::span<const PhotoMatch> matches) {
  return Fit(scene, matches).fit();
}

}  // namespace gpvc::atlas
