#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "io/vector.h"
#include "labeling/background.h"
#include "labeling/background/frame_cells.h"
#include "labeling/costs/photo_lookup.h"

namespace gpvc::labeling {
namespace {

using Color = std::array<float, 3>;

// Noise of photos, as it is left in cells: the sky of compact cameras, which is noisier than what cut-outs have around them,
// reaches a spread of 5 in its corners. Asphalt and carpet in focus are beyond these where they are seen from near.
constexpr float kMostSpread = 6, kMostStep = 4;
/// How far a colour may be from the one that background has beside the silhouette, and how much farther for each cell from
/// there: towards the horizon the sky changes by half of that.
constexpr float kMostDrift = 16, kMostGradient = 0.25;
/// Smooth cells around a cell of background: of asphalt a half are smooth, of the noisiest sky nine tenths.
constexpr double kLeastSmooth = 0.8;
constexpr int kWindow = 5;                 ///< cells to each side, in which they are counted
constexpr double kLeastArea = 0.01;        ///< of a photo
constexpr int kLine = 2;                   ///< cells of something thin, such as a wire, behind which background goes on
constexpr std::size_t kLeastSpot = 16;     ///< cells of a hole in the mesh
constexpr double kSkyRise = 0.1;           ///< sine of the mean angle above the horizon, which is known to some degrees
constexpr double kLeastSurrounding = 0.8;  ///< share of the frame's edge
constexpr double kFollowedSky = 0.2, kFollowedBackdrop = 0.1;  ///< of the frame's diagonal
constexpr float kBlack = 12;                                   ///< JPEG makes a little grey of black
constexpr double kLeastBorder = 0.2;                           ///< share of a photo's edge that is black
constexpr double kMostBorder = 0.2;                            ///< of a photo's width or height
constexpr int kMixed = 2;             ///< pixels beside background that are mixed with it, or ring by JPEG
constexpr float kPixelDistance = 12;  ///< from background's colour, of its single pixels

constexpr Color kBorder{};  // black

/// What a cell shows.
enum class Kind : std::uint8_t {
  other,
  background,
  border,
  leak,  ///< a surface of the background's colour
};

constexpr std::array<std::pair<int, int>, 8> kAround{
    {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

/// Sums over rectangles.
class Integral {
 public:
  void reset(int columns, int rows) {
    stride_ = static_cast<std::size_t>(columns) + 1;
    sums_.assign(stride_ * (static_cast<std::size_t>(rows) + 1), 0);
  }
  /// Row by row.
  void set(int x, int y, bool value) {
    sums_[at(x + 1, y + 1)] = (value ? 1 : 0) + sums_[at(x, y + 1)] + sums_[at(x + 1, y)] - sums_[at(x, y)];
  }
  /// x0 .. x1 - 1, y0 .. y1 - 1.
  std::uint32_t sum(int x0, int y0, int x1, int y1) const {
    return sums_[at(x1, y1)] - sums_[at(x0, y1)] - sums_[at(x1, y0)] + sums_[at(x0, y0)];
  }

 private:
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x); }
  std::size_t stride_ = 0;
  std::vector<std::uint32_t> sums_;
};

struct Place {
  int x, y;
};

/// The share of the frame without a face, from some of its pixels.
double bare_share(const visibility::Ivm& ivm) {
  constexpr int kStride = 8;
  std::size_t bare = 0, looked = 0;
  for (int y = 0; y < ivm.height; y += kStride)
    for (int x = 0; x < ivm.width; x += kStride, ++looked) bare += ivm.at(x, y) == kNoFace ? 1 : 0;
  return static_cast<double>(bare) / static_cast<double>(std::max<std::size_t>(looked, 1));
}

bool is_black(const std::uint8_t* rgb) { return static_cast<float>(std::max({rgb[0], rgb[1], rgb[2]})) <= kBlack; }

/// The share of a photo's edge that is black.
double black_edge(const Image& photo) {
  std::size_t black = 0;
  for (int x = 0; x < photo.width; ++x)
    black += (is_black(photo.at(x, 0)) ? 1U : 0U) + (is_black(photo.at(x, photo.height - 1)) ? 1U : 0U);
  for (int y = 0; y < photo.height; ++y)
    black += (is_black(photo.at(0, y)) ? 1U : 0U) + (is_black(photo.at(photo.width - 1, y)) ? 1U : 0U);
  return static_cast<double>(black) / (2.0 * (photo.width + photo.height));
}

/// The least area of what is no hole in the mesh.
std::size_t least_cells(std::size_t cells) { return static_cast<std::size_t>(kLeastArea * static_cast<double>(cells)); }

/// Whether so many cells at the edge of the frame surround what it shows.
bool surrounds(std::size_t edge, int columns, int rows) {
  return static_cast<double>(edge) >= kLeastSurrounding * 2 * (columns + rows - 2);
}

/// By how much the ray through the middle of a cell rises above the horizon: the sine of the angle.
double rise_of(const View& view, Place cell, const WorldPoint& up) {
  const WorldPoint ray = ray_of(view, {(cell.x + 0.5) * kFrameCell, (cell.y + 0.5) * kFrameCell});
  return dot(ray, up) / length(ray);
}

/// False where find_bare() would find nothing, as in most photos of a flight that look down on the border of the mesh: told from
/// the first pixel of each cell alone. It has no face in any cell that has none. The cells of a sky rise in the mean, so one of
/// them does. Those of what is black have means of kBlack at most and a spread of kMostSpread, and no number of n is farther from
/// their mean than their standard deviation times the root of n - 1.
bool may_have_background(const View& view, const Image& photo, const visibility::Ivm& ivm, const WorldPoint& up,
                         const PhotoLookup& lookup) {
  static const float kBlackPixel = kBlack + kMostSpread * std::sqrt(kFrameCell * kFrameCell - 1.0F) + 1;  // rounding
  const int columns = (ivm.width + kFrameCell - 1) / kFrameCell, rows = (ivm.height + kFrameCell - 1) / kFrameCell;
  std::size_t edge = 0, black = 0;
  std::vector<std::uint32_t> photo_pixels;
  for (int y = 0; y < rows; ++y) {
    bool has_bare = false;
    for (int x = 0; x < columns; ++x) {
      if (ivm.at(x * kFrameCell, y * kFrameCell) != kNoFace) continue;
      if (!has_bare) lookup.find_row(y * kFrameCell, photo_pixels);
      has_bare = true;
      const std::uint32_t pixel = photo_pixels[static_cast<std::size_t>(x) * kFrameCell];
      if (pixel == PhotoLookup::kNoPixel) continue;
      if (rise_of(view, {x, y}, up) > kSkyRise) return true;
      edge += x == 0 || y == 0 || x + 1 == columns || y + 1 == rows ? 1U : 0U;
      const std::uint8_t* rgb = photo.pixels.data() + 3 * std::size_t{pixel};
      black += static_cast<float>(rgb[0] + 2 * rgb[1] + rgb[2]) <= 4 * kBlackPixel ? 1U : 0U;
    }
  }
  const std::size_t cells = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  return surrounds(edge, columns, rows) || (black > 0 && black >= least_cells(cells));
}

}  // namespace

struct BackgroundFinder::State {
  FrameCells cells;
  visibility::ExcludedPixels found;

