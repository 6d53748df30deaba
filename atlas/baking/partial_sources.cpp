#include "atlas/baking/partial_sources.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "atlas/baking/pages.h"
#include "atlas/charts/flat_chart.h"
#include "atlas/leveling/seam_strips.h"

namespace gpvc::atlas {

namespace {

std::optional<TexelTriangle> outline_in(const visibility::FaceCoverage& entry, const Mesh& mesh, const View& view) {
  const std::optional<ProjectedFace> projected = project_face(mesh, static_cast<std::uint32_t>(entry.face), view);
  if (!projected) return std::nullopt;
  TexelTriangle outline = projected->corners;
  for (TexelPoint& p : outline) p = {p.x - entry.x0, p.y - entry.y0};
  return outline;
}

/// Words of bits for a row of the coverage's box.
std::size_t row_words(const visibility::FaceCoverage& entry) {
  return (static_cast<std::size_t>(entry.width) + 63) / 64;
}

/// Sets bits from `first` to `last` of a row whose first word is `row`, where the coverage does not have the pixel.
void set_hidden(const visibility::CoverageTable& table, const visibility::FaceCoverage& entry, int y, int first,
                int last, std::span<std::uint64_t> row) {
  const std::size_t line = pixel_index(0, y, entry.width);
  for (int begin = first / 64 * 64; begin <= last; begin += 64) {
    const std::size_t bit = line + static_cast<std::size_t>(begin), shift = bit % 64;
    const std::uint64_t* word = table.words.data() + entry.first_word + bit / 64;
    const int low = std::max(first - begin, 0), high = std::min(last - begin, 63);
    std::uint64_t seen = word[0] >> shift;
    if (shift > 0 && 64 - static_cast<int>(shift) <= high) seen |= word[1] << (64 - shift);
    const std::uint64_t asked = (~std::uint64_t{0} << low) & (~std::uint64_t{0} >> (63 - high));
    row[static_cast<std::size_t>(begin) / 64] |= ~seen & asked;
  }
}

/// Adds to a picture of bits, rows of so many words, those beside its own, in rows and columns.
void grow(std::vector<std::uint64_t>& bits, std::size_t words) {
  for (std::size_t first = 0; first < bits.size(); first += words) {
    std::uint64_t left = 0;  // as it was
    for (std::size_t i = first; i < first + words; ++i) {
      const std::uint64_t own = bits[i], right = i + 1 < first + words ? bits[i + 1] : 0;
      bits[i] |= own << 1 | left >> 63 | own >> 1 | right << 63;
      left = own;
    }
  }
  std::vector<std::uint64_t> above(words, 0);  // as they were
  for (std::size_t first = 0; first < bits.size(); first += words)
    for (std::size_t w = 0; w < words; ++w) {
      const std::size_t i = first + w;
      const std::uint64_t own = bits[i], below = i + words < bits.size() ? bits[i + words] : 0;
      bits[i] |= above[w] | below;
      above[w] = own;
    }
}

/// True if all pixels whose centres lie in the outline are of the coverage's box.
bool has_pixels_of(const visibility::FaceCoverage& entry, const TexelTriangle& outline) {
  return std::ranges::all_of(outline, [&](const TexelPoint& p) {
    return p.x >= -0.5 && p.y >= -0.5 && p.x <= entry.width + 0.5 && p.y <= entry.height + 0.5;
  });
}

/// Clearance over the coverage's box: pixels within margin_px (chessboard distance) of one where the face is hidden are
/// near an occluder, their neighbours beside it. Empty where none is.
Clearance find_clearance(const visibility::CoverageTable& table, const visibility::FaceCoverage& entry,
                         const std::optional<TexelTriangle>& outline, int margin_px) {
  Clearance clearance;
  if (margin_px <= 0 || !outline) return clearance;
  clearance.words = row_words(entry);
  std::vector<std::uint64_t> near(clearance.words * static_cast<std::size_t>(entry.height), 0);
  triangle_spans(*outline, 0.0, {0, 0, entry.width, entry.height}, [&](int y, int first, int last) {
    set_hidden(table, entry, y, first, last,
               std::span(near).subspan(static_cast<std::size_t>(y) * clearance.words, clearance.words));
  });
  // Most faces are hidden nowhere.
  if (std::ranges::all_of(near, [](std::uint64_t word) { return word == 0; })) {
    clearance.is_whole = has_pixels_of(entry, *outline);
    return clearance;
  }
  for (int distance = 1; distance <= margin_px; ++distance) {
    grow(near, clearance.words);
    if (distance == 1) clearance.beside = near;
  }
  clearance.near = std::move(near);
  return clearance;
}

/// \pre the position is not far from the frame
std::array<int, 2> pixel_around(const PixelPoint& p) {
  // Compilers call a function for floor(), unless they may count on processors later than x86-64's first.
  const auto below = [](double value) {
    const int whole = static_cast<int>(value);
    return whole - (value < whole ? 1 : 0);
  };
  return {below(p.x), below(p.y)};
}

/// The pixel whose coverage decides for a place on the face. Coverage is known at pixel centres inside the face: where
/// the centre of the place's own pixel lies outside, the nearest neighbouring pixel whose centre lies inside decides.
// Not inlined: few places need it, and those that do not are faster without its code around them.
[[gnu::noinline]] std::array<int, 2> deciding_pixel(const TexelSource& source, const PixelPoint& p) {
  const auto [px, py] = pixel_around(p);
  const visibility::FaceCoverage& c = *source.coverage;
  const auto in_face = [&](int x, int y) { return contains(*source.outline, x + 0.5 - c.x0, y + 0.5 - c.y0); };
  if (!source.outline || in_face(px, py)) return {px, py};
  std::array<int, 2> nearest{px, py};
  double least2 = 1e9;
  for (int y = py - 1; y <= py + 1; ++y)
    for (int x = px - 1; x <= px + 1; ++x) {
      const double dx = x + 0.5 - p.x, dy = y + 0.5 - p.y, distance2 = dx * dx + dy * dy;
      if (distance2 >= least2 || !in_face(x, y)) continue;
      least2 = distance2;
      nearest = {x, y};
    }
  return nearest;
}

/// Candidate views of a face that are looked at.
constexpr std::size_t kMostCandidates = 64;

/// Candidate views of a face: the label, then the others by cost.
std::vector<ViewId> ordered_candidates(const AtlasInput& input, std::uint32_t face) {
  std::vector<std::pair<float, std::uint32_t>> others;
  const ViewId label = input.labels[face];
  if (face < input.candidates.faces()) {
    const auto views = input.candidates.views_of(face);
    const auto costs = input.candidates.costs_of(face);
    for (std::size_t k = 0; k < views.size(); ++k)
      if (ViewId{views[k]} != label) others.emplace_back(costs[k], views[k]);
  }
  std::sort(others.begin(), others.end());
  std::vector<ViewId> result{label};
  for (const auto& [cost, view] : others)
    if (result.size() < kMostCandidates) result.push_back(ViewId{view});
  return result;
}

/// Calls visit(texel, x, y) for the texels of a chart's partial_box(), in blocks of kStripRow x kStripRow.
template <typename Visit>
void for_blocks(const CellBox& box, const Visit& visit) {
  for (int by = box.y0; by < box.y1; by += kStripRow)
    for (int bx = box.x0; bx < box.x1; bx += kStripRow)
      for (int y = by; y < std::min(by + kStripRow, box.y1); ++y)
        for (int x = bx; x < std::min(bx + kStripRow, box.x1); ++x)
          visit(pixel_index(x - box.x0, y - box.y0, box.x1 - box.x0), x, y);
}

/// The order of a chart's texels in for_blocks().
std::array<std::uint32_t, 4> block_order(std::uint32_t texel, const CellBox& box) {
  const auto width = static_cast<std::uint32_t>(box.x1 - box.x0), edge = std::uint32_t{kStripRow};
  const std::uint32_t x = texel % width, y = texel / width;
  return {y / edge, x / edge, y, x};
}

/// Makes one partial chart and chooses the sources of its texels.
class SourceChooser {
 public:
  SourceChooser(const AtlasInput& input, const AtlasOptions& options, const ChartSet& set,
                const CoverageIndex& coverage)
      : input_(input), options_(options), set_(set), coverage_(coverage), table_(coverage.table()) {}

