// gpvc visibility: the classes of each view as arrays, and the check by the oracle.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <span>
#include <string>

#include "app/cli/scene_input.h"
#include "app/cli/setting_options.h"
#include "app/evaluate/oracle_check.h"
#include "io/npy.h"
#include "visibility/visibility.h"

namespace gpvc::cli {
namespace {

void write_ivm(const std::filesystem::path& file, const visibility::Ivm& ivm) {
  std::vector<std::uint32_t> faces;
  for (const FaceId face : ivm.faces) faces.push_back(static_cast<std::uint32_t>(face));
  const std::size_t shape[2] = {static_cast<std::size_t>(ivm.height), static_cast<std::size_t>(ivm.width)};
  io::write_npy(file, faces, shape);
}

struct Totals {
  std::size_t full = 0, partial = 0, hidden = 0, unresolved = 0;
  visibility::VisibilityStatistics statistics;

  void add(const visibility::ViewVisibility& view) {
    const auto count = [&](visibility::FaceClass c) {
      return static_cast<std::size_t>(std::count(view.classes.begin(), view.classes.end(), c));
    };
    full += count(visibility::FaceClass::full);
    partial += count(visibility::FaceClass::partial);
    hidden += count(visibility::FaceClass::hidden);
    unresolved += count(visibility::FaceClass::unresolved);
    statistics += view.statistics;
  }
};

std::string table_head(std::size_t name_width) {
  return fmt::format("{:{}}  {:>9} {:>9} {:>9} {:>10} {:>9} {:>11} {:>9} {:>8} {:>8} {:>8} {:>8}", "view", name_width,
                     "full", "partial", "hidden", "unresolved", "processed", "samples", "corrected", "upload s",
                     "render s", "read s", "class s");
}

std::string table_row(const std::string& name, std::size_t name_width, const Totals& t) {
  const visibility::VisibilityStatistics& s = t.statistics;
  return fmt::format("{:{}}  {:>9} {:>9} {:>9} {:>10} {:>9} {:>11} {:>9} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f}", name,
                     name_width, t.full, t.partial, t.hidden, t.unresolved, s.processed_faces, s.samples,
                     s.corrected_samples, s.upload_s, s.render_s, s.readback_s, s.classify_s);
}

// Writes visibility/NAME.npy; with several meshes visibility/M/NAME.npy for each.
void write_view(const SceneInputData& in, const View& view, const visibility::ViewVisibility& seen, bool ivm,
                results::OutputFolder& folder) {
  const std::filesystem::path name = results::contained_path(view.name).generic_string() + ".npy";
  const std::span<const visibility::FaceClass> classes(seen.classes);
  if (in.parts.size() == 1) {
    io::write_npy_as<std::uint8_t>(folder.file("visibility" / name), classes);
  } else {
    for (std::size_t m = 0; m < in.parts.size(); ++m)
      io::write_npy_as<std::uint8_t>(folder.file(std::filesystem::path("visibility") / std::to_string(m) / name),
                                     classes.subspan(in.parts[m].first_face, in.parts[m].faces));
  }
  if (ivm) write_ivm(folder.file("ivm" / name), seen.ivm);
}

void record_totals(const Totals& all, RunRecord& record) {
  const visibility::VisibilityStatistics& s = all.statistics;
  record.stage_figure("render_s", s.render_s);
  record.stage_figure("upload_s", s.upload_s);
  record.stage_figure("readback_s", s.readback_s);
  record.stage_figure("classify_s", s.classify_s);
  record.counts.update({{"full", all.full},
                        {"partial", all.partial},
                        {"hidden", all.hidden},
                        {"unresolved", all.unresolved},
                        {"processed_faces", s.processed_faces},
                        {"samples", s.samples},
                        {"corrected_samples", s.corrected_samples},
                        {"contested_samples", s.contested_samples}});
}

// The size of the arrays.
double bytes_of(const SceneInputData& in, bool ivm) {
  double bytes = 0;
  for (const ViewId id : in.used) {
    const Camera& camera = in.scene.views[index(id)].camera;
    const double pixels = static_cast<double>(camera.width) * static_cast<double>(camera.height);
    bytes += static_cast<double>(in.mesh.faces.size()) + (ivm ? 4 * pixels : 0);
  }
  return bytes;
}

std::size_t pixels_in(const io::PhotoExclusion& excluded) {
  std::size_t count = 0;
  for (const std::uint64_t word : excluded.words) count += static_cast<std::size_t>(std::popcount(word));
  return count;
}

void classify_views(const SceneInputData& in, const VisibilityCommandOptions& options,
                    visibility::GraphicsDevice* device, results::OutputFolder& folder, RunRecord& record,
                    evaluate::OracleCheck& check) {
  record.begin({"visibility", "views"});
  visibility::VisibilityStage visibility(in.mesh, options.visibility, device);
  record.note("drawing: " + visibility.drawing_note());
  record.note("classifier: " + visibility.classifier_note());
  record.counts["drawing"] = visibility.drawing_note();
  record.counts["classifier"] = visibility.classifier_note();
  std::size_t name_width = 5;
  for (const ViewId id : in.used) name_width = std::max(name_width, in.scene.views[index(id)].name.size());
  record.console.result(table_head(name_width));
  Totals all;
  io::PhotoCache photos(in.scene);  // knows what masks exclude, and pixels without data
  visibility::ViewVisibility seen;
  std::size_t excluded_pixels = 0, excluding = 0;
  for (std::size_t n = 0; n < in.used.size(); ++n) {
    record.progress(n, in.used.size());
    const View& view = in.scene.views[index(in.used[n])];
    const auto excluded = photos.exclusion(in.used[n]);
    visibility.classify(view, in.used[n], excluded.get(), seen);
    if (excluded) {
      ++excluding;
      excluded_pixels += pixels_in(*excluded);
    }
    write_view(in, view, seen, options.ivm, folder);
    Totals one;
    one.add(seen);
    all.add(seen);
    record.console.result(table_row(view.name, name_width, one));
    check.compare(in.mesh, in.scene, in.used[n], seen.classes);
  }
  record.console.result(table_row("all", name_width, all));
  record_totals(all, record);
  record.counts["excluded_pixels"] = excluded_pixels;
  if (excluding > 0)
    record.note(fmt::format("excluded by masks, by alphas or for want of data: {} pixels of {} photos",
                            results::readable_count(excluded_pixels), excluding));
  record.end(fmt::format("{} views", in.used.size()));
}

// True for the methods that must agree with the oracle: gpvc with the exact correction.
bool claims_to_be_exact(const visibility::VisibilityOptions& options) {
  const auto* paper = std::get_if<visibility::PaperGpvc>(&options.method);
  return paper != nullptr ? paper->correction == visibility::CoverageCorrection::exact
                          : std::holds_alternative<visibility::Gpvc>(options.method);
}

RunFacts visibility(const VisibilityCommandOptions& options, RunRecord& record, results::OutputFolder& folder) {
  const SceneInputData in = read_scene_input(options.input, record);
  folder.protect(input_files(in));
  const double bytes = bytes_of(in, options.ivm);
  folder.expect_space(bytes, bytes, record);
  const auto device = visibility::find_device(options.visibility, options.common.device);
  if (device) record.detail(fmt::format("device: {} ({})", device->info().renderer, device->info().driver));
  evaluate::OracleCheck check(in.used, static_cast<std::size_t>(options.oracle_check));
  classify_views(in, options, device.get(), folder, record, check);
  record.counts["meshes"] = meshes_json(in);
  if (check.views() > 0) {
    record.console.result(check.report());
    evaluate::write_json(folder.file("oracle.json"), check.json());
  }
  evaluate::write_views_json(folder.file("views.json"), in.scene, in.used, in.held_out);
  Json json = scene_json(options.input);
  json.update(settings_json(options.visibility));
  json["ivm"] = options.ivm;
  json["oracle_check"] = options.oracle_check;
  RunFacts facts{json, evaluate::device_json(device ? std::optional(device->info()) : std::nullopt)};
  if (claims_to_be_exact(options.visibility) && check.disagreements() > 0)
    facts.failure =
        fmt::format("{}: {} faces without a tie are classed otherwise than by the oracle; please report this scene",
                    (options.out / "oracle.json").string(), check.disagreements());
  return facts;
}

}  // namespace

void run_visibility(const VisibilityCommandOptions& options, Console& console) {
  run_command("visibility", options, console,
              [&](RunRecord& record, results::OutputFolder& folder) { return visibility(options, record, folder); });
}

}  // namespace gpvc::cli