  void find_bare(const View& view, const WorldPoint& up);
  void follow();
  void add_borders();
  bool mark_pixels(const Image& photo, const PhotoLookup& lookup, const visibility::Ivm& ivm);

 private:
  /// Of a cell that is background and shows faces.
  struct Entry {
    Color color{};            ///< of background where it came over the silhouette
    std::uint32_t depth = 0;  ///< cells from there
  };

  /// Connected background where no face is.
  struct Area {
    std::vector<Place> cells{};
    std::size_t edge = 0;  ///< of the cells, those at the edge of the frame
    double rise = 0;       ///< sum of the sines of the angles by which rays rise
    Color least{255, 255, 255}, most{};
    bool is_sky() const { return rise > kSkyRise * static_cast<double>(cells.size()); }
    bool is_black() const { return std::ranges::max(most) <= kBlack; }
  };

  static bool is_smooth(const FrameCell& from, const FrameCell& to) {
    return to.is_whole && to.spread <= kMostSpread && distance(from.mean, to.mean) <= kMostStep;
  }
  bool is_smooth(int x, int y) const;
  bool is_smooth_around(Place at) const;
  void find_seeds();
  Area flood_bare(Place seed, const View& view, const WorldPoint& up);
  void drop_leaks(std::uint32_t reach);
  bool is_beside_excluded(int x, int y) const;
  template <class Visit>
  void for_each_cell(const Visit& visit) const {
    for (int y = 0; y < cells.rows; ++y)
      for (int x = 0; x < cells.columns; ++x) visit(Place{x, y});
  }
  template <class Visit>
  void around(Place at, const Visit& visit) const {
    for (const auto& [dx, dy] : kAround)
      if (cells.contains(at.x + dx, at.y + dy)) visit(Place{at.x + dx, at.y + dy});
  }
  bool is_at_edge(Place at) const {
    return at.x == 0 || at.y == 0 || at.x + 1 == cells.columns || at.y + 1 == cells.rows;
  }
  std::size_t index_of(Place at) const { return cells.index_of(at.x, at.y); }
  const FrameCell& cell(Place at) const { return cells.cells[index_of(at)]; }