  PartialChart choose(std::uint32_t chart) {
    start(chart);
    choose_best();
    for (int y = raster_.box.y0; y < raster_.box.y1; y += kStripRow)
      for (int x = raster_.box.x0; x < raster_.box.x1; x += kStripRow)
        choose_second({x, y, std::min(x + kStripRow, raster_.box.x1), std::min(y + kStripRow, raster_.box.y1)});
    return finish(chart);
  }

 private:
  static constexpr std::uint8_t kNone = 255;
  /// The choice for a texel.
  struct Choice {
    std::uint8_t best = kNone;    ///< of its owner's sources
    std::uint8_t second = kNone;  ///< blended in close to texels of another view
    std::uint8_t blend = 0;       ///< weight of the second source, in steps of 1 / kBlendSteps
  };

  void start(std::uint32_t c) {
    const Chart& chart = set_.charts[c];
    raster_ = rasterize(chart.faces, set_.corners, partial_box(chart));
    for (const auto face : chart.faces) {
      add_sources(face);
      sources_.first.push_back(sources_.items.size());
    }
    const std::vector<std::uint32_t>& owner = raster_.owner;
    face_slot_.assign(owner.size(), 0);
    for (std::size_t i = 0; i < owner.size(); ++i) {
      if (owner[i] == kNoOwner) continue;
      face_slot_[i] =
          i > 0 && owner[i] == owner[i - 1]
              ? face_slot_[i - 1]
              : static_cast<std::uint32_t>(std::ranges::lower_bound(chart.faces, owner[i]) - chart.faces.begin());
    }
    choice_.assign(owner.size(), {});
    looked_at_.assign(sources_.items.size(), 0);
  }

