#include <fmt/format.h>

#include "app/cli/run_record.h"
#include "io/mesh.h"
#include "io/npy.h"

namespace gpvc::cli {
namespace {

RunFacts label(const LabelOptions& options, RunRecord& record, pipeline::OutputFolder& folder,
               labeling::Selection& selection) {
  folder.protect({options.mesh, options.costs});
  record.begin({"read"});
  const Mesh mesh = io::read_mesh(options.mesh);
  const labeling::CostTable table = labeling::read_costs(options.costs);
  if (table.faces() != mesh.faces.size())
    throw InputError(options.costs, "",
                     fmt::format("has costs for {} faces, the mesh has {}", table.faces(), mesh.faces.size()));
  record.end(fmt::format("{} faces, {} candidates", pipeline::readable_count(table.faces()),
                         pipeline::readable_count(table.costs.size())));
  const labeling::FaceGraph graph = pipeline::weighed_graph(mesh, options.edge_weights, record);
  record.counts = {
      {"faces", mesh.faces.size()}, {"candidates", table.costs.size()}, {"adjacent_pairs", graph.edges.size()}};
  selection = pipeline::choose(table, graph, options.solver, record);
  io::write_npy_as<std::int32_t>(folder.file("labels.npy"), selection.labels);
  return {{{"costs", options.costs.string()},
           {"mesh", options.mesh.string()},
           {"smoothness", options.solver.smoothness},
           {"edge_weights", name_of(labeling::kEdgeWeightsNames, options.edge_weights)},
           {"max_sweeps", options.solver.max_sweeps}}};
}

}  // namespace

void run_label(const LabelOptions& options, Console& console) {
  labeling::Selection selection;
  run_command("label", options, console, [&](RunRecord& record, pipeline::OutputFolder& folder) {
    return label(options, record, folder, selection);
  });
  console.result(fmt::format("energy {:.3f}, {} differing pairs, {} patches", selection.energy,
                             selection.differing_pairs, selection.patches));
}

}  // namespace gpvc::cli
