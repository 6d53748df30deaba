#include "app/texrecon/texrecon.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <future>
#include <new>
#include <numeric>
#include <optional>

#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/pipeline/bake_into.h"
#include "app/pipeline/steps.h"
#include "app/texrecon/model_files.h"
#include "app/texrecon/report.h"
#include "app/texrecon/view_numbers.h"
#include "app/texrecon/view_selection.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/output_file.h"
#include "io/photos.h"
#include "io/scene_files.h"

namespace gpvc::texrecon {
namespace {

constexpr int kFailed = 1, kInterrupted = 130, kOutOfMemory = 137;

struct SceneAndMesh {
  Scene scene;
  Mesh mesh;
};

SceneAndMesh read_input(const Arguments& arguments, Report& report) {
  report.begin({"read"});
  auto reading = std::async(std::launch::async, [&] { return io::read_mesh(arguments.mesh); });
  SceneAndMesh in;
  in.scene = io::read_scene(arguments.scene, {});
  in.mesh = reading.get();
  for (const std::vector<std::string>* warnings : {&in.scene.warnings, &in.mesh.warnings})
    for (const std::string& warning : *warnings) report.warning(warning);
  if (const std::size_t redundant = remove_redundant_faces(in.mesh); redundant > 0)
    report.note(fmt::format("{} faces are left out that have the vertices of a later one", redundant));
  const std::vector<ViewId> views = all_views(in.scene);
  checks::prepare(in.scene, in.mesh, views, {arguments.mesh, {}}, report);
  report.end(fmt::format("{} faces, {} views", results::readable_count(in.mesh.faces.size()), views.size()));
  return in;
}

/// Per face a view, of the labels file or by the costs of the costs file; empty without either.
std::vector<ViewId> given_labels(const Arguments& arguments, const Mesh& mesh, const ViewNumbers& numbers,
                                 Report& report) {
  if (!arguments.labels.empty()) return read_labels(arguments.labels, mesh.faces.size(), numbers);
  if (arguments.data_costs.empty()) return {};
  const labeling::CostTable table = labeling::read_costs(arguments.data_costs);
  if (table.faces() != mesh.faces.size())
    throw InputError(arguments.data_costs, "",
                     fmt::format("has costs for {} faces, the mesh has {}", table.faces(), mesh.faces.size()));
  const labeling::FaceGraph graph = pipeline::weighed_graph(mesh, labeling::EdgeWeights::uniform, report);
  std::vector<ViewId> labels = pipeline::choose(table, graph, {}, report).labels;
  for (ViewId& label : labels) {
    if (label == kNoView) continue;
    if (index(label) >= numbers.count())
      throw InputError(arguments.data_costs, "",
                       fmt::format("has costs of view {}, the scene has {} views", index(label), numbers.count()));
    label = numbers.view(index(label) + 1);
  }
  return labels;
}

}  // namespace

std::size_t remove_redundant_faces(Mesh& mesh) {
  const auto vertices = [&](std::uint32_t face) {
    Triangle t = mesh.faces[face];
    std::ranges::sort(t);
    return t;
  };
  std::vector<std::uint32_t> order(mesh.faces.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, vertices);
  std::vector<std::uint8_t> redundant(mesh.faces.size(), 0);
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < order.size(); ++i)
    if (vertices(order[i]) == vertices(order[i + 1])) {
      redundant[order[i]] = 1;
      ++count;
    }
  if (count == 0) return 0;
  std::size_t kept = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    if (redundant[face] != 0) continue;
    if (!mesh.source_face.empty()) mesh.source_face[kept] = mesh.source_face[face];
    mesh.faces[kept++] = mesh.faces[face];
  }
  mesh.faces.resize(kept);
  if (!mesh.source_face.empty()) mesh.source_face.resize(kept);
  return count;
}

namespace {

/// Per vertex 1 if an edge of one face alone ends there; only about vertices that are `wanted`.
std::vector<std::uint8_t> on_border(const Mesh& mesh, const std::vector<std::uint8_t>& wanted) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const Triangle& t : mesh.faces)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (wanted[a] != 0 || wanted[b] != 0) edges.push_back({std::min(a, b), std::max(a, b)});
    }
  std::ranges::sort(edges);
  std::vector<std::uint8_t> border(mesh.positions.size(), 0);
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    for (end = i + 1; end < edges.size() && edges[end] == edges[i]; ++end) continue;
    if (end == i + 1) border[edges[i][0]] = border[edges[i][1]] = 1;
  }
  return border;
}

}  // namespace