  void add_sources(std::uint32_t face) {
    const auto map = plane_map(input_.mesh, input_.scene, set_, face);
    if (!map) return;
    for (const ViewId id : ordered_candidates(input_, face)) {
      TexelSource source{face, id, coverage_.find(FaceId{face}, id), {}, {}, {}};
      // Without coverage a view shows either the whole face, if the face is tagged so, or nothing of it.
      if (!source.coverage && !(input_.tags[face] == labeling::FaceTag::seen && id == input_.labels[face])) continue;
      const View& view = input_.scene.views[index(id)];
      source.frame_from_texel = frame_from_texel(*map, view);
      if (source.coverage) source.outline = outline_in(*source.coverage, input_.mesh, view);
      sources_.items.push_back(std::move(source));
    }
  }

  /// A face's source with its clearance. Many are never looked at: the view before them shows all of the face clearly.
  const TexelSource& source(std::size_t number) {
    TexelSource& source = sources_.items[number];
    if (looked_at_[number] == 0 && source.coverage)
      source.clearance = find_clearance(table_, *source.coverage, source.outline, options_.margin_px);
    looked_at_[number] = 1;
    return source;
  }

  /// Places of a row, or of a part of it, that a source shows clearly, as far as that is known without a look at each.
  static InnerRow clear_row(const TexelSource& source, const InnerRow& inner, const InnerRow& part, double y) {
    if (source.coverage) return source.clearance.is_whole ? inner : InnerRow{};
    // What lies in front of the camera at both ends does in between.
    const auto is_in_front = [&](double x) { return source.frame_from_texel(x, y).has_value(); };
    return is_in_front(part.low) && is_in_front(part.high) ? part : InnerRow{};
  }

  /// For each texel the first source, in order of preference, of those with the best sight of its centre.
  void choose_best() {
    const CellBox& box = raster_.box;
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0, end = 0; x < box.x1; x = end) {
        const std::uint32_t owner = raster_.owner[raster_.at(x, y)];
        for (end = x + 1; end < box.x1 && raster_.owner[raster_.at(end, y)] == owner;) ++end;
        if (owner != kNoOwner) choose_best(y, x, end);
      }
  }