  std::vector<Kind> kind_;  ///< per cell
  bool has_sky_ = false, has_borders_ = false;
  std::vector<std::uint8_t> seeds_;  ///< per cell, 1: smooth, among smooth ones
  std::vector<Entry> entries_;       ///< per cell
  std::vector<Place> queue_;
  Integral smooth_, bare_;
};

/// True for a cell without a face and without a step to those of its neighbours that have none either.
bool BackgroundFinder::State::is_smooth(int x, int y) const {
  const FrameCell& here = cells.at(x, y);
  if (!here.is_bare() || here.spread > kMostSpread) return false;
  return std::ranges::all_of(kAround, [&](const auto& step) {
    return !cells.contains(x + step.first, y + step.second) || !cells.at(x + step.first, y + step.second).is_bare() ||
           is_smooth(here, cells.at(x + step.first, y + step.second));
  });
}

/// True for a cell without a step to its neighbours, whether faces are there or not.
bool BackgroundFinder::State::is_smooth_around(Place at) const {
  return std::ranges::all_of(kAround, [&](const auto& step) {
    const Place other{at.x + step.first, at.y + step.second};
    return cells.contains(other.x, other.y) && is_smooth(cell(at), cell(other));
  });
}

/// Finds smooth cells without a face, most of whose neighbours are smooth.
void BackgroundFinder::State::find_seeds() {
  seeds_.assign(cells.cells.size(), 0);
  smooth_.reset(cells.columns, cells.rows);
  bare_.reset(cells.columns, cells.rows);
  for_each_cell([&](Place at) {
    const bool smooth = is_smooth(at.x, at.y);
    seeds_[index_of(at)] = smooth ? 1 : 0;
    smooth_.set(at.x, at.y, smooth);
    bare_.set(at.x, at.y, cell(at).is_bare());
  });
  for_each_cell([&](Place at) {
    const int x0 = std::max(0, at.x - kWindow), x1 = std::min(cells.columns, at.x + kWindow + 1);
    const int y0 = std::max(0, at.y - kWindow), y1 = std::min(cells.rows, at.y + kWindow + 1);
    if (smooth_.sum(x0, y0, x1, y1) < kLeastSmooth * bare_.sum(x0, y0, x1, y1)) seeds_[index_of(at)] = 0;
  });
}

/// Finds background where no face is.
void BackgroundFinder::State::find_bare(const View& view, const WorldPoint& up) {
  find_seeds();
  has_sky_ = has_borders_ = false;
  kind_.assign(cells.cells.size(), Kind::other);
  std::vector<Area> areas;
  for_each_cell([&](Place at) {
    if (seeds_[index_of(at)] == 0 || kind_[index_of(at)] != Kind::other) return;
    Area area = flood_bare(at, view, up);
    if (area.cells.size() >= kLeastSpot) areas.push_back(std::move(area));
  });
  const std::size_t least = least_cells(cells.cells.size());
  const auto is_large = [&](const Area& area) { return area.cells.size() >= least; };
  std::size_t edge = 0;
  for (const Area& area : areas) edge += is_large(area) ? area.edge : 0;
  const bool surrounding = surrounds(edge, cells.columns, cells.rows);
  std::fill(kind_.begin(), kind_.end(), Kind::other);
  Color least_color{255, 255, 255}, most_color{};
  const auto accept = [&](const Area& area) {
    for (const Place& at : area.cells) kind_[index_of(at)] = Kind::background;
  };
  for (const Area& area : areas) {
    if (!is_large(area) || !(surrounding || area.is_sky() || area.is_black())) continue;
    accept(area);
    has_sky_ |= area.is_sky();
    for (std::size_t c = 0; c < 3; ++c) {
      least_color[c] = std::min(least_color[c], area.least[c]);
      most_color[c] = std::max(most_color[c], area.most[c]);
    }
  }
  // Holes of the mesh through which the same is seen.
  for (const Area& area : areas) {
    bool same = !is_large(area) && (surrounding || area.is_sky() || area.is_black());
    for (std::size_t c = 0; c < 3; ++c) same = same && area.least[c] >= least_color[c] && area.most[c] <= most_color[c];
    if (same) accept(area);
  }
}

/// Takes a seed and all bare cells that it goes on to without a step.
BackgroundFinder::State::Area BackgroundFinder::State::flood_bare(Place seed, const View& view, const WorldPoint& up) {
  Area area;
  area.cells.push_back(seed);
  kind_[index_of(seed)] = Kind::background;
  for (std::size_t next = 0; next < area.cells.size(); ++next) {
    const Place from = area.cells[next];
    area.rise += rise_of(view, from, up);
    area.edge += is_at_edge(from) ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      area.least[c] = std::min(area.least[c], cell(from).mean[c]);
      area.most[c] = std::max(area.most[c], cell(from).mean[c]);
    }
    around(from, [&](Place to) {
      if (kind_[index_of(to)] != Kind::other || !cell(to).is_bare() || !is_smooth(cell(from), cell(to))) return;
      // Along a smooth line between other surfaces there are no seeds, and background does not creep there.
      if (seeds_[index_of(from)] == 0 && seeds_[index_of(to)] == 0) return;
      kind_[index_of(to)] = Kind::background;
      area.cells.push_back(to);
    });
  }
  return area;
}

