#include "app/compare/compare_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace gpvc::compare {
namespace {

// Limit for all pictures of a page, before base64 makes 4 bytes of 3.
constexpr std::size_t kPictureBytes = 17u << 20;

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63u];
  }
  return text;
}

std::string jpeg_bytes(const Image& image, int quality, const std::filesystem::path& scratch) {
  const std::filesystem::path file = scratch / "crop.jpg";
  io::write_image(file, image, io::ImageFormat::jpg, quality);
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  return std::move(bytes).str();
}

// Per crop the photo and the renders as data URIs, at the highest quality that stays within kPictureBytes.
std::vector<std::vector<std::string>> pictures_of(std::span<const Crop> crops, const std::filesystem::path& scratch) {
  std::vector<std::vector<std::string>> pictures;
  for (const int quality : {88, 75, 60, 40}) {
    pictures.clear();
    std::size_t bytes = 0;
    for (const Crop& crop : crops) {
      const auto add = [&](const Image& image) {
        const std::string jpeg = jpeg_bytes(image, quality, scratch);
        bytes += jpeg.size();
        pictures.back().push_back(fmt::format("data:image/jpeg;base64,{}", base64(jpeg)));
      };
      pictures.emplace_back();
      add(crop.photo);
      for (const Image& render : crop.renders) add(render);
    }
    if (bytes <= kPictureBytes) break;
  }
  return pictures;
}

void replace_first(std::string& text, const std::string& mark, const std::string& by) {
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) throw std::logic_error("report.html lacks " + mark);
  text.replace(at, mark.size(), by);
}

std::string escaped_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

std::string markdown_rows(const Json& columns, const Json& rows) {
  const auto row_of = [](const Json& cells) {
    std::string row = "|";
    for (const Json& cell : cells) row += fmt::format(" {} |", escaped_cell(cell.get<std::string>()));
    return row + "\n";
  };
  std::string text = row_of(columns) + "| --- |";
  for (std::size_t n = 1; n < columns.size(); ++n) text += " ---: |";
  text += "\n";
  for (const Json& row : rows) text += row_of(row);
  return text;
}

}  // namespace

std::string markdown_table(const Json& table) {
  return fmt::format("\n## {}\n\n{}\n\n{}", table["title"].get<std::string>(), table["note"].get<std::string>(),
                     markdown_rows(table["columns"], table["rows"]));
}

std::string page_with(const Json& data) {
  // Without "<", no text in the data can end the script element.
  std::string text = data.dump(-1, ' ', false, Json::error_handler_t::replace), safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  std::string page = kReportTemplate;
  replace_first(page, "{\"report\":\"placed here\"}", safe);
  return page;
}

std::string report_page(const Json& report, std::span<const Crop> crops, std::span<const ShownModel> shown,
                        const std::filesystem::path& scratch) {
  Json data = report;
  for (const Figure& f : compared_figures())
    data["figures"].push_back({{"path", f.path},
                               {"name", f.name},
                               {"unit", f.unit},
                               {"digits", f.digits},
                               {"better", f.better},
                               {"meaning", f.meaning}});
  data["opening"] = opening_table(report);
  data["best_and_worst"] = best_and_worst(report);
  data["contest"] = contest_table(report);
  const std::vector<std::vector<std::string>> pictures = pictures_of(crops, scratch);
  for (std::size_t c = 0; c < pictures.size(); ++c) {
    Json& uris = data["crops"][c]["pictures"];
    uris["photo"] = pictures[c].front();
    for (std::size_t m = 0; m < shown.size(); ++m) uris[shown[m].name] = pictures[c][m + 1];
  }
  return page_with(data);
}

std::string report_markdown(const Json& report) {
  const Json &scene = report["scene"], &device = report["program"]["device"];
  std::string text =
      fmt::format("# Visibility modes compared: {}\n\n{} faces, {} of {} views used. gpvc {}, {}.\n\n",
                  scene["name"].get<std::string>(), results::readable_count(scene["faces"].get<std::size_t>()),
                  scene["used_views"].get<std::size_t>(), scene["views"].get<std::size_t>(),
                  report["program"]["version"].get<std::string>(),
                  device.is_null() ? "drawn on the CPU" : device["renderer"].get<std::string>());
  if (const Json opening = opening_table(report); !opening.is_null()) text += markdown_table(opening) + "\n";
  for (const Json& finding : report["findings"]) text += fmt::format("- {}\n", finding.get<std::string>());
  Json columns = Json::array({"mode"}), rows = Json::array();
  for (const Json& mode : report["modes"]) {
    const std::string name = mode["name"];
    const bool ok = mode["status"] == "ok";
    rows.push_back(Json::array({ok ? name : fmt::format("{} (failed: {})", name, mode["error"].get<std::string>())}));
  }
  std::string meanings;
  for (const Figure& figure : compared_figures()) {
    const auto has = [&](const Json& mode) { return number_at(mode, figure.path).has_value(); };
    if (std::none_of(report["modes"].begin(), report["modes"].end(), has)) continue;
    columns.push_back(fmt::format("{}{}{}", figure.name, *figure.unit ? ", " : "", figure.unit));
    meanings += fmt::format("- **{}**: {}\n", figure.name, figure.meaning);
    for (std::size_t n = 0; n < rows.size(); ++n)
      rows[n].push_back(printed_figure(number_at(report["modes"][n], figure.path), figure));
  }
  text += fmt::format("\n{}", markdown_rows(columns, rows));
  if (const Json contest = contest_table(report); !contest.is_null()) text += markdown_table(contest);
  return fmt::format("{}\n{}", text, meanings);
}

}  // namespace gpvc::compare
