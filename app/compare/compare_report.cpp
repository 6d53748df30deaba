#include "app/compare/compare_report.h"

#include <fmt/format.h>

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

struct CropPictures {
  std::string photo;
  std::vector<std::string> renders;
};

// At the highest quality that stays within kPictureBytes.
std::vector<CropPictures> pictures_of(const std::vector<Crop>& crops, const std::filesystem::path& scratch) {
  std::vector<CropPictures> pictures;
  for (const int quality : {88, 75, 60, 40}) {
    pictures.clear();
    std::size_t bytes = 0;
    for (const Crop& crop : crops) {
      CropPictures one{jpeg_bytes(crop.photo, quality, scratch), {}};
      bytes += one.photo.size();
      for (const Image& render : crop.renders) {
        one.renders.push_back(jpeg_bytes(render, quality, scratch));
        bytes += one.renders.back().size();
      }
      pictures.push_back(std::move(one));
    }
    if (bytes <= kPictureBytes) return pictures;
  }
  return pictures;
}

std::string picture_uri(const std::string& jpeg) { return fmt::format("data:image/jpeg;base64,{}", base64(jpeg)); }

void replace_first(std::string& text, const std::string& mark, const std::string& by) {
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) throw std::logic_error("report.html lacks " + mark);
  text.replace(at, mark.size(), by);
}

std::string table_row(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& cell : cells) row += fmt::format(" {} |", cell);
  return row + "\n";
}

std::string escaped_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

}  // namespace

std::string markdown_table(const cli::Json& table) {
  std::string text =
      fmt::format("\n## {}\n\n{}\n\n", table["title"].get<std::string>(), table["note"].get<std::string>());
  std::vector<std::string> cells, rule;
  for (const cli::Json& column : table["columns"]) {
    cells.push_back(escaped_cell(column.get<std::string>()));
    rule.push_back(rule.empty() ? "---" : "---:");
  }
  text += table_row(cells) + table_row(rule);
  for (const cli::Json& row : table["rows"]) {
    cells.clear();
    for (const cli::Json& cell : row) cells.push_back(escaped_cell(cell.get<std::string>()));
    text += table_row(cells);
  }
  return text;
}

std::string page_with(const cli::Json& data) {
  // Without "<", no text in the data can end the script element.
  std::string text = data.dump(-1, ' ', false, cli::Json::error_handler_t::replace), safe;
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

std::string report_page(const ComparisonReport& report, const std::filesystem::path& scratch) {
  cli::Json data = report.json;
  cli::Json figures = cli::Json::array();
  for (const Figure& f : compared_figures())
    figures.push_back({{"path", f.path},
                       {"name", f.name},
                       {"unit", f.unit},
                       {"digits", f.digits},
                       {"better", f.better},
                       {"meaning", f.meaning}});
  data["figures"] = figures;
  if (cli::Json contest = contest_table(report.json); !contest.is_null()) data["contest"] = std::move(contest);
  const std::vector<CropPictures> pictures = pictures_of(report.crops, scratch);
  for (std::size_t c = 0; c < pictures.size(); ++c) {
    cli::Json& crop = data["crops"][c];
    crop["pictures"] = cli::Json::object();
    crop["pictures"]["photo"] = picture_uri(pictures[c].photo);
    for (std::size_t m = 0; m < report.shown.size(); ++m)
      crop["pictures"][report.shown[m]] = picture_uri(pictures[c].renders[m]);
  }
  return page_with(data);
}

std::string report_markdown(const cli::Json& report) {
  const cli::Json &scene = report["scene"], &device = report["program"]["device"];
  std::string text = fmt::format("# Visibility modes compared: {}\n\n", scene["name"].get<std::string>());
  text +=
      fmt::format("{} faces, {} of {} views used. gpvc {}, {}.\n\n",
                  pipeline::readable_count(scene["faces"].get<std::size_t>()), scene["used_views"].get<std::size_t>(),
                  scene["views"].get<std::size_t>(), report["program"]["version"].get<std::string>(),
                  device.is_null() ? "drawn on the CPU" : device["renderer"].get<std::string>());
  for (const cli::Json& finding : report["findings"]) text += fmt::format("- {}\n", finding.get<std::string>());
  std::vector<const Figure*> figures;
  for (const Figure& figure : compared_figures()) {
    const auto has = [&](const cli::Json& mode) { return !figure_of(mode, figure).is_null(); };
    if (std::any_of(report["modes"].begin(), report["modes"].end(), has)) figures.push_back(&figure);
  }
  std::vector<std::string> names{"mode"}, rule{"---"};
  for (const Figure* figure : figures) {
    names.push_back(fmt::format("{}{}", figure->name, *figure->unit ? fmt::format(", {}", figure->unit) : ""));
    rule.push_back("---:");
  }
  text += fmt::format("\n{}{}", table_row(names), table_row(rule));
  for (const cli::Json& mode : report["modes"]) {
    std::vector<std::string> cells{escaped_cell(mode["name"].get<std::string>())};
    if (mode["status"] != "ok")
      cells.front() += fmt::format(" (failed: {})", escaped_cell(mode["error"].get<std::string>()));
    for (const Figure* figure : figures) cells.push_back(printed_figure(figure_of(mode, *figure), *figure));
    text += table_row(cells);
  }
  if (const cli::Json contest = contest_table(report); !contest.is_null()) text += markdown_table(contest);
  text += "\n";
  for (const Figure* figure : figures) text += fmt::format("- **{}**: {}\n", figure->name, figure->meaning);
  return text;
}

}  // namespace gpvc::compare