/// Follows it over the mesh's silhouettes.
void BackgroundFinder::State::follow() {
  const auto reach = static_cast<std::uint32_t>(
      std::lround((has_sky_ ? kFollowedSky : kFollowedBackdrop) * std::hypot(cells.width, cells.height) / kFrameCell));
  entries_.assign(cells.cells.size(), {});
  queue_.clear();
  for_each_cell([&](Place at) {
    if (kind_[index_of(at)] != Kind::other) queue_.push_back(at);
  });
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const Place from = queue_[next];
    const Entry& entry = entries_[index_of(from)];
    if (entry.depth == reach) continue;
    const Entry deeper{entry.depth == 0 ? cell(from).mean : entry.color, entry.depth + 1};
    const float drift = kMostDrift + kMostGradient * static_cast<float>(deeper.depth);
    const auto follow_to = [&](Place to) {
      if (kind_[index_of(to)] != Kind::other || cell(to).is_bare() || !is_smooth(cell(from), cell(to))) return false;
      if (distance(deeper.color, cell(to).mean) > drift) return false;
      kind_[index_of(to)] = Kind::background;
      entries_[index_of(to)] = deeper;
      queue_.push_back(to);
      return true;
    };
    for (const auto& [dx, dy] : kAround)
      for (int step = 1; step <= kLine + 1; ++step) {
        const Place to{from.x + step * dx, from.y + step * dy};
        if (!cells.contains(to.x, to.y) || kind_[index_of(to)] != Kind::other) break;
        if ((step == 1 || is_smooth_around(to)) && follow_to(to)) break;
      }
  }
  drop_leaks(reach);
}

/// Where background would be deeper than `reach`, the surface has its colour: from there back to the silhouette nothing is
/// background.
void BackgroundFinder::State::drop_leaks(std::uint32_t reach) {
  std::vector<std::pair<Place, std::uint32_t>> leaks;
  for (const Place& at : queue_)
    if (entries_[index_of(at)].depth == reach) {
      kind_[index_of(at)] = Kind::leak;
      leaks.emplace_back(at, 0);
    }
  for (std::size_t next = 0; next < leaks.size(); ++next) {
    const auto [from, steps] = leaks[next];
    if (steps == reach) continue;
    around(from, [&, steps = steps](Place to) {
      if (kind_[index_of(to)] != Kind::background || entries_[index_of(to)].depth == 0) return;
      kind_[index_of(to)] = Kind::leak;
      leaks.emplace_back(to, steps + 1);
    });
  }
}

