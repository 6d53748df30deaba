// For programs without an option that traces rays, in the place of ray_mesh.cpp, with which Embree would come: half of what others
// need beside such a program.
#include <stdexcept>

#include "visibility/baselines/ray_mesh.h"

namespace gpvc::visibility {

namespace {
[[noreturn]] void refuse() { throw std::logic_error("this program traces no rays"); }
}  // namespace

RayMesh::RayMesh(const Mesh&) { refuse(); }
std::size_t RayMesh::first_depths(const PreparedView&, const Pose&, std::vector<float>&) const { refuse(); }
RayMesh::Target RayMesh::target(const WorldPoint&, const Pose&) const { refuse(); }
void RayMesh::trace(const Pose&, double, std::span<Target>) const { refuse(); }

}  // namespace gpvc::visibility
