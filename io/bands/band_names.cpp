#include "io/bands/band_names.h"

#include <algorithm>
#include <initializer_list>
#include <optional>

#include "io/error.h"
#include "io/files/text_scan.h"

namespace gpvc::io {
namespace {

/// Small letters and digits alone: "Red edge", "red_edge" and "RedEdge" are the same.
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : lower_case(name))
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) text += c;
  return text;
}

std::optional<std::size_t> band_called(std::span<const Band> bands, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names)
    for (std::size_t i = 0; i < bands.size(); ++i)
      if (plain(bands[i].name) == name) return i;
  return std::nullopt;
}

std::optional<std::size_t> red_of(std::span<const Band> bands) { return band_called(bands, {"red", "r"}); }
std::optional<std::size_t> green_of(std::span<const Band> bands) { return band_called(bands, {"green", "g", "gre"}); }
std::optional<std::size_t> infrared_of(std::span<const Band> bands) {
  return band_called(bands, {"nir", "n", "nearinfrared", "infrared"});
}

std::string list_of(std::span<const Band> bands) {
  std::string names;
  for (const Band& band : bands) names += (names.empty() ? "" : ", ") + band.name;
  return names;
}

}  // namespace

std::vector<Band> bands_of_file(const PhotoHeader& header, std::size_t bands, std::size_t first) {
  std::vector<Band> named = header.bands;
  if (named.size() > bands && header.alpha_channel >= 0)
    named.erase(named.begin() + static_cast<std::ptrdiff_t>(header.alpha_channel));
  named.resize(bands);
  constexpr std::array<const char*, 3> kColors{"Red", "Green", "Blue"};
  for (std::size_t i = 0; i < bands; ++i)
    if (named[i].name.empty())
      named[i].name = (header.colors ? bands >= kColors.size() : bands == kColors.size()) && i < kColors.size()
                          ? kColors[i]
                          : "B" + std::to_string(first + i + 1);
  return named;
}

void make_unique(std::vector<Band>& bands) {
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const std::string name = bands[i].name;
    const auto is_taken = [&] {
      return std::any_of(bands.begin(), bands.begin() + static_cast<std::ptrdiff_t>(i),
                         [&](const Band& before) { return plain(before.name) == plain(bands[i].name); });
    };
    for (int number = 2; is_taken(); ++number) bands[i].name = name + " " + std::to_string(number);
  }
}

std::array<std::size_t, 3> usual_composite(std::span<const Band> bands) {
  const auto red = red_of(bands), green = green_of(bands), blue = band_called(bands, {"blue", "b"}),
             infrared = infrared_of(bands);
  if (red && green && blue) return {*red, *green, *blue};
  if (infrared && red && green) return {*infrared, *red, *green};
  return bands.size() < 3 ? std::array<std::size_t, 3>{0, 0, 0} : std::array<std::size_t, 3>{0, 1, 2};
}

std::array<std::size_t, 3> composite_of_names(const std::filesystem::path& source, std::span<const std::string> wanted,
                                              std::span<const Band> bands) {
  if (wanted.size() != 1 && wanted.size() != 3)
    throw InputError(source, "",
                     "has a composite of " + std::to_string(wanted.size()) +
                         " bands; expected three, for red, green and blue, or one");
  std::array<std::size_t, 3> composite{};
  for (std::size_t i = 0; i < composite.size(); ++i) {
    const std::string& name = wanted[wanted.size() == 1 ? 0 : i];
    std::optional<std::size_t> band;
    for (std::size_t b = 0; b < bands.size() && !band; ++b)
      if (plain(bands[b].name) == plain(name)) band = b;
    if (const auto number = integer_from<std::size_t>(name); !band && number && *number >= 1 && *number <= bands.size())
      band = *number - 1;
    if (!band) throw InputError(source, "", "has no band " + quote(name) + "; its bands are " + list_of(bands));
    composite[i] = *band;
  }
  return composite;
}

bool holds_quantities(const BandSet& set) {
  constexpr std::size_t kMostColors = 4;  // with another one that no name says anything of
  if (set.type == SampleType::f32 || set.bands.size() > kMostColors) return true;
  if (set.bands.size() == 1 && set.type != SampleType::u8) return true;
  if (infrared_of(set.bands) ||
      band_called(set.bands, {"rededge", "reg", "re", "edge", "swir", "lwir", "mwir", "thermal", "temperature"}))
    return true;
  return std::ranges::any_of(set.bands,
                             [](const Band& band) { return band.wavelength_nm.has_value() || !band.unit.empty(); });
}

}  // namespace gpvc::io
