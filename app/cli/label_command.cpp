#include <fmt/format.h>

#include "app/cli/scene_input.h"

namespace gpvc::cli {

void run_label(const LabelOptions& options, Console& console) {
  RunRecord record;
  pipeline::OutputFolder folder(options.out, options.force, "label");
  try {
    folder.protect({options.mesh, options.costs});
    Stage reading(console, record, "read");
    const Mesh mesh = io::read_mesh(options.mesh);
    const labeling::CostTable table = labeling::read_costs(options.costs);
    if (table.faces() != mesh.faces.size())
      throw InputError(options.costs, "",
                       fmt::format("has costs for {} faces, the mesh has {}", table.faces(), mesh.faces.size()));
    labeling::FaceGraph graph = labeling::face_graph(mesh);
    labeling::weigh_edges(mesh, options.edge_weights, graph);
    reading.finish(
        fmt::format("{} faces, {} candidates", readable_count(table.faces()), readable_count(table.costs.size())));

    Stage solving(console, record, "view selection", "sweeps", true);
    const labeling::Selection selection = labeling::select_views(table, graph, options.solver, solving.reporter());
    for (const labeling::SweepReport& sweep : selection.sweeps)
      console.detail(fmt::format("  sweep {}: energy {:.1f}, {:.2f} s", sweep.sweep, sweep.energy, sweep.seconds));
    solving.finish(fmt::format("{} sweeps", selection.sweeps.size()));

    std::vector<std::int32_t> labels;
    for (const ViewId label : selection.labels)
      labels.push_back(static_cast<std::int32_t>(static_cast<std::uint32_t>(label)));
    const std::size_t shape = labels.size();
    io::write_npy(folder.file("labels.npy"), labels, std::span(&shape, 1));
    record.counts = {{"faces", mesh.faces.size()},
                     {"candidates", table.costs.size()},
                     {"adjacent_pairs", graph.edges.size()},
                     {"energy", selection.energy},
                     {"differing_pairs", selection.differing_pairs},
                     {"patches", selection.patches},
                     {"sweeps", selection.sweeps.size()}};
    const Json facts = {{"costs", options.costs.string()},
                        {"mesh", options.mesh.string()},
                        {"smoothness", options.solver.smoothness},
                        {"edge_weights", name_of(labeling::kEdgeWeightsNames, options.edge_weights)},
                        {"max_sweeps", options.solver.max_sweeps}};
    write_run_json(folder, {"label", options.common, facts}, record);
    folder.publish();
    console.result(fmt::format("energy {:.3f}, {} differing pairs, {} patches", selection.energy,
                               selection.differing_pairs, selection.patches));
  } catch (const OutputError& e) {
    throw std::runtime_error(folder.with_final_names(e.what()));
  }
}

}  // namespace gpvc::cli
