#include <fmt/format.h>

#include <algorithm>

#include "app/scene_input.h"

namespace gpvc {
namespace {

void write_classes(const std::filesystem::path& file, const std::vector<FaceClass>& classes) {
  std::vector<std::uint8_t> codes;
  for (const FaceClass c : classes) codes.push_back(static_cast<std::uint8_t>(c));
  const std::size_t shape = codes.size();
  write_npy(file, codes, std::span(&shape, 1));
}

void write_ivm(const std::filesystem::path& file, const Ivm& ivm) {
  std::vector<std::uint32_t> faces;
  for (const FaceId face : ivm.faces) faces.push_back(static_cast<std::uint32_t>(face));
  const std::size_t shape[2] = {static_cast<std::size_t>(ivm.height), static_cast<std::size_t>(ivm.width)};
  write_npy(file, faces, shape);
}

struct Totals {
  std::size_t full = 0, partial = 0, hidden = 0, unresolved = 0, samples = 0, corrected = 0;
  double seconds = 0;
};

std::string table_head(std::size_t name_width) {
  return fmt::format("{:{}}  {:>9} {:>9} {:>9} {:>10} {:>11} {:>9} {:>8} {:>8} {:>8}", "view", name_width,
                     "full", "partial", "hidden", "unresolved", "samples", "corrected", "render s", "read s",
                     "class s");
}

std::string table_row(const std::string& name, std::size_t name_width, const Totals& t,
                      const VisibilityStatistics& s) {
  return fmt::format("{:{}}  {:>9} {:>9} {:>9} {:>10} {:>11} {:>9} {:>8.3f} {:>8.3f} {:>8.3f}", name,
                     name_width, t.full, t.partial, t.hidden, t.unresolved, t.samples, t.corrected,
                     s.render_s, s.readback_s, s.classify_s);
}

Totals totals_of(const ViewVisibility& view) {
  Totals t;
  const auto count = [&](FaceClass c) {
    return static_cast<std::size_t>(std::count(view.classes.begin(), view.classes.end(), c));
  };
  t.full = count(FaceClass::full);
  t.partial = count(FaceClass::partial);
  t.hidden = count(FaceClass::hidden);
  t.unresolved = count(FaceClass::unresolved);
  t.samples = view.statistics.samples;
  t.corrected = view.statistics.corrected_samples;
  return t;
}

void classify_views(const SceneInputData& in, const VisibilityCommandOptions& options, GraphicsDevice& device,
                    OutputFolder& folder, Console& console, RunRecord& record) {
  Stage stage(console, record, "visibility", "views");
  VisibilityStage visibility(device, in.mesh, options.visibility);
  console.note("classifier: " + visibility.classifier_note());
  record.counts["classifier"] = visibility.classifier_note();
  std::size_t name_width = 5;
  for (const ViewId id : in.used) name_width = std::max(name_width, in.scene.views[index(id)].name.size());
  console.result(table_head(name_width));
  Totals all;
  VisibilityStatistics times;
  for (std::size_t n = 0; n < in.used.size(); ++n) {
    stage.progress(n, in.used.size());
    const View& view = in.scene.views[index(in.used[n])];
    const ViewVisibility seen = visibility.classify(view, in.used[n]);
    write_classes(folder.file("visibility/" + contained_path(view.name).generic_string() + ".npy"),
                  seen.classes);
    if (options.ivm)
      write_ivm(folder.file("ivm/" + contained_path(view.name).generic_string() + ".npy"), seen.ivm);
    const Totals t = totals_of(seen);
    console.result(table_row(view.name, name_width, t, seen.statistics));
    all.full += t.full;
    all.partial += t.partial;
    all.hidden += t.hidden;
    all.unresolved += t.unresolved;
    all.samples += t.samples;
    all.corrected += t.corrected;
    times.render_s += seen.statistics.render_s;
    times.upload_s += seen.statistics.upload_s;
    times.readback_s += seen.statistics.readback_s;
    times.classify_s += seen.statistics.classify_s;
  }
  console.result(table_row("all", name_width, all, times));
  stage.add("render_s", times.render_s);
  stage.add("upload_s", times.upload_s);
  stage.add("readback_s", times.readback_s);
  stage.add("classify_s", times.classify_s);
  record.counts.update({{"full", all.full},
                        {"partial", all.partial},
                        {"hidden", all.hidden},
                        {"unresolved", all.unresolved},
                        {"samples", all.samples},
                        {"corrected_samples", all.corrected}});
  stage.finish(fmt::format("{} views", in.used.size()));
}

void visibility(const VisibilityCommandOptions& options, OutputFolder& folder, Console& console) {
  RunRecord record;
  const SceneInputData in = read_scene_input(options.input, console, record);
  GraphicsDevice device(options.common.device);
  console.detail(fmt::format("device: {} ({})", device.info().renderer, device.info().driver));
  classify_views(in, options, device, folder, console, record);
  write_views_json(folder.file("views.json"), in);
  Json json = scene_json(options.input);
  json.update(visibility_json(options.visibility));
  json["ivm"] = options.ivm;
  write_run_json(folder, {"visibility", options.common, json, device_json(device.info())}, record);
}

}  // namespace

void run_visibility(const VisibilityCommandOptions& options, Console& console) {
  OutputFolder folder(options.out, options.force);
  try {
    visibility(options, folder, console);
    folder.publish();
  } catch (const OutputError& e) {
    throw std::runtime_error(folder.with_final_names(e.what()));
  }
}

}  // namespace gpvc
