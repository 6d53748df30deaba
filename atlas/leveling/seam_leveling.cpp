#include "atlas/leveling/seam_leveling.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "atlas/leveling/cut_misfit.h"
#include "atlas/leveling/finished_texture.h"
#include "atlas/leveling/limit_offsets.h"
#include "atlas/leveling/seam_blend.h"
#include "io/color_difference.h"
#include "io/grouping.h"

namespace gpvc::atlas {

namespace {

double mean_abs(const Color& c) { return (std::abs(double(c.r)) + std::abs(double(c.g)) + std::abs(double(c.b))) / 3; }

double mean_step(const SeamSamples& seams) {
  double sum = 0, weight = 0;
  for (const SeamEdge& edge : seams.edges) {
    // The edge's weight times the absolute value of its mean.
    Color difference;
    for (std::size_t i = edge.first_sample; i < edge.first_sample + edge.samples; ++i) {
      difference = difference + seams.weight[i] * (seams.colors[i][0] - seams.colors[i][1]);
      weight += double{seams.weight[i]};
    }
    sum += mean_abs(difference);
  }
  return weight > 0 ? sum / weight : 0;
}

/// CIEDE2000 between the means of both sides, averaged over edges by their weight.
double mean_misfit(const SeamSamples& seams) {
  // The mean of so many edges is known to a few thousandths of their scatter.
  constexpr std::size_t kEdges = 100000;
  double sum = 0, weight = 0;
  for (std::size_t e = 0; e < seams.edges.size(); e += 1 + seams.edges.size() / kEdges) {
    const SeamEdge& edge = seams.edges[e];
    std::array<Color, 2> mean{};
    float edge_weight = 0;
    for (std::size_t i = edge.first_sample; i < edge.first_sample + edge.samples; ++i) {
      edge_weight += seams.weight[i];
      for (std::size_t side = 0; side < 2; ++side) mean[side] = mean[side] + seams.weight[i] * seams.colors[i][side];
    }
    if (!(edge_weight > 0)) continue;
    const auto lab = [&](const Color& c) {
      return lab_from_srgb({c.r / edge_weight, c.g / edge_weight, c.b / edge_weight});
    };
    sum += double{edge_weight} * color_difference(lab(mean[0]), lab(mean[1]));
    weight += double{edge_weight};
  }
  return weight > 0 ? sum / weight : 0;
}

/// Fits the corrections one after the other, each to the samples as the ones before have corrected them.
class Leveler {
 public:
  Leveler(const AtlasInput& input, const ChartSet& set, const BlendWeights& blending, SeamSamples& seams,
          const SeamBlend& blend, const OverlapRatios& overlaps)
      : input_(input), set_(set), blending_(blending), seams_(seams), blend_(blend), overlaps_(overlaps) {}

  ColorCorrection level(SeamLeveling mode) {
    correction_.exposure.assign(input_.exposure.begin(), input_.exposure.end());
    if (input_.exposure.empty()) correction_.exposure = fit_exposure(input_, seams_, overlaps_);
    correct([&](const Color& color, std::uint32_t face, const PixelPoint& frame, const TexelPoint&) {
      const Color gain = correction_.gain(input_.labels[face], frame);
      return corrected(gain * color, {}, gain);
    });
    misfit_exposed_ = mean_misfit(seams_);
    blend_.add_to(seams_, correction_.exposure);
    fit_offsets(input_, seams_, correction_);
    const std::vector<AddedRange> ranges = find_added_ranges(input_, blending_, correction_);
    limit_offsets(ranges, correction_);
    correct([&](const Color& color, std::uint32_t face, const PixelPoint&, const TexelPoint& p) {
      return color + correction_.face_offset(face, set_.corners[face], p.x, p.y);
    });
    if (mode == SeamLeveling::full) {
      lay_strips();
      limit_strips(ranges, input_, set_, correction_);
      keep_for_measuring();
      correct([&](const Color& color, std::uint32_t face, const PixelPoint&, const TexelPoint& p) {
        const Color strip = strip_offset(correction_.strip(set_.face_chart[face]), p.x, p.y);
        return color + correction_.taken(strip, face, set_.corners[face], p.x, p.y);
      });
    }
    return std::move(correction_);
  }
  /// Of the photos with their exposure corrected.
  double misfit_exposed() const { return misfit_exposed_; }

 private:
  /// Leaves weight to the samples of some edges alone, where there are many: those of all are no longer needed, and a
  /// strip's offset at a single place takes long.
  void keep_for_measuring() {
    // The mean of so many samples is known to a few thousandths of their scatter.
    constexpr std::size_t kSamples = 250000;
    const std::size_t stride = 1 + seams_.weight.size() / kSamples;
    for (std::size_t e = 0; e < seams_.edges.size(); ++e) {
      if (e % stride == 0) continue;
      const SeamEdge& edge = seams_.edges[e];
      std::fill_n(seams_.weight.begin() + static_cast<std::ptrdiff_t>(edge.first_sample), edge.samples, 0.0f);
    }
  }