  /// Of texels beside each other that one face owns.
  void choose_best(int y, int first_x, int end_x) {
    const std::size_t at = raster_.at(first_x, y), slot = face_slot_[at];
    sights_.assign(static_cast<std::size_t>(end_x - first_x), Sight::hidden);
    std::size_t open = sights_.size();
    const std::size_t first = sources_.first[slot], count = sources_.first[slot + 1] - first;
    for (std::size_t k = 0; k < count && open > 0; ++k) {
      const TexelSource& next = source(first + k);
      const InnerRow inner = inner_row(next, y + 0.5);
      const InnerRow clear = clear_row(next, inner, {first_x + 0.5, end_x - 0.5}, y + 0.5);
      for (std::size_t i = 0; i < sights_.size(); ++i) {
        if (sights_[i] == Sight::clear) continue;
        const double x = first_x + static_cast<double>(i) + 0.5;
        const Sight sight = clear.has(x) ? Sight::clear : sight_at(next, table_, inner, x, y + 0.5);
        if (sight <= sights_[i]) continue;
        sights_[i] = sight;
        choice_[at + i].best = static_cast<std::uint8_t>(k);
        if (sight == Sight::clear) --open;
      }
    }
  }

  static constexpr int kFar = 2;  ///< texels from a border within which two views are blended

  /// The views of the texels of a block, and of those around it that second_source() looks at.
  struct Around {
    static constexpr int kEdge = kStripRow + 2 * kFar;
    CellBox box;  ///< within the chart's
    std::array<ViewId, std::size_t{kEdge} * kEdge> views;
    ViewId& at(int x, int y) { return views[pixel_index(x - box.x0, y - box.y0, kEdge)]; }
  };

  bool has_choice(const CellBox& block) const {
    for (int y = block.y0; y < block.y1; ++y)
      for (int x = block.x0; x < block.x1; ++x)
        if (choice_[raster_.at(x, y)].best != kNone) return true;
    return false;
  }

  /// Close to texels of another view that shows a texel clearly, a part of that view is blended in: 1/3 beside the
  /// border and 1/6 one texel further, so that the colours of the two sides meet in equal steps. Most blocks have no border.
  void choose_second(const CellBox& block) {
    const CellBox& all = raster_.box;
    around_.box = {std::max(all.x0, block.x0 - kFar), std::max(all.y0, block.y0 - kFar),
                   std::min(all.x1, block.x1 + kFar), std::min(all.y1, block.y1 + kFar)};
    if (!has_choice(block)) return;
    ViewId one = kNoView;
    bool several = false;
    for (int y = around_.box.y0; y < around_.box.y1; ++y)
      for (int x = around_.box.x0; x < around_.box.x1; ++x) {
        const ViewId view = view_at(raster_.at(x, y));
        around_.at(x, y) = view;
        if (view == kNoView) continue;
        several |= one != kNoView && view != one;
        one = view;
      }
    if (!several) return;
    for (int y = block.y0; y < block.y1; ++y)
      for (int x = block.x0; x < block.x1; ++x) {
        Choice& choice = choice_[raster_.at(x, y)];
        if (choice.best == kNone) continue;
        for (int distance = 1; distance <= kFar && choice.second == kNone; ++distance) {
          choice.second = second_source(x, y, distance);
          if (choice.second != kNone) choice.blend = distance == 1 ? 2 : 1;
        }
      }
  }

  /// The source for the view of the first texel within `distance` (row by row) whose view is another one and shows the
  /// texel (x, y) clearly; kNone if there is none.
  std::uint8_t second_source(int x, int y, int distance) {
    const CellBox& box = around_.box;
    const std::size_t slot = face_slot_[raster_.at(x, y)], first = sources_.first[slot];
    const auto sources = std::as_const(sources_)[slot];
    const ViewId own = around_.at(x, y);
    for (int ny = std::max(box.y0, y - distance); ny <= std::min(box.y1 - 1, y + distance); ++ny)
      for (int nx = std::max(box.x0, x - distance); nx <= std::min(box.x1 - 1, x + distance); ++nx) {
        const ViewId other = around_.at(nx, ny);
        if (other == kNoView || other == own) continue;
        const auto found =
            static_cast<std::size_t>(std::ranges::find(sources, other, &TexelSource::view) - sources.begin());
        if (found < sources.size() && sight_at(source(first + found), table_, x + 0.5, y + 0.5) == Sight::clear)
          return static_cast<std::uint8_t>(found);
      }
    return kNone;
  }

