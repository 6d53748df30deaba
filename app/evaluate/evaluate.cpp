#include "app/evaluate/evaluate.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "app/checks/mesh_frame.h"
#include "app/evaluate/bands.h"
#include "app/evaluate/score_picture.h"
#include "app/results/observer.h"
#include "io/vector.h"

namespace gpvc::evaluate {
namespace {

namespace fs = std::filesystem;

void write_picture(const fs::path& out, const std::string& view, const Rephotography& result, int reduction) {
  std::string name = view;
  std::replace(name.begin(), name.end(), '/', '_');
  io::write_image(out / (name + ".png"), score_picture(view, result, reduction), io::ImageFormat::png, 0);
}

}  // namespace

io::LoadedModel read_model_with_texture(const fs::path& file) {
  io::LoadedModel model = io::read_textured_model(file);
  const std::vector<std::uint32_t>& pages = model.model.face_page;
  if (std::all_of(pages.begin(), pages.end(), [](std::uint32_t page) { return page == io::kNoPage; }))
    throw InputError(file, "", "has no textured face (an OBJ needs its MTL, with map_Kd, beside it)");
  return model;
}

Remark place_model(const fs::path& file, const fs::path& mesh_file, const std::string& mesh_crs,
                   std::span<const ViewId> used, Scene& scene, io::LoadedModel& model) {
  std::vector<WorldPoint>& positions = model.mesh.positions;
  for (WorldPoint& p : positions) p = p + model.offset;
  const bool is_there = !mesh_crs.empty() && checks::fits_cameras(scene, model.mesh, used);
  Remark assumed = checks::match_frames(scene, model.mesh, used, file, is_there ? std::string() : mesh_crs);
  if (assumed.text.empty() && mesh_crs.empty() && !mesh_file.empty())
    assumed = checks::match_frames(scene, model.mesh, used, mesh_file);
  // Small numbers again where the offset still means something: match_model() takes their rounding from them.
  if (!model.mesh.file_positions.empty())
    model.offset = {};
  else
    for (WorldPoint& p : positions) p = p - model.offset;
  return assumed;
}

Evaluation evaluate_model(const Scene& scene, io::PhotoSource& photos, const io::LoadedModel& loaded,
                          const EvaluateOptions& options, const Progress& progress) {
  const io::TexturedModel& model = loaded.model;
  const std::size_t passes = 1 + (scene.bands ? scene.bands->bands.size() : 0), steps = passes * scene.views.size();
  if (options.out) {
    std::error_code failed;
    fs::create_directories(*options.out, failed);
    if (failed) throw OutputError(*options.out, failed.message());
  }

  Evaluation evaluation;
  std::vector<RephotographyScore> scores;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const std::shared_ptr<const Image> photo = photos.photo(ViewId{v});
    const std::shared_ptr<const io::PhotoExclusion> excluded = photos.exclusion(ViewId{v});
    const Rephotography result = compare_with_photo(
        options.mesh != nullptr ? photo_to_compare(*photo, excluded.get(), view, *options.mesh)
                                : photo_to_compare(*photo, excluded.get(), view, loaded.mesh, loaded.offset),
        render_view(model, loaded.pages, view, loaded.offset), options.reduction);
    evaluation.views.push_back({view.name, result.score});
    scores.push_back(result.score);
    if (options.out) write_picture(*options.out, view.name, result, options.reduction);
    progress(v + 1, steps);
  }
  evaluation.mean = mean_score(scores);
  if (evaluation.mean.windows == 0) throw InputError(options.model, "", kNothingToCompare);
  evaluation.bands =
      evaluate_bands(scene, photos, loaded, options, results::part_of(progress, scene.views.size(), steps));
  if (options.out) {
    Json report{{"mean", score_json(evaluation.mean)}};
    if (!evaluation.bands.empty()) report["bands"] = bands_json(evaluation.bands);
    for (const ViewScore& view : evaluation.views) report["views"][view.view] = score_json(view.score);
    write_json(*options.out / "evaluate.json", report);
  }
  return evaluation;
}

std::string evaluation_table(const Evaluation& evaluation) {
  std::size_t width = 4;
  for (const ViewScore& view : evaluation.views) width = std::max(width, view.view.size());
  std::string table = fmt::format(
      "{:<{}}  complete   PSNR    SSIM   1-NCC  dE2000  sharp  without gain: PSNR  dE2000   95 %\n", "view", width);
  const auto line = [&](const std::string& name, const RephotographyScore& s) {
    const std::string complete = s.covered > 0 ? fmt::format("{:.4f}", s.completeness) : "     -";
    if (s.windows == 0) return fmt::format("{:<{}}    {}  nothing to compare\n", name, width, complete);
    return fmt::format(
        "{:<{}}    {}  {:5.2f}  {:.4f}  {:.4f}   {:5.2f}   {:.2f}               {:5.2f}   {:5.2f}  {:5.2f}\n", name,
        width, complete, s.psnr, s.ssim, s.ncc_error, s.gained_color_error, s.sharpness, s.raw_psnr, s.color_error,
        s.color_error_95);
  };
  for (const ViewScore& view : evaluation.views) table += line(view.view, view.score);
  return table + line("mean", evaluation.mean) + bands_table(evaluation.bands);
}

}  // namespace gpvc::evaluate
