#include "app/pipeline/bake_into.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace gpvc::pipeline {
namespace {

// Noted before photos are read, so that a user can stop here and set limits.
void note_estimate(const atlas::AtlasEstimate& e, Observer& observer) {
  std::string text =
      fmt::format("estimate: {} {} with {:.1f} megatexels in all, {} charts", e.pages, e.pages == 1 ? "page" : "pages",
                  static_cast<double>(e.page_texels) * 1e-6, results::readable_count(e.charts));
  if (e.reduction < 1) text += fmt::format("; reduced to {:.1f} % to meet the limits", 100 * e.reduction);
  observer.note(text);
}

std::string cuts_figures(const atlas::CutMisfit& cuts, Observer& observer) {
  observer.figure("cuts.places", cuts.places);
  observer.figure("cuts.matched", cuts.matched);
  if (cuts.matched == 0) return "";
  observer.figure("cuts.median_px", cuts.median_px);
  observer.figure("cuts.px_90", cuts.px_90);
  observer.figure("cuts.unaligned_median_px", cuts.unaligned_median_px);
  observer.figure("cuts.unaligned_px_90", cuts.unaligned_px_90);
  return fmt::format(", photos {:.1f} px apart at cuts", cuts.median_px);
}

void report_atlas(const atlas::TextureAtlas& atlas, bool leveled, Observer& observer) {
  const atlas::AtlasStatistics& s = atlas.statistics;
  observer.stage_figure("layout_s", s.layout_s);
  observer.stage_figure("alignment_s", s.alignment_s);
  observer.stage_figure("leveling_s", s.leveling_s);
  observer.stage_figure("baking_s", s.baking_s);
  observer.figure("charts", s.charts);
  observer.figure("filled_faces", s.filled_faces);
  observer.figure("blended_faces", s.blended_faces);
  observer.figure("pages", s.pages);
  observer.figure("chart_texels", s.chart_texels);
  observer.figure("padded_texels", s.padded_texels);
  observer.figure("page_texels", s.page_texels);
  observer.figure("reduction", s.reduction);
  observer.figure("seam_edges", s.seam_edges);
  observer.figure("decodes.seams", s.seam_decodes);
  observer.figure("decodes.paint", s.paint_decodes);
  std::string seams;
  if (s.kept_pages > 0) {
    observer.figure("kept.pages", s.kept_pages);
    seams = fmt::format(", {} of them kept by an earlier run", s.kept_pages);
  }
  report_alignment(s.alignment, observer);
  if (leveled) {
    observer.figure("invented_color_share", s.invented_color.share());
    observer.figure("photo_misfit", s.photo_misfit);
    observer.figure("photo_misfit_exposed", s.photo_misfit_exposed);
    observer.figure("seam_step_before", s.seam_step_before);
    observer.figure("seam_step_after", s.seam_step_after);
    seams += fmt::format(", seam step {:.1f} to {:.1f}", s.seam_step_before, s.seam_step_after);
    seams += cuts_figures(s.cuts, observer);
  }
  const std::size_t faces = atlas.model.mesh->faces.size();
  if (s.blended_faces > 0)
    seams += fmt::format(", {:.0f} % of the faces blended with other photos",
                         100 * static_cast<double>(s.blended_faces) / static_cast<double>(faces));
  const double fill = s.page_texels == 0 ? 0 : static_cast<double>(s.chart_texels) / static_cast<double>(s.page_texels);
  observer.end(fmt::format("{} charts on {} {} ({:.0f} % full){}", results::readable_count(s.charts), s.pages,
                           s.pages == 1 ? "page" : "pages", 100 * fill, seams));
}

// Shares the memory between pages, partial charts and photos.
atlas::BakeOptions share_memory(const atlas::AtlasPlan& plan, const MemoryPlan& memory, const Run& run) {
  const double texel = memory.work.page_texel_bytes();
  const double pages = texel * static_cast<double>(plan.estimate().page_texels);
  const double page = std::min(pages, texel * memory.work.page_texels);
  const MemoryPlan::Shares shares = memory.while_baking(pages, page);
  run.photos.keep_at_most(shares.photos);
  return {.page_bytes = shares.pages, .batch_bytes = shares.batch};
}

}  // namespace

