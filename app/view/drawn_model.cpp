#include "app/view/drawn_model.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>

#include "app/evaluate/scene_json.h"
#include "io/box.h"
#include "io/morton.h"
#include "io/vector.h"

namespace gpvc::view {
namespace {

constexpr std::uint32_t kBlockFaces = 1u << 15;

// Pages one after the other, each along a Morton curve, so that blocks are compact.
std::vector<std::uint32_t> drawing_order(const Mesh& mesh, const io::TexturedModel& model, const Box& box) {
  std::vector<std::uint64_t> place(mesh.faces.size());
  const MortonCurve curve(box);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, place.size()), [&](const auto& range) {
    for (std::size_t f = range.begin(); f < range.end(); ++f) place[f] = curve.at(mesh.positions[mesh.faces[f][0]]);
  });
  std::vector<std::uint32_t> order(mesh.faces.size());
  std::iota(order.begin(), order.end(), 0u);
  tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(model.face_page[a], place[a], a) < std::tuple(model.face_page[b], place[b], b);
  });
  return order;
}

// Per face bit i: the edge from corner i to the next has another photo behind it, or nothing.
std::vector<std::uint8_t> seam_bits(const Mesh& mesh, std::span<const std::int32_t> labels) {
  struct Side {
    std::uint64_t edge;
    std::uint32_t face;
    std::uint8_t bit;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
    for (std::uint8_t i = 0; i < 3; ++i) {
      const std::uint64_t a = mesh.faces[f][i], b = mesh.faces[f][(i + 1u) % 3u];
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), f, static_cast<std::uint8_t>(1u << i)});
    }
  tbb::parallel_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge < b.edge; });
  std::vector<std::uint8_t> bits(mesh.faces.size(), 0);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    bool differs = false;
    for (; end < sides.size() && sides[end].edge == sides[i].edge; ++end)
      differs |= labels[sides[end].face] != labels[sides[i].face];
    for (; i < end; ++i)
      if (differs) bits[sides[i].face] = static_cast<std::uint8_t>(bits[sides[i].face] | sides[i].bit);
  }
  return bits;
}

void add_block(DrawnModel& drawn, std::uint32_t page, std::uint32_t first, std::uint32_t end) {
  DrawnBlock block{page, first, end - first, {}, 0};
  std::array<float, 3> low{}, high{};
  for (std::size_t i = 3 * std::size_t{first}; i < 3 * std::size_t{end}; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const float value = drawn.positions[3 * i + k];
      low[k] = i == 3 * std::size_t{first} ? value : std::min(low[k], value);
      high[k] = i == 3 * std::size_t{first} ? value : std::max(high[k], value);
    }
  for (std::size_t k = 0; k < 3; ++k) block.middle[k] = (low[k] + high[k]) / 2;
  block.radius = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2;
  drawn.blocks.push_back(block);
}

template <typename T>
void append(std::string& bytes, const std::vector<T>& values) {
  bytes.resize((bytes.size() + 7) / 8 * 8, '\0');
  const std::size_t at = bytes.size();
  bytes.resize(at + values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(bytes.data() + at, values.data(), values.size() * sizeof(T));
}

}  // namespace

DrawnModel drawn_model(const Mesh& mesh, const io::TexturedModel& model, std::span<const std::int32_t> labels) {
  DrawnModel drawn;
  const Box box = box_of(mesh);
  drawn.origin = (box.low + box.high) * 0.5;
  drawn.faces = drawing_order(mesh, model, box);
  const std::size_t count = drawn.faces.size();
  const bool wide = std::ranges::any_of(
      model.texcoords, [](const io::TexCoord& at) { return !(at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1); });
  drawn.positions.resize(9 * count);
  (wide ? drawn.wide_uv : (drawn.uv.resize(6 * count), drawn.wide_uv)).resize(wide ? 6 * count : 0);
  const std::vector<std::uint8_t> bits = labels.empty() ? std::vector<std::uint8_t>{} : seam_bits(mesh, labels);
  drawn.seams.resize(count, 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      const std::uint32_t f = drawn.faces[n];
      if (!bits.empty()) drawn.seams[n] = bits[f];
      for (std::size_t i = 0; i < 3; ++i) {
        const WorldPoint p = mesh.positions[mesh.faces[f][i]] - drawn.origin;
        float* to = &drawn.positions[9 * n + 3 * i];
        to[0] = static_cast<float>(p.x), to[1] = static_cast<float>(p.y), to[2] = static_cast<float>(p.z);
        const io::TexCoord at =
            model.face_page[f] == io::kNoPage ? io::TexCoord{} : model.texcoords[model.face_texcoords[f][i]];
        const float uv[2] = {at.u, at.v};
        for (std::size_t k = 0; k < 2; ++k) {
          if (wide)
            drawn.wide_uv[6 * n + 2 * i + k] = uv[k];
          else
            drawn.uv[6 * n + 2 * i + k] = static_cast<std::uint16_t>(std::lround(uv[k] * 65535));
        }
      }
    }
  });
  for (std::uint32_t first = 0; first < count;) {
    const std::uint32_t page = model.face_page[drawn.faces[first]];
    std::uint32_t end = first;
    while (end < count && end - first < kBlockFaces && model.face_page[drawn.faces[end]] == page) ++end;
    add_block(drawn, page, first, end);
    first = end;
  }
  return drawn;
}

std::string bytes_of(const DrawnModel& model) {
  evaluate::Json json = {{"faces", model.faces.size()},
                         {"origin", evaluate::point_json(model.origin)},
                         {"wide_uv", !model.wide_uv.empty()},
                         {"blocks", evaluate::Json::array()}};
  for (const DrawnBlock& block : model.blocks)
    json["blocks"].push_back({{"page", block.page == io::kNoPage ? -1 : static_cast<std::int64_t>(block.page)},
                              {"first", block.first},
                              {"count", block.count},
                              {"middle", block.middle},
                              {"radius", block.radius}});
  const std::string text = json.dump();
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string bytes(sizeof length, '\0');
  std::memcpy(bytes.data(), &length, sizeof length);
  bytes += text;
  append(bytes, model.faces);
  append(bytes, model.positions);
  append(bytes, model.uv);
  append(bytes, model.wide_uv);
  append(bytes, model.seams);
  return bytes;
}

std::vector<float> in_drawing_order(const DrawnModel& model, std::span<const float> by_face) {
  std::vector<float> values(model.faces.size());
  for (std::size_t n = 0; n < values.size(); ++n) values[n] = by_face[model.faces[n]];
  return values;
}

}  // namespace gpvc::view
