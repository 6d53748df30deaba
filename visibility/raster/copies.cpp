#include "visibility/raster/copies.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <bit>
#include <utility>

#include "io/vector.h"

namespace gpvc::visibility {
namespace {

/// The same for the same corners in any order.
std::uint32_t hash_of(const Mesh& mesh, const Triangle& face) {
  std::uint64_t sum = 0;
  for (const std::uint32_t v : face) sum += position_hash(mesh.positions[v]);
  return static_cast<std::uint32_t>(sum >> 32);
}

/// The same corners in the same turn.
bool is_copy_of(const Mesh& mesh, const Triangle& face, const Triangle& earlier) {
  const auto same = [&](std::uint32_t a, std::uint32_t b) {
    const WorldPoint &p = mesh.positions[a], &q = mesh.positions[b];
    return a == b || (p.x == q.x && p.y == q.y && p.z == q.z);
  };
  for (std::size_t turn = 0; turn < 3; ++turn)
    if (same(face[0], earlier[turn]) && same(face[1], earlier[(turn + 1) % 3]) &&
        same(face[2], earlier[(turn + 2) % 3]))
      return true;
  return false;
}

struct Found {
  std::vector<std::uint32_t> copies;  ///< ascending
  std::vector<std::uint8_t> doubled;
};

/// A table with open addressing holds the faces that are no copies, so that all copies of a face find it at the same
/// place.
Found find(const Mesh& mesh) {
  const std::size_t faces = mesh.faces.size();
  std::vector<std::uint32_t> hashes(faces);
  Found found;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, faces, 4096), [&](const auto& range) {
    for (std::size_t f = range.begin(); f != range.end(); ++f) hashes[f] = hash_of(mesh, mesh.faces[f]);
  });
  constexpr std::uint32_t kFree = 0xFFFFFFFFU;
  constexpr std::size_t kAhead = 16;
  const std::size_t size = std::bit_ceil(2 * faces + 2);
  std::vector<std::uint32_t> table(size, kFree);
  const auto first_place = [&](std::size_t f) { return std::size_t{hashes[f]} & (size - 1); };
  for (std::size_t f = 0; f < faces; ++f) {
    if (f + kAhead < faces) __builtin_prefetch(&table[first_place(f + kAhead)], 1);
    const Triangle face = mesh.faces[f], turned{face[0], face[2], face[1]};
    std::size_t place = first_place(f);
    bool copy = false;
    for (; !copy && table[place] != kFree; place = (place + 1) & (size - 1)) {
      const std::uint32_t other = table[place];
      if (hashes[other] != hashes[f]) continue;
      copy = is_copy_of(mesh, face, mesh.faces[other]);
      if (copy || !is_copy_of(mesh, turned, mesh.faces[other])) continue;
      found.doubled.resize(faces, 0);
      found.doubled[f] = found.doubled[other] = 1;
    }
    if (copy)
      found.copies.push_back(static_cast<std::uint32_t>(f));
    else
      table[place] = static_cast<std::uint32_t>(f);
  }
  return found;
}

}  // namespace

Repeats find_repeats(const Mesh& mesh) {
  Found found = find(mesh);
  Repeats repeats{std::nullopt, std::move(found.doubled)};
  if (found.copies.empty()) return repeats;
  repeats.collapsed = mesh;
  for (const std::uint32_t copy : found.copies) {
    Triangle& face = repeats.collapsed->faces[copy];
    face = {face[0], face[0], face[0]};
    if (!repeats.doubled.empty()) repeats.doubled[copy] = 0;
  }
  return repeats;
}

}  // namespace gpvc::visibility