void report_alignment(const atlas::AlignmentStatistics& a, Observer& observer) {
  if (a.matches == 0) return;
  observer.figure("alignment.matches", a.matches);
  observer.figure("alignment.before_px", a.before_px);
  observer.figure("alignment.after_px", a.after_px);
  observer.figure("alignment.shift_px", a.shift_px);
  observer.figure("alignment.affine_share", a.affine_share);
  // Shifts as large as that are no errors of the mesh, and if most of them is the same all over a photo, poses or focal lengths
  // are wrong, which a bundle adjustment finds.
  constexpr double kFarPx = 1.5, kMost = 0.5;
  if (a.shift_px >= kFarPx && a.affine_share >= kMost)
    observer.note(fmt::format(
        "photos are shifted by {:.1f} px in the mean to fit each other, and {:.0f} % of it as errors of poses or focal "
        "lengths do it: another bundle adjustment would help",
        a.shift_px, 100 * a.affine_share));
}

io::CoarsePhotos with_coarse_photos(const Run& run, const Workload& work, double likely,
                                    const std::filesystem::path& folder) {
  const atlas::AtlasOptions& options = run.settings.atlas;
  const bool needed = options.seams != atlas::SeamLeveling::none || options.blend != atlas::Blending::none;
  const double all = needed ? work.pixels * 3 / (io::kCoarsePixel * io::kCoarsePixel) : 0;
  std::error_code failed;
  const std::filesystem::space_info space = std::filesystem::space(folder, failed);
  const double room = failed ? 0 : (static_cast<double>(space.available) - likely) / 2;
  return {run.photos, run.input.scene, folder, static_cast<std::size_t>(std::clamp(room, 0.0, all))};
}

atlas::AtlasPlan plan_and_note(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer) {
  atlas::AtlasPlan made = atlas::plan_atlas(input, options);
  note_estimate(made.estimate(), observer);
  return made;
}

atlas::TextureAtlas bake_and_end(const atlas::AtlasPlan& plan, const atlas::AtlasInput& input,
                                 const atlas::AtlasOptions& options, Observer& observer,
                                 const atlas::BakeOptions& memory) {
  atlas::TextureAtlas atlas = atlas::bake_atlas(plan, input, observer.reporter(), memory);
  const auto [photos, decodes] = input.photos.decodes();
  if (photos > 0) observer.figure("decodes.per_photo", static_cast<double>(decodes) / static_cast<double>(photos));
  report_atlas(atlas, options.seams != atlas::SeamLeveling::none, observer);
  return atlas;
}

atlas::TextureAtlas bake_into(const Run& run, const atlas::AtlasInput& from, const MemoryPlan& memory,
                              const BakeSpace& space, PageSink* sink) {
  run.observer.begin({space.stage, "steps"});
  const atlas::AtlasPlan plan = plan_and_note(from, run.settings.atlas, run.observer);
  atlas::BakeOptions options = share_memory(plan, memory, run);
  options.scratch_folder = space.scratch_folder;
  options.kept = space.kept;
  if (sink != nullptr) {
    sink->begin(plan.estimate());
    options.take_model = [sink](const io::TexturedModel& model) { return sink->take_model(model); };
    options.take_page = [&](std::size_t number, Image page) {
      run.observer.check_cancelled();
      sink->take_page(number, std::move(page));
    };
    options.take_samples = [&](std::size_t number, atlas::PageSamples page) {
      run.observer.check_cancelled();
      sink->take_samples(number, std::move(page), *run.input.scene.bands);
    };
  }
  return bake_and_end(plan, from, run.settings.atlas, run.observer, options);
}

}  // namespace gpvc::pipeline