  ViewId view_at(std::size_t i) const {
    if (choice_[i].best == kNone) return kNoView;
    return sources_.items[sources_.first[face_slot_[i]] + choice_[i].best].view;
  }

  PartialChart finish(std::uint32_t chart) {
    PartialChart part;
    part.chart = chart;
    part.known.assign(choice_.size(), false);
    for (std::size_t i = 0; i < choice_.size(); ++i) {
      if (!is_baked(raster_.reach[i], options_.padding)) continue;
      part.known[i] = choice_[i].best != kNone;
      part.is_open |= choice_[i].best == kNone;
      if (choice_[i].second != kNone) part.blended.push_back({static_cast<std::uint32_t>(i), raster_.reach[i], {}});
    }
    std::vector<TexelShares> shares = list_shares(part);
    keep_used_sources(part, shares);
    part.shares = group_items<TexelShares>(part.views.size(), [&](const auto& add) {
      for (const TexelShares& each : shares) {
        const auto view = static_cast<std::uint32_t>(part.sources[each.source].view);
        add(static_cast<std::size_t>(std::ranges::lower_bound(part.views, view) - part.views.begin()), each);
      }
    });
    return part;
  }

  /// Calls use(texel, place in sources_.items, weight) for what each source gives to texels on the page.
  template <typename Use>
  void for_shares(const PartialChart& part, const Use& use) const {
    for_blocks(raster_.box, [&](std::size_t i, int, int) {
      if (!part.known[i]) return;
      const std::size_t first = sources_.first[face_slot_[i]];
      const Choice& choice = choice_[i];
      use(i, first + choice.best, static_cast<std::uint8_t>(PartialChart::kBlendSteps - choice.blend));
      if (choice.second != kNone) use(i, first + choice.second, choice.blend);
    });
  }

  /// What the sources give, by their places in sources_.items; that of each view in the order of blocks.
  std::vector<TexelShares> list_shares(const PartialChart& part) const {
    std::vector<std::uint32_t> views, view_of_source;
    for (const TexelSource& source : sources_.items) views.push_back(static_cast<std::uint32_t>(source.view));
    std::ranges::sort(views);
    views.erase(std::unique(views.begin(), views.end()), views.end());
    for (const TexelSource& source : sources_.items) {
      const auto place = std::ranges::lower_bound(views, static_cast<std::uint32_t>(source.view));
      view_of_source.push_back(static_cast<std::uint32_t>(place - views.begin()));
    }
    std::vector<TexelShares> shares, begun(views.size());
    const auto width = static_cast<std::uint32_t>(raster_.width());
    for_shares(part, [&](std::size_t i, std::size_t source, std::uint8_t weight) {
      TexelShares& last = begun[view_of_source[source]];
      TexelShares next{static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(source), weight, raster_.reach[i], 1};
      const bool goes_on = last.count > 0 && next.texel == last.texel + last.count && next.source == last.source &&
                           next.weight == last.weight && next.reach == last.reach;
      if (goes_on && next.texel % width % kStripRow != 0) {
        ++last.count;
        return;
      }
      if (last.count > 0) shares.push_back(last);
      last = next;
    });
    std::ranges::copy_if(begun, std::back_inserter(shares), [](const TexelShares& last) { return last.count > 0; });
    return shares;
  }

  /// Moves the sources that give something, to which `shares` then point, and notes their views.
  void keep_used_sources(PartialChart& part, std::vector<TexelShares>& shares) {
    constexpr std::uint32_t kUsed = 0;
    std::vector<std::uint32_t> place(sources_.items.size(), kNoOwner);
    for (const TexelShares& each : shares) place[each.source] = kUsed;
    for (std::size_t s = 0; s < place.size(); ++s) {
      if (place[s] != kUsed) continue;
      place[s] = static_cast<std::uint32_t>(part.sources.size());
      part.views.push_back(static_cast<std::uint32_t>(sources_.items[s].view));
      // Bits for each pixel of every source are too much to keep where many photos see large faces in parts.
      sources_.items[s].clearance = {};
      part.sources.push_back(std::move(sources_.items[s]));
    }
    for (TexelShares& each : shares) each.source = place[each.source];
    std::ranges::sort(part.views);
    part.views.erase(std::unique(part.views.begin(), part.views.end()), part.views.end());
  }