  /// Calls visit(i, p) for the samples i of an edge that have weight, p in the texels of the side's chart; for none if the
  /// side is finished.
  template <typename Visit>
  void for_samples(const SeamEdge& edge, std::size_t side, const Visit& visit) const {
    const std::uint32_t face = edge.faces[side];
    if (is_finished(input_, face)) return;
    const Chart& chart = set_.charts[set_.face_chart[face]];
    std::array<TexelPoint, 2> ends{};
    for (std::size_t end = 0; end < 2; ++end)
      ends[end] = set_.corners[face][corner_of(input_.mesh.faces[face], edge.vertices[end])];
    for (std::uint32_t k = 0; k < edge.samples; ++k) {
      const std::size_t i = edge.first_sample + k;
      if (!(seams_.weight[i] > 0)) continue;
      const PixelPoint& frame = seams_.frame[i][side];
      const double t = (k + 0.5) / edge.samples;
      if (chart.kind == ChartKind::flat || chart.given)
        visit(i, TexelPoint{ends[0].x + t * (ends[1].x - ends[0].x), ends[0].y + t * (ends[1].y - ends[0].y)});
      else
        visit(i, TexelPoint{(frame.x - chart.origin_x) * chart.scale, (frame.y - chart.origin_y) * chart.scale});
    }
  }

  /// Replaces the colours of the samples by change(color, face, frame position, position in the texels of its chart).
  template <typename Change>
  void correct(const Change& change) {
    tbb::parallel_for(std::size_t{0}, seams_.edges.size(), [&](std::size_t e) {
      const SeamEdge& edge = seams_.edges[e];
      for (std::size_t side = 0; side < 2; ++side)
        for_samples(edge, side, [&](std::size_t i, const TexelPoint& p) {
          Color& color = seams_.colors[i][side];
          color = change(color, edge.faces[side], seams_.frame[i][side], p);
        });
    });
  }

  /// A side of an edge, as 2 x edge + side.
  using Side = std::uint32_t;

  void lay_strips() {
    const Grouped<Side> sides =
        group_numbered<Side>(set_.charts.size(), seams_.edges.size(), [&](std::size_t e, const auto& add) {
          for (std::size_t side = 0; side < 2; ++side)
            if (const std::uint32_t face = seams_.edges[e].faces[side]; !is_finished(input_, face))
              add(set_.charts[set_.face_chart[face]].piece, static_cast<Side>(2 * e + side));
        });
    correction_.strips.resize(set_.charts.size());
    tbb::parallel_for(std::size_t{0}, set_.charts.size(), [&](std::size_t c) {
      const std::vector<SeamStep> samples = steps_on(set_.charts[c], sides[set_.charts[c].piece]);
      if (!samples.empty()) correction_.strips[c] = make_strip(set_.charts[c], samples);
    });
  }

  /// The samples near a chart of all charts of its piece, so that a strip continues across the cuts between them.
  std::vector<SeamStep> steps_on(const Chart& chart, std::span<const Side> of_piece) const {
    // Grey levels. Larger steps come from different objects on the two sides; spreading them would smear one object
    // over the other.
    constexpr float kMostStep = 32;
    const auto limited = [=](float v) { return std::clamp(v, -kMostStep, kMostStep); };
    std::vector<SeamStep> samples;
    for (const Side both : of_piece) {
      const std::size_t side = both % 2;
      const SeamEdge& edge = seams_.edges[both / 2];
      const Chart& from = set_.charts[set_.face_chart[edge.faces[side]]];
      const auto right = static_cast<float>((from.origin_x - chart.origin_x) * chart.scale);
      const auto down = static_cast<float>((from.origin_y - chart.origin_y) * chart.scale);
      // A finished side stays where it is: this one goes all the way.
      const float way = is_finished(input_, edge.faces[1 - side]) ? 1.0f : 0.5f;
      for_samples(edge, side, [&](std::size_t i, const TexelPoint& p) {
        SeamStep sample{static_cast<float>(p.x) + right, static_cast<float>(p.y) + down, seams_.weight[i], {}};
        if (!strip_reaches(chart, sample)) return;
        const Color d = way * (seams_.colors[i][1 - side] - seams_.colors[i][side]);
        sample.step = {limited(d.r), limited(d.g), limited(d.b)};
        samples.push_back(sample);
      });
    }
    return samples;
  }

  const AtlasInput& input_;
  const ChartSet& set_;
  const BlendWeights& blending_;
  SeamSamples& seams_;
  const SeamBlend& blend_;
  const OverlapRatios& overlaps_;
  ColorCorrection correction_;
  double misfit_exposed_ = 0;
};

}  // namespace

LevelingResult level_seams(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                           const CutPlaces& cuts, const BlendWeights& blending, SeamLeveling mode) {
  LevelingResult result;
  if (mode == SeamLeveling::none) return result;
  std::vector<SeamEdge> edges = find_seams(input);
  SeamBlend blend(input, blending, edges);
  PlacePatches patches(input, cuts.places, {}, cuts.surfaces);
  OverlapRatios overlaps(input);
  SeamSamples seams = sample_seams(input, coverage, std::move(edges), {&blend, &patches, &overlaps});
  result.statistics.cuts = cut_misfit(input, cuts, patches);
  result.statistics.step_before = mean_step(seams);
  result.statistics.misfit_before = mean_misfit(seams);
  if (seams.edges.empty() && input.exposure.empty() && color_ratios(input, seams, overlaps).empty()) return result;
  Leveler leveler(input, set, blending, seams, blend, overlaps);
  result.correction = leveler.level(mode);
  result.statistics.misfit_exposed = leveler.misfit_exposed();
  result.statistics.step_after = mean_step(seams);
  return result;
}

}  // namespace gpvc::atlas