std::vector<std::uint8_t> written_faces(const Mesh& mesh, const labeling::FaceGraph& graph,
                                        std::span<const labeling::FaceTag> tags, bool keep_unseen, bool fill_holes) {
  std::vector<std::uint8_t> written(mesh.faces.size(), 1);
  if (keep_unseen) return written;
  std::vector<std::uint8_t> of_hole(mesh.positions.size(), 0);
  for (std::size_t face = 0; face < tags.size(); ++face) {
    written[face] = labeling::has_candidates(tags[face]) ? 1 : 0;
    if (written[face] == 0)
      for (const std::uint32_t vertex : mesh.faces[face]) of_hole[vertex] = 1;
  }
  if (!fill_holes) return written;
  // Connected areas of faces that no photo shows: each face knows another of its area, the first one itself.
  std::vector<std::uint32_t> area(mesh.faces.size());
  std::iota(area.begin(), area.end(), 0U);
  const auto first = [&](std::uint32_t face) {
    while (area[face] != face) face = area[face] = area[area[face]];
    return face;
  };
  for (const auto& [a, b] : graph.edges) {
    if (written[a] != 0 || written[b] != 0) continue;
    const std::uint32_t of_a = first(a), of_b = first(b);
    area[std::max(of_a, of_b)] = std::min(of_a, of_b);
  }
  constexpr std::uint32_t kMostFaces = 2000;  // as stock texrecon, which fills areas of up to 1000 vertices
  const std::vector<std::uint8_t> border = on_border(mesh, of_hole);
  std::vector<std::uint32_t> faces_of(mesh.faces.size(), 0);
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    if (written[face] != 0) continue;
    const bool at_border = std::ranges::any_of(mesh.faces[face], [&](std::uint32_t v) { return border[v] != 0; });
    faces_of[first(face)] += at_border ? kMostFaces + 1 : 1;
    if (faces_of[first(face)] > kMostFaces) faces_of[first(face)] = kMostFaces + 1;
  }
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face)
    if (written[face] == 0 && faces_of[first(face)] <= kMostFaces) written[face] = 1;
  return written;
}

void run(const Arguments& arguments) {
  Report report;
  PrefixedFiles files(arguments.prefix);
  const cli::EndsSoonAfterSignal ends([&] { files.discard(); });
  const SceneAndMesh in = read_input(arguments, report);
  const std::vector<ViewId> views = all_views(in.scene);
  const pipeline::Input input{in.scene, in.mesh, views, arguments.mesh};
  const pipeline::Settings settings = settings_of(arguments);
  const ViewNumbers numbers(in.scene);
  const std::vector<ViewId> given = given_labels(arguments, in.mesh, numbers, report);
  io::PhotoCache decoded(in.scene);
  const pipeline::MemoryPlan memory = pipeline::plan_memory(input, settings);
  io::CoarsePhotos photos = pipeline::with_coarse_photos({input, settings, decoded, report}, memory.work,
                                                         memory.work.texels * 3, files.folder());
  const pipeline::Run run{input, settings, photos, report};
  pipeline::Choice chosen = pipeline::see_and_choose(run, memory, {}, {}, given);
  if (arguments.intermediate_results && arguments.labels.empty())
    write_labels(files.file("_labeling.vec"), chosen.selection.labels, numbers);
  io::write_file(files.file(".conf"), conf_text(arguments));

  const std::vector<std::uint8_t> written =
      written_faces(in.mesh, chosen.graph, chosen.seen.candidates.tags, arguments.keep_unseen || arguments.nadir,
                    arguments.hole_filling);
  ModelFiles model(files, "", written,
                   {in.scene.bands.has_value(), io::is_grey(in.scene.views[index(numbers.view(1))].photo),
                    arguments.tone_mapping == ToneMapping::gamma});
  const atlas::AtlasInput from =
      pipeline::atlas_input(input, run.photos, chosen.graph, chosen.seen, chosen.selection.labels);
  pipeline::bake_into(run, from, pipeline::with_coverage(memory, chosen.seen.coverage),
                      {.scratch_folder = files.folder()}, &model);
  if (arguments.view_selection_model) write_view_selection(files, in.mesh, chosen.selection.labels, numbers, written);
  if (arguments.timings) io::write_file(files.file("_timings.csv"), report.timings());
  files.publish();
  report.finish(arguments.prefix.string() + ".obj");
}

int run_command_line(int argc, char** argv) {
  cli::install_signal_handlers();
  const auto complain = [](const std::string& what) {
    std::fflush(stdout);
    std::fprintf(stderr, "gpvc-texrecon: error: %s\n", results::printable(what).c_str());
  };
  try {
    Arguments arguments;
    const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    switch (read_arguments(words, arguments)) {
      case Request::help:
        std::fputs(help_text().c_str(), stdout);
        return 0;
      case Request::version:
        std::printf("gpvc-texrecon %s\n", cli::program_version().c_str());
        return 0;
      case Request::run:
        break;
    }
    std::optional<tbb::global_control> limit;
    if (arguments.threads > 0)
      limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(arguments.threads));
    run(arguments);
    return 0;
  } catch (const UsageError& e) {
    complain(std::string(e.what()) + "\nTry 'gpvc-texrecon --help'.");
  } catch (const Cancelled&) {
    complain("interrupted; nothing was written");
    return kInterrupted;
  } catch (const std::bad_alloc&) {
    complain("out of memory");
    return kOutOfMemory;
  } catch (const pipeline::MemoryError& e) {
    complain(e.what());
    return kOutOfMemory;
  } catch (const std::filesystem::filesystem_error& e) {
    complain(e.path1().empty() ? e.what() : e.path1().string() + ": " + e.code().message());
  } catch (const std::exception& e) {
    complain(e.what());
  }
  return kFailed;
}

}  // namespace gpvc::texrecon
