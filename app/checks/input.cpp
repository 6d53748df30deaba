#include "app/checks/input.h"

#include <fmt/format.h>

#include "app/checks/frame_check.h"
#include "app/checks/mesh_frame.h"
#include "app/checks/nearness.h"
#include "io/error.h"
#include "io/validate.h"

namespace gpvc::checks {

void validate(const Input& input) { gpvc::validate(input.scene, input.mesh, input.views); }

void check_input(const Input& input, results::Observer& observer) {
  check_frames(input.mesh, input.mesh_file, input.scene, input.views);
  const std::string winding = check_winding(back_share(input.mesh, input.scene, input.views), input.mesh_file);
  if (!winding.empty()) observer.warning(winding);
  constexpr std::size_t kVertices = 2000;
  const std::string scale =
      check_scale(input.mesh, sampling_distances(input.mesh, input.scene, input.views, kVertices), input.mesh_file);
  const std::string lenses = check_lenses(input.scene, input.views);
  for (const std::string& warning : {scale, lenses})
    if (!warning.empty()) observer.warning(warning);
}

void match(Scene& scene, Mesh& mesh, std::span<const ViewId> used, const MeshOrigin& origin,
           results::Observer& observer) {
  const Remark assumed = match_frames(scene, mesh, used, origin.file, origin.crs);
  if (!assumed.text.empty()) observer.warning(assumed.text, assumed.cures);
  set_nearness(scene, mesh);
}

void prepare(Scene& scene, Mesh& mesh, std::span<const ViewId> used, const MeshOrigin& origin,
             results::Observer& observer) {
  match(scene, mesh, used, origin, observer);
  try {
    check_input({scene, mesh, used, origin.file}, observer);
  } catch (const InputError& error) {
    const Remark ways = ways_out(scene);
    if (ways.text.empty() || !origin.crs.empty()) throw;
    throw Error(fmt::format("{}; {}", error.what(), ways.text), ways.cures, error.measures());
  }
}

}  // namespace gpvc::checks
