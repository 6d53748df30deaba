#include "atlas/baking/kept_pages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "io/scene_members.h"

namespace gpvc::atlas {
namespace {

std::string page_name(std::uint32_t number) { return "page-" + std::to_string(number); }

// Bits of texels, eight a byte.
std::vector<std::uint8_t> packed(const std::vector<bool>& bits) {
  std::vector<std::uint8_t> bytes((bits.size() + 7) / 8, 0);
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (bits[i]) bytes[i / 8] = static_cast<std::uint8_t>(bytes[i / 8] | 1u << (i % 8));
  return bytes;
}

std::vector<bool> unpacked(const std::vector<std::uint8_t>& bytes, std::size_t count) {
  std::vector<bool> bits(count);
  for (std::size_t i = 0; i < count; ++i) bits[i] = (bytes[i / 8] >> (i % 8) & 1u) != 0;
  return bits;
}

// True for partial charts on the page.
bool may_be_open(std::uint32_t chart, std::uint32_t page, const AtlasBuild& build) {
  if (chart >= build.places.size() || build.places[chart].page != page) return false;
  const ChartKind kind = build.set.charts[chart].kind;
  return kind == ChartKind::partial || kind == ChartKind::flat;
}

bool is_sound(const CutMisfit& cuts, std::size_t faces) {
  return std::isfinite(cuts.median_px + cuts.px_90 + cuts.unaligned_median_px + cuts.unaligned_px_90) &&
         std::ranges::all_of(cuts.where, [&](const CutMisfit::Place& place) {
           return index(place.face) < faces && std::isfinite(place.px);
         });
}

std::size_t box_texels(const Chart& chart) {
  const CellBox box = partial_box(chart);
  return pixel_index(0, box.y1 - box.y0, box.x1 - box.x0);
}

}  // namespace

std::optional<AlignmentFit> take_alignment(const KeptPages& kept, const AtlasInput& input) {
  AlignmentFit fit;
  const bool found = kept.store != nullptr && kept.store->read("alignment", kept.key, [&](io::WorkStore::Reader& in) {
    fit.fields = in.get<std::vector<ShiftField>>();
    fit.statistics = in.get<AlignmentStatistics>();
    const bool fits = fit.fields.empty() || fit.fields.size() == input.scene.views.size();
    if (!fits || !std::ranges::all_of(fit.fields, [](const ShiftField& field) { return is_sound(field); })) in.refuse();
    const auto& [matches, before_px, after_px, shift_px, affine_share] = fit.statistics;
    if (!std::isfinite(before_px + after_px + shift_px + affine_share)) in.refuse();
  });
  return found ? std::optional(std::move(fit)) : std::nullopt;
}

void keep_alignment(const KeptPages& kept, const AlignmentFit& fit) {
  if (kept.store == nullptr) return;
  kept.store->keep("alignment", kept.key, [&](io::WorkStore::Writer& out) {
    out.add(fit.fields);
    out.add(fit.statistics);
  });
}

std::optional<LevelingResult> take_leveling(const KeptPages& kept, const AtlasInput& input, const ChartSet& set) {
  LevelingResult r;
  const bool found = kept.store != nullptr && kept.store->read("leveling", kept.key, [&](io::WorkStore::Reader& in) {
    r = in.get<LevelingResult>();
    const auto& [step_before, step_after, misfit_before, misfit_exposed, cuts] = r.statistics;
    if (!is_sound(r.correction, input, set) ||
        !std::isfinite(step_before + step_after + misfit_before + misfit_exposed) ||
        !is_sound(cuts, input.mesh.faces.size()))
      in.refuse();
  });
  return found ? std::optional(std::move(r)) : std::nullopt;
}

void keep_leveling(const KeptPages& kept, const ColorCorrection& correction, const LevelingStatistics& statistics) {
  if (kept.store == nullptr) return;
  kept.store->keep("leveling", kept.key, [&](io::WorkStore::Writer& out) {
    out.add(correction);
    out.add(statistics);
  });
}

bool has_page(const KeptPages& kept, std::uint32_t number) {
  return kept.store != nullptr && kept.store->has(page_name(number), kept.key);
}

bool take_page(const KeptPages& kept, std::uint32_t number, AtlasBuild& build, std::vector<OpenChart>& charts) {
  if (kept.store == nullptr) return false;
  build.open(number);
  Page& page = build.pages[number];
  const std::size_t before = charts.size();
  const bool found = kept.store->read(page_name(number), kept.key, [&](io::WorkStore::Reader& in) {
    if (in.get<std::size_t>() != page.texels()) in.refuse();
    if (in.get<std::size_t>() != page.samples.pixel_bytes()) in.refuse();
    in.read(page.image.pixels.data(), page.image.pixels.size());
    in.read(page.samples.bytes.data(), page.samples.bytes.size());
    in.read(page.state.data(), page.state.size());
    if (std::ranges::max(page.state) > TexelState::padding) in.refuse();
    for (auto left = in.get<std::size_t>(); left > 0; --left) {
      OpenChart chart{in.get<std::uint32_t>(), {}};
      const auto texels = in.get<std::size_t>();
      const bool ascends = charts.size() == before || charts.back().chart < chart.chart;
      if (!ascends || !may_be_open(chart.chart, number, build) || texels != box_texels(build.set.charts[chart.chart]))
        in.refuse();
      const std::vector<std::uint8_t> bytes = in.get<std::vector<std::uint8_t>>();
      if (bytes.size() != (texels + 7) / 8) in.refuse();
      chart.known = unpacked(bytes, texels);
      charts.push_back(std::move(chart));
    }
  });
  if (found) return true;
  charts.resize(before);
  page.open();
  return false;
}

void keep_page(const KeptPages& kept, std::uint32_t number, const Page& page,
               const std::vector<const OpenChart*>& charts) {
  if (kept.store == nullptr) return;
  kept.store->keep(page_name(number), kept.key, [&](io::WorkStore::Writer& out) {
    out.add(page.texels());
    out.add(page.samples.pixel_bytes());
    out.write(page.image.pixels.data(), page.image.pixels.size());
    out.write(page.samples.bytes.data(), page.samples.bytes.size());
    out.write(page.state.data(), page.state.size());
    out.add(charts.size());
    for (const OpenChart* chart : charts) {
      out.add(chart->chart);
      out.add(chart->known.size());
      out.add(packed(chart->known));
    }
  });
}

}  // namespace gpvc::atlas