  const AtlasInput& input_;
  const AtlasOptions& options_;
  const ChartSet& set_;
  const CoverageIndex& coverage_;
  const visibility::CoverageTable& table_;
  ChartRaster raster_;
  Grouped<TexelSource> sources_;          ///< per face of the chart, best first
  std::vector<char> looked_at_;           ///< per source: it has its clearance
  std::vector<std::uint32_t> face_slot_;  ///< per texel: the place of its owner in the chart's list of faces
  std::vector<Choice> choice_;            ///< per texel
  std::vector<Sight> sights_;             ///< the best ones of a row
  Around around_;
};

}  // namespace

std::span<const TexelShares> PartialChart::shares_of(ViewId view) const {
  const auto found = std::ranges::lower_bound(views, static_cast<std::uint32_t>(view));
  if (found == views.end() || *found != static_cast<std::uint32_t>(view)) return {};
  return shares[static_cast<std::size_t>(found - views.begin())];
}

std::size_t PartialChart::bytes(std::size_t later_layers) const {
  return sizeof(PartialChart) + sources.capacity() * sizeof(TexelSource) + views.capacity() * sizeof(std::uint32_t) +
         shares.items.capacity() * sizeof(TexelShares) + shares.first.capacity() * sizeof(std::size_t) +
         blended.capacity() * (sizeof(BlendedTexel) + later_layers * sizeof(Color)) + known.capacity() / 8;
}

namespace {

/// \param inner the pixel around the place decides
Sight sight_at(const TexelSource& source, const visibility::CoverageTable& table, bool inner, double x, double y) {
  const auto p = source.frame_from_texel(x, y);
  if (!p) return Sight::hidden;
  if (!source.coverage) return Sight::clear;
  const visibility::FaceCoverage& c = *source.coverage;
  // Positions far outside the box would overflow the conversion to whole pixels.
  if (!(p->x >= c.x0 - 1 && p->y >= c.y0 - 1 && p->x < c.x0 + c.width + 1 && p->y < c.y0 + c.height + 1))
    return Sight::hidden;
  const auto [px, py] = inner ? pixel_around(*p) : deciding_pixel(source, *p);
  return table.sees(c, px, py) ? source.clearance.at(px - c.x0, py - c.y0) : Sight::hidden;
}

}  // namespace

Sight sight_at(const TexelSource& source, const visibility::CoverageTable& table, double x, double y) {
  return sight_at(source, table, false, x, y);
}

Sight sight_at(const TexelSource& source, const visibility::CoverageTable& table, const InnerRow& row, double x,
               double y) {
  return sight_at(source, table, row.has(x), x, y);
}

