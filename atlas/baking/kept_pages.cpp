#include "atlas/baking/kept_pages.h"

#include <array>
#include <string>
#include <utility>

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

}  // namespace

std::optional<LevelingResult> take_leveling(const KeptPages& kept) {
  LevelingResult r;
  const bool found = kept.store != nullptr && kept.store->read("leveling", kept.key, [&](io::WorkStore::Reader& in) {
    r.step_before = in.get<double>();
    r.step_after = in.get<double>();
    r.correction.exposure = in.get_all<ViewExposure>();
    r.correction.nodes = in.get_all<std::array<std::uint32_t, 3>>();
    r.correction.offsets = in.get_all<Color>();
    const auto strips = in.get<std::size_t>();
    if (strips > in.left()) in.refuse();
    r.correction.strips.resize(strips);
    for (ChartStrip& strip : r.correction.strips) {
      strip.columns = in.get<int>();
      strip.rows = in.get<int>();
      strip.cells.first = in.get_all<std::size_t>();
      strip.cells.items = in.get_all<StripSample>();
    }
  });
  return found ? std::optional(std::move(r)) : std::nullopt;
}

void keep_leveling(const KeptPages& kept, const LevelingResult& r) {
  if (kept.store == nullptr) return;
  kept.store->keep("leveling", kept.key, [&](io::WorkStore::Writer& out) {
    out.add(r.step_before);
    out.add(r.step_after);
    out.add_all(r.correction.exposure);
    out.add_all(r.correction.nodes);
    out.add_all(r.correction.offsets);
    out.add(r.correction.strips.size());
    for (const ChartStrip& strip : r.correction.strips) {
      out.add(strip.columns);
      out.add(strip.rows);
      out.add_all(strip.cells.first);
      out.add_all(strip.cells.items);
    }
  });
}

bool has_page(const KeptPages& kept, std::uint32_t number) {
  return kept.store != nullptr && kept.store->has(page_name(number), kept.key);
}

bool take_page(const KeptPages& kept, std::uint32_t number, Page& page, std::vector<OpenChart>& charts) {
  if (kept.store == nullptr) return false;
  page.open();
  const std::size_t before = charts.size();
  const bool found = kept.store->read(page_name(number), kept.key, [&](io::WorkStore::Reader& in) {
    if (in.get<std::size_t>() != page.texels()) in.refuse();
    in.read(page.image.pixels.data(), page.image.pixels.size());
    in.read(page.state.data(), page.state.size());
    for (auto left = in.get<std::size_t>(); left > 0; --left) {
      OpenChart chart{in.get<std::uint32_t>(), {}};
      const auto texels = in.get<std::size_t>();
      const std::vector<std::uint8_t> bytes = in.get_all<std::uint8_t>();
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
    out.write(page.image.pixels.data(), page.image.pixels.size());
    out.write(page.state.data(), page.state.size());
    out.add(charts.size());
    for (const OpenChart* chart : charts) {
      out.add(chart->chart);
      out.add(chart->known.size());
      out.add_all(packed(chart->known));
    }
  });
}

}  // namespace gpvc::atlas
