#include "atlas/leveling/seam_leveling.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace gpvc::atlas {

namespace {

/// Positions of an edge's samples in the texels of one side's chart.
class SidePosition {
 public:
  SidePosition(const Mesh& mesh, const ChartSet& set, const SeamEdge& edge, std::size_t side)
      : chart_(&set.charts[set.face_chart[edge.faces[side]]]) {
    const auto& t = mesh.faces[edge.faces[side]];
    for (std::size_t end = 0; end < 2; ++end)
      for (std::size_t i = 0; i < 3; ++i)
        if (t[i] == edge.vertices[end]) ends_[end] = set.corners[edge.faces[side]][i];
  }
  TexelPoint at(double t, const PixelPoint& frame) const {
    if (chart_->kind != ChartKind::flat)
      return {(frame.x - chart_->origin_x) * chart_->scale, (frame.y - chart_->origin_y) * chart_->scale};
    return {ends_[0].x + t * (ends_[1].x - ends_[0].x), ends_[0].y + t * (ends_[1].y - ends_[0].y)};
  }

 private:
  const Chart* chart_;
  std::array<TexelPoint, 2> ends_{};
};

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

template <typename Body>
void for_samples(SeamSamples& seams, const Body& body) {
  tbb::parallel_for(std::size_t{0}, seams.edges.size(), [&](std::size_t e) {
    const SeamEdge& edge = seams.edges[e];
    for (std::uint32_t i = 0; i < edge.samples; ++i)
      if (seams.weight[edge.first_sample + i] > 0) body(edge, edge.first_sample + i, (i + 0.5) / edge.samples);
  });
}

void expose(const AtlasInput& input, const ColorCorrection& correction, SeamSamples& seams) {
  for_samples(seams, [&](const SeamEdge& edge, std::size_t i, double) {
    for (std::size_t s = 0; s < 2; ++s)
      seams.colors[i][s] = correction.expose(seams.colors[i][s], input.labels[edge.faces[s]], seams.frame[i][s]);
  });
}

void add_offsets(const AtlasInput& input, const ChartSet& set, const ColorCorrection& correction, SeamSamples& seams) {
  for_samples(seams, [&](const SeamEdge& edge, std::size_t i, double t) {
    for (std::size_t s = 0; s < 2; ++s) {
      const TexelPoint p = SidePosition(input.mesh, set, edge, s).at(t, seams.frame[i][s]);
      const std::uint32_t face = edge.faces[s];
      seams.colors[i][s] = seams.colors[i][s] + correction.face_offset(face, set.corners[face], p.x, p.y);
    }
  });
}

/// Adds the sample to all charts of its piece, so that a strip continues across the cuts between them.
void add_to_piece(const ChartSet& set, std::uint32_t own, const StripSample& sample,
                  std::vector<std::vector<StripSample>>& samples) {
  const Chart& from = set.charts[own];
  for (std::uint32_t c = from.piece; c < set.charts.size() && set.charts[c].piece == from.piece; ++c) {
    const Chart& chart = set.charts[c];
    StripSample moved = sample;
    moved.x += static_cast<float>((from.origin_x - chart.origin_x) * chart.scale);
    moved.y += static_cast<float>((from.origin_y - chart.origin_y) * chart.scale);
    if (strip_reaches(chart, moved)) samples[c].push_back(moved);
  }
}

void lay_strips(const AtlasInput& input, const ChartSet& set, const SeamSamples& seams, ColorCorrection& correction) {
  // Grey levels. Larger steps come from different objects on the two sides; spreading them would smear one object over
  // the other.
  constexpr float kMostStep = 32;
  std::vector<std::vector<StripSample>> samples(set.charts.size());
  for (const SeamEdge& edge : seams.edges) {
    for (std::size_t s = 0; s < 2; ++s) {
      const SidePosition position(input.mesh, set, edge, s);
      const std::uint32_t own = set.face_chart[edge.faces[s]];
      for (std::uint32_t k = 0; k < edge.samples; ++k) {
        const std::size_t i = edge.first_sample + k;
        if (!(seams.weight[i] > 0)) continue;
        const TexelPoint p = position.at((k + 0.5) / edge.samples, seams.frame[i][s]);
        const Color d = 0.5f * (seams.colors[i][1 - s] - seams.colors[i][s]);
        const auto limited = [=](float v) { return std::clamp(v, -kMostStep, kMostStep); };
        const StripSample sample{static_cast<float>(p.x),
                                 static_cast<float>(p.y),
                                 seams.weight[i],
                                 {limited(d.r), limited(d.g), limited(d.b)}};
        add_to_piece(set, own, sample, samples);
      }
    }
  }
  correction.strips.resize(set.charts.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t c) {
    if (!samples[c].empty()) correction.strips[c] = make_strip(set.charts[c], samples[c]);
  });
}

void add_strips(const AtlasInput& input, const ChartSet& set, const ColorCorrection& correction, SeamSamples& seams) {
  tbb::parallel_for(std::size_t{0}, seams.edges.size(), [&](std::size_t e) {
    const SeamEdge& edge = seams.edges[e];
    std::vector<StripSample> near;
    for (std::size_t s = 0; s < 2; ++s) {
      const ChartStrip* strip = correction.strip(set.face_chart[edge.faces[s]]);
      if (!strip) continue;
      const SidePosition position(input.mesh, set, edge, s);
      for (std::uint32_t k = 0; k < edge.samples; ++k) {
        const std::size_t i = edge.first_sample + k;
        if (!(seams.weight[i] > 0)) continue;
        const TexelPoint p = position.at((k + 0.5) / edge.samples, seams.frame[i][s]);
        const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
        gather_strip(*strip, {x, y, x + 1, y + 1}, near);
        seams.colors[i][s] = seams.colors[i][s] + strip_offset(near, p.x, p.y);
      }
    }
  });
}

}  // namespace

LevelingResult level_seams(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                           SeamLeveling mode) {
  LevelingResult result;
  if (mode == SeamLeveling::none) return result;
  SeamSamples seams = sample_seams(input, coverage);
  result.step_before = mean_step(seams);
  if (seams.edges.empty()) return result;
  result.correction.exposure = fit_exposure(input, seams);
  expose(input, result.correction, seams);
  fit_offsets(input, set, seams, result.correction);
  add_offsets(input, set, result.correction, seams);
  if (mode == SeamLeveling::full) {
    lay_strips(input, set, seams, result.correction);
    add_strips(input, set, result.correction, seams);
  }
  result.step_after = mean_step(seams);
  return result;
}

}  // namespace gpvc::atlas