InnerRow inner_row(const TexelSource& source, double y) {
  constexpr double kReach = 0.51;  // px
  constexpr InnerRow kNone;
  if (!source.coverage || !source.outline) return kNone;
  const TexelTriangle& t = *source.outline;
  const auto& m = source.frame_from_texel.matrix;
  InnerRow row{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  // To where a x + rest > 0.
  const auto clip = [&](double a, double rest) {
    if (a > 0)
      row.low = std::max(row.low, -rest / a);
    else if (a < 0)
      row.high = std::min(row.high, -rest / a);
    else if (!(rest > 0))
      row = kNone;
  };
  clip(m[6], m[7] * y + m[8]);
  const double sign = doubled_area(t) < 0 ? -1 : 1;
  for (std::size_t i = 0; i < 3; ++i) {
    // Of a position (u / w, v / w): its distance from an edge less what it must be at least, times the edge's length and w.
    const TexelPoint &a = t[i], &b = t[(i + 1) % 3];
    const double dx = sign * (b.x - a.x), dy = sign * (b.y - a.y);
    const double of_w =
        dy * (a.x + source.coverage->x0) - dx * (a.y + source.coverage->y0) - kReach * (std::abs(dx) + std::abs(dy));
    const auto combine = [&](std::size_t k) { return dx * m[3 + k] - dy * m[k] + of_w * m[6 + k]; };
    clip(combine(0), combine(1) * y + combine(2));
  }
  return row;
}

std::vector<std::uint32_t> partial_charts(const ChartSet& set) {
  std::vector<std::uint32_t> charts;
  for (std::uint32_t c = 0; c < set.charts.size(); ++c)
    if (set.charts[c].kind == ChartKind::partial || set.charts[c].kind == ChartKind::flat) charts.push_back(c);
  return charts;
}

CellBox partial_box(const Chart& chart) { return {-1, -1, chart.width + 1, chart.height + 1}; }

std::size_t choosing_bytes(const Chart& chart, const CoverageIndex& coverage, int margin_px) {
  // For each texel of the box a raster, a face and a choice, of 12 bytes together, and for few of them a share of its own. For
  // each face of the chart the sources of some eight views.
  constexpr std::size_t kTexel = 12 + sizeof(TexelShares) / 3, kSources = 8 * sizeof(TexelSource);
  const CellBox box = partial_box(chart);
  std::size_t bytes = kTexel * pixel_index(0, box.y1 - box.y0, box.x1 - box.x0) + kSources * chart.faces.size();
  if (margin_px <= 0) return bytes;
  // Clearances, as if the face were hidden somewhere in every view; no more are made than candidates are looked at.
  for (const std::uint32_t face : chart.faces) {
    std::size_t all = 0, largest = 0;
    coverage.for_views(FaceId{face}, [&](const visibility::FaceCoverage& entry) {
      const std::size_t clearance =
          2 * sizeof(std::uint64_t) * row_words(entry) * static_cast<std::size_t>(entry.height);
      all += clearance;
      largest = std::max(largest, clearance);
    });
    bytes += std::min(all, kMostCandidates * largest);
  }
  return bytes;
}

std::vector<PartialChart> choose_sources(const AtlasInput& input, const AtlasOptions& options, const ChartSet& set,
                                         const CoverageIndex& coverage, std::span<const std::uint32_t> charts) {
  std::vector<PartialChart> parts(charts.size());
  tbb::parallel_for(std::size_t{0}, charts.size(),
                    [&](std::size_t i) { parts[i] = SourceChooser(input, options, set, coverage).choose(charts[i]); });
  return parts;
}

PointOrigin origin_at(const PartialChart& part, const Chart& chart, const TexelPoint& p) {
  const CellBox box = partial_box(chart);
  const int x = std::clamp(static_cast<int>(std::floor(p.x)), box.x0, box.x1 - 1);
  const int y = std::clamp(static_cast<int>(std::floor(p.y)), box.y0, box.y1 - 1);
  const auto texel = static_cast<std::uint32_t>(pixel_index(x - box.x0, y - box.y0, box.x1 - box.x0));
  PointOrigin origin;
  if (!part.known[texel]) return origin;
  const auto order = [&](const TexelShares& share) { return block_order(share.texel, box); };
  for (std::size_t v = 0; v < part.views.size(); ++v) {
    const auto shares = part.shares[v];
    const auto after = std::ranges::upper_bound(shares, block_order(texel, box), {}, order);
    if (after == shares.begin()) continue;
    const auto share = std::prev(after);
    if (texel < share->texel || texel - share->texel >= share->count) continue;
    const TexelSource& source = part.sources[share->source];
    // Behind the camera: outside the photo.
    const PixelPoint place = source.frame_from_texel(p.x, p.y).value_or(PixelPoint{-1, -1});
    // The second view has less than half.
    if (2 * share->weight > PartialChart::kBlendSteps) {
      origin.first = source.view;
      origin.first_at = place;
    } else {
      origin.second = source.view;
      origin.second_at = place;
      origin.second_share = double(share->weight) / PartialChart::kBlendSteps;
    }
  }
  return origin;
}

}  // namespace gpvc::atlas
