// A textured mesh as the page draws it: faces page by page, and near each other, in arrays that go to the graphics card as they are.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/textured_model.h"

namespace gpvc::view {

/// Consecutive faces that one call draws.
struct DrawnBlock {
  std::uint32_t page = io::kNoPage;
  std::uint32_t first = 0, count = 0;  ///< faces in drawing order
  std::array<float, 3> middle{};       ///< of a sphere around them, less the model's origin
  float radius = 0;
};

/// Corners are listed face by face, since a face's number then follows from the corner's, and values of faces are looked up by it.
struct DrawnModel {
  WorldPoint origin;  ///< in doubles; positions are floats from there, to 1e-7 of the mesh's extent
  std::vector<DrawnBlock> blocks;
  std::vector<std::uint32_t> faces;  ///< per drawn face its number in the mesh
  std::vector<float> positions;      ///< 9 a face
  std::vector<std::uint16_t> uv;     ///< 6 a face, in 1/65535 of the page; empty where faces reach beyond theirs
  std::vector<float> wide_uv;        ///< 6 a face, where some do
  std::vector<std::uint8_t>
      seams;  ///< per drawn face bit i: another photo textures the face across the edge from corner i
};

/// \param labels per face of the mesh its photo; empty: unknown, and there are no seams. O(faces log faces), TBB.
DrawnModel drawn_model(const Mesh& mesh, const io::TexturedModel& model, std::span<const std::int32_t> labels);

/// Its bytes: the length of a JSON text as 32 bits, the text (README, "How the page draws"), zeros up to a multiple of 8, then faces,
/// positions, texture coordinates and seams, each from a multiple of 8 on.
std::string bytes_of(const DrawnModel& model);

/// Values by face of the mesh in drawing order.
std::vector<float> in_drawing_order(const DrawnModel& model, std::span<const float> by_face);

}  // namespace gpvc::view
