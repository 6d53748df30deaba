#include "app/evaluate/bands.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "app/pipeline/texture_files.h"
#include "io/images.h"

namespace gpvc::evaluate {
namespace {

// By page; empty where a page has none.
std::vector<Samples> read_pages(const io::LoadedModel& model, const BandSet& bands, const std::filesystem::path& file) {
  std::vector<Samples> pages;
  for (std::size_t n = 0; n < model.pages.size(); ++n) {
    const std::filesystem::path page = pipeline::page_file_of(file, model, n);
    auto found = pipeline::samples_beside(page, model.pages[n].width, model.pages[n].height);
    if (!found) return {};
    Samples& samples = found->samples;
    if (samples.bands != bands.bands.size() || samples.type != bands.type)
      throw InputError(found->file, "",
                       fmt::format("has {} bands of {}, and the photos {} of {}", samples.bands,
                                   name_of(kSampleTypeNames, samples.type), bands.bands.size(),
                                   name_of(kSampleTypeNames, bands.type)));
    pages.push_back(std::move(samples));
  }
  return pages;
}

}  // namespace

std::vector<BandScore> evaluate_bands(const Scene& scene, io::PhotoSource& photos, const io::LoadedModel& model,
                                      const EvaluateOptions& options, const Progress& progress) {
  if (!scene.bands) return {};
  const std::vector<Samples> samples = read_pages(model, *scene.bands, options.model);
  std::vector<BandScore> bands;
  if (samples.empty()) return bands;
  for (std::size_t b = 0; b < scene.bands->bands.size(); ++b) {
    BandSet alone = *scene.bands;
    alone.composite = {b, b, b};
    std::vector<Image> pages;
    for (const Samples& page : samples) pages.push_back(io::picture_of(page, alone));
    std::vector<RephotographyScore> scores;
    for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
      const View& view = scene.views[v];
      const Image photo = io::picture_of(*photos.samples(ViewId{v}), alone);
      const std::shared_ptr<const io::PhotoExclusion> excluded = photos.exclusion(ViewId{v});
      const ComparedPhoto compared = options.mesh != nullptr
                                         ? photo_to_compare(photo, excluded.get(), view, *options.mesh)
                                         : photo_to_compare(photo, excluded.get(), view, model.mesh, model.offset);
      scores.push_back(
          compare_with_photo(compared, render_view(model.model, pages, view, model.offset), options.reduction).score);
      progress(b * scene.views.size() + v + 1, scene.bands->bands.size() * scene.views.size());
    }
    BandScore score{scene.bands->bands[b].name, mean_score(scores), 0};
    double squares = 0, count = 0;
    for (const RephotographyScore& of : scores) {
      if (of.windows == 0) continue;
      squares += std::pow(10, -of.raw_psnr / 10);
      count += 1;
    }
    if (count > 0) score.rms = (alone.white - alone.black) * std::sqrt(squares / count);
    bands.push_back(std::move(score));
  }
  return bands;
}

Json bands_json(const std::vector<BandScore>& bands) {
  Json json = Json::object();
  for (const BandScore& band : bands) {
    json[band.band] = score_json(band.mean);
    json[band.band]["rms"] = band.rms;
  }
  return json;
}

std::string bands_table(const std::vector<BandScore>& bands) {
  if (bands.empty()) return {};
  std::size_t width = 4;
  for (const BandScore& band : bands) width = std::max(width, band.band.size());
  std::string table =
      fmt::format("{:<{}}    PSNR    SSIM   1-NCC  sharp  without gain: PSNR  rms in its unit\n", "band", width);
  for (const BandScore& band : bands)
    table += band.mean.windows == 0
                 ? fmt::format("{:<{}}  nothing to compare\n", band.band, width)
                 : fmt::format("{:<{}}   {:5.2f}  {:.4f}  {:.4f}   {:.2f}               {:5.2f}  {:.6g}\n", band.band,
                               width, band.mean.psnr, band.mean.ssim, band.mean.ncc_error, band.mean.sharpness,
                               band.mean.raw_psnr, band.rms);
  return table;
}

}  // namespace gpvc::evaluate
