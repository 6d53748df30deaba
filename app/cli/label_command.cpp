// gpvc label: view selection from stored costs.
#include <fmt/format.h>

#include "app/cli/run_record.h"
#include "app/cli/setting_options.h"
#include "io/mesh.h"
#include "io/npy.h"

namespace gpvc::cli {

void run_label(const LabelOptions& options, Console& console) {
  run_command("label", options, console, [&](RunRecord& record, results::OutputFolder& folder) -> RunFacts {
    folder.protect({options.mesh, options.costs});
    record.begin({"read"});
    const Mesh mesh = io::read_mesh(options.mesh);
    const labeling::CostTable table = labeling::read_costs(options.costs);
    if (table.faces() != mesh.faces.size())
      throw InputError(options.costs, "",
                       fmt::format("has costs for {} faces, the mesh has {}", table.faces(), mesh.faces.size()));
    record.end(fmt::format("{} faces, {} candidates", results::readable_count(table.faces()),
                           results::readable_count(table.costs.size())));
    const labeling::FaceGraph graph = pipeline::weighed_graph(mesh, options.settings.edge_weights, record);
    record.counts = {
        {"faces", mesh.faces.size()}, {"candidates", table.costs.size()}, {"adjacent_pairs", graph.edges.size()}};
    const labeling::Selection selection = pipeline::choose(table, graph, options.settings.solver, record);
    io::write_npy_as<std::int32_t>(folder.file("labels.npy"), selection.labels);
    Json made = {{"costs", options.costs.string()}, {"mesh", options.mesh.string()}};
    made.update(settings_json(options.settings, [](const pipeline::OptionInfo& info) {
      using std::string_view_literals::operator""sv;
      return info.name == "smoothness"sv || info.name == "edge-weights"sv || info.name == "max-sweeps"sv ||
             info.name == "thorough"sv;
    }));
    return {.options = std::move(made),
            .result = fmt::format("energy {:.3f}, {} differing pairs, {} patches", selection.energy,
                                  selection.differing_pairs, selection.patches)};
  });
}

}  // namespace gpvc::cli