/// Adds the black that is met from the photo's edge on.
void BackgroundFinder::State::add_borders() {
  has_borders_ = true;
  const auto run = [&](Place at, int dx, int dy, int most) {
    for (int step = 0; step < most; ++step, at.x += dx, at.y += dy) {
      const FrameCell& here = cell(at);
      if (!here.is_whole || here.spread > kMostSpread || std::ranges::max(here.mean) > kBlack) return;
      if (!here.is_bare()) kind_[index_of(at)] = Kind::border;
    }
  };
  const auto widest = [](int cells_across) { return static_cast<int>(kMostBorder * cells_across); };
  for (int x = 0; x < cells.columns; ++x) {
    run({x, 0}, 0, 1, widest(cells.rows));
    run({x, cells.rows - 1}, 0, -1, widest(cells.rows));
  }
  for (int y = 0; y < cells.rows; ++y) {
    run({0, y}, 1, 0, widest(cells.columns));
    run({cells.columns - 1, y}, -1, 0, widest(cells.columns));
  }
}

/// Excludes the pixels that show faces in cells of background and of borders, in the cells beside them those of the same
/// colour, and those that are mixed with it.
bool BackgroundFinder::State::mark_pixels(const Image& photo, const PhotoLookup& lookup, const visibility::Ivm& ivm) {
  found.all = found.background = found.mixed = visibility::PixelSet(cells.width, cells.height);
  bool any = false;
  std::vector<std::pair<Place, Kind>> beside;
  const auto for_each_face_pixel = [&](Place at, const auto& visit) {
    const CellBox box = cells.box(at.x, at.y);
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x)
        if (ivm.at(x, y) != kNoFace) visit(x, y);
  };
  const auto add = [&](int x, int y, Kind kind) {
    found.all.add(x, y);
    if (kind == Kind::background) found.background.add(x, y);
    any = true;
  };
  for_each_cell([&](Place at) {
    if (cell(at).faces == 0) return;
    if (kind_[index_of(at)] == Kind::leak) return;
    if (const Kind kind = kind_[index_of(at)]; kind != Kind::other)
      return for_each_face_pixel(at, [&](int x, int y) { add(x, y, kind); });
    Kind kind = has_borders_ && is_at_edge(at) ? Kind::border : Kind::other;
    const Color* color = &kBorder;
    around(at, [&](Place other) {
      if (kind_[index_of(other)] == Kind::other || kind_[index_of(other)] == Kind::leak) return;
      kind = kind_[index_of(other)];
      color = &cell(other).mean;
    });
    if (kind == Kind::other) return;
    beside.emplace_back(at, kind);
    for_each_face_pixel(at, [&](int x, int y) {
      const auto pixel = lookup.pixel(x, y);
      if (!pixel) return;
      const std::uint8_t* rgb = photo.pixels.data() + 3 * *pixel;
      const Color here{static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
      if (distance(*color, here) <= kPixelDistance) add(x, y, kind);
    });
  });
  if (!any) return false;
  std::vector<std::pair<Place, Kind>> mixed;
  for (const auto& each : beside)
    for_each_face_pixel(each.first, [&](int x, int y) {
      if (!found.all.contains(x, y) && is_beside_excluded(x, y)) mixed.push_back({{x, y}, each.second});
    });
  for (const auto& [at, kind] : mixed) {
    found.all.add(at.x, at.y);
    if (kind == Kind::background) found.mixed.add(at.x, at.y);
  }
  return true;
}

bool BackgroundFinder::State::is_beside_excluded(int x, int y) const {
  for (int py = std::max(0, y - kMixed); py <= std::min(cells.height - 1, y + kMixed); ++py)
    for (int px = std::max(0, x - kMixed); px <= std::min(cells.width - 1, x + kMixed); ++px)
      if (found.all.contains(px, py)) return true;
  return false;
}

BackgroundFinder::BackgroundFinder() : state_(std::make_unique<State>()) {}
BackgroundFinder::~BackgroundFinder() = default;
const visibility::ExcludedPixels& BackgroundFinder::found() const { return state_->found; }

bool BackgroundFinder::find(const View& view, const Image& photo, const io::PhotoExclusion* excluded,
                            const visibility::Ivm& ivm, const WorldPoint& up) {
  const bool has_bare = bare_share(ivm) >= kLeastArea;
  const bool has_border = view.camera.distortion.is_identity() && black_edge(photo) >= kLeastBorder;
  if (!has_bare && !has_border) return false;
  const PhotoLookup lookup(view.camera);
  if (!has_border && !may_have_background(view, photo, ivm, up, lookup)) return false;
  state_->cells.fill(view.camera, photo, excluded, ivm);
  state_->find_bare(view, up);
  state_->follow();
  if (has_border) state_->add_borders();
  return state_->mark_pixels(photo, lookup, ivm);
}

}  // namespace gpvc::labeling
