#include "io/bands/band_tags.h"

#include <algorithm>
#include <pugixml.hpp>
#include <string>

#include "io/files/text_scan.h"
#include "io/number_text.h"

namespace gpvc::io {
namespace {

/// https://gdal.org/drivers/raster/gtiff.html#metadata
std::vector<Band> gdal_bands(std::string_view metadata, std::size_t channels) {
  pugi::xml_document document;
  std::vector<Band> bands(channels);
  if (!document.load_buffer(metadata.data(), metadata.size())) return bands;
  for (const pugi::xml_node item : document.document_element().children("Item")) {
    const auto sample = integer_from<std::size_t>(item.attribute("sample").value());
    if (!sample || *sample >= channels) continue;
    Band& band = bands[*sample];
    const std::string role = item.attribute("role").value(), name = item.attribute("name").value();
    const std::string_view text = trimmed(item.text().get());
    if (role == "description") band.name = text;
    if (role == "unittype") band.unit = text;
    if (name == "WAVELENGTH") band.wavelength_nm = number_from(text);  // nm, as we write it
    if (name == "CENTRAL_WAVELENGTH_UM")
      if (const auto micrometres = number_from(text)) band.wavelength_nm = *micrometres * 1000;
  }
  return bands;
}

/// The texts of a property in XMP, whatever its name's prefix: an attribute, an element, or a list's items.
std::vector<std::string> xmp_values(const pugi::xml_document& document, std::string_view name) {
  const auto is_named = [&](std::string_view given) {
    return given.size() > name.size() && given.ends_with(name) && given[given.size() - name.size() - 1] == ':';
  };
  std::vector<std::string> values;
  const auto add = [&](std::string_view text) {
    if (!trimmed(text).empty()) values.emplace_back(trimmed(text));
  };
  const pugi::xml_node found = document.find_node([&](const pugi::xml_node& node) { return is_named(node.name()); });
  if (found) {
    add(found.text().get());
    for (const pugi::xml_node list : found.children())
      for (const pugi::xml_node item : list.children()) add(item.text().get());
    return values;
  }
  const auto has_it = [&](const pugi::xml_node& node) {
    return std::any_of(node.attributes_begin(), node.attributes_end(),
                       [&](const pugi::xml_attribute& attribute) { return is_named(attribute.name()); });
  };
  for (const pugi::xml_attribute attribute : document.find_node(has_it).attributes())
    if (is_named(attribute.name())) add(attribute.value());
  return values;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

}  // namespace

std::vector<Band> bands_of_tags(std::string_view gdal_metadata, std::string_view xmp, std::size_t channels) {
  std::vector<Band> bands = gdal_bands(gdal_metadata, channels);
  const auto is_named = [](const Band& band) { return !band.name.empty(); };
  pugi::xml_document document;
  if (std::ranges::none_of(bands, is_named) && !xmp.empty() && document.load_buffer(xmp.data(), xmp.size())) {
    const std::vector<std::string> names = xmp_values(document, "BandName"),
                                   wavelengths = xmp_values(document, "CentralWavelength");
    for (std::size_t i = 0; i < channels && names.size() == channels; ++i) bands[i].name = names[i];
    for (std::size_t i = 0; i < channels && wavelengths.size() == channels; ++i)
      bands[i].wavelength_nm = number_from(wavelengths[i]);
  }
  return std::ranges::any_of(bands, is_named) ? bands : std::vector<Band>();
}

std::string metadata_of(const BandSet& set) {
  std::string xml = "<GDALMetadata>\n";
  for (std::size_t i = 0; i < set.bands.size(); ++i) {
    const auto item = [&](const std::string& name, const std::string& role, const std::string& value) {
      xml += "  <Item name=\"" + name + "\" sample=\"" + std::to_string(i) + "\"" +
             (role.empty() ? "" : " role=\"" + role + "\"") + ">" + escaped(value) + "</Item>\n";
    };
    const Band& band = set.bands[i];
    item("DESCRIPTION", "description", band.name);
    if (!band.unit.empty()) item("UNITTYPE", "unittype", band.unit);
    if (!band.wavelength_nm) continue;
    item("WAVELENGTH", "", shortest_text(*band.wavelength_nm));
    item("WAVELENGTH_UNITS", "", "nm");
  }
  return xml + "</GDALMetadata>\n";
}

bool names_band(const Band& band) {
  if (band.wavelength_nm) return true;
  const std::string name = lower_case(band.name);
  const auto has = [&](std::string_view part) { return name.find(part) != std::string::npos; };
  return !name.empty() && name != "a" && !has("alpha") && !has("mask") && !has("opacity") &&
         !name.starts_with("band") && std::ranges::any_of(name, [](char c) { return c >= 'a' && c <= 'z'; });
}

bool name_all(const std::vector<Band>& bands, int channels) {
  return !bands.empty() && bands.size() == static_cast<std::size_t>(channels) &&
         std::ranges::none_of(bands,
                              [](const Band& band) { return band.name.empty() || lower_case(band.name) == "alpha"; });
}

}  // namespace gpvc::io
